/* SPDX-License-Identifier: Apache-2.0 */
/* What messages say beside what is wrong: what to do, and which other ids the mistake violates. */
#ifndef ASSAY_TESTS_PLAYER_CALLS_WORDING_H
#define ASSAY_TESTS_PLAYER_CALLS_WORDING_H

#include "tests/player/calls/judge.h"

/* Returns whether each message has the hint of its row and counts that agree with their nouns, and
 * whether the messages of the case's first rule name the ids of the rules of `names`. */
bool wording_is_good(const struct play *play, const struct fixture *fixture, struct report *report);

/* A play of a case, with its first rule muted: the rules of `names` have messages of their own. */
struct muted_play {
    struct play play;
    struct test_case test_case;
    char name[192];
};

/* Makes that play. Returns false if the case names no rule for this command. `muted` must not
 * move. */
bool wording_mute(const struct play *play, struct muted_play *muted);

#endif
