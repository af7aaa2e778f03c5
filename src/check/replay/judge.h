/* SPDX-License-Identifier: Apache-2.0 */
/* The judge of a replay: validates one build that a journal holds, and reports findings together
 * with the command buffer and the build that they are about. Every finding of a replay goes through
 * it: those about updates, micromaps, sparse buffers and destroyed objects. */
#ifndef ASSAY_CHECK_REPLAY_JUDGE_H
#define ASSAY_CHECK_REPLAY_JUDGE_H

#include "src/check/replay/states.h"
#include "src/check/walk/walk.h"

/* A judge lives on its caller's stack, and must not be moved or copied: `walk` points into it. It
 * locks nothing and allocates nothing. */
struct judge {
    struct replay *replay;
    const struct journal *journal;
    uint32_t first_build;     /* of the call: its position in the command buffer */
    struct location location; /* of what is judged, in the call */
    struct check_context context;
    struct walk walk; /* wants all active rules of the command; reports what it finds */
};

/* Begins to judge the build of a call that is at `location`, and at `position` in the command
 * buffer of `journal`. Nothing has to be released. */
void judge_begin(struct judge *judge, struct replay *replay, const struct journal *journal,
                 uint32_t position, const struct location *location);

/* The same for an entry of kind JOURNAL_BUILD, JOURNAL_UPDATE or JOURNAL_USE_MICROMAP. */
void judge_begin_entry(struct judge *judge, struct replay *replay, const struct journal *journal,
                       const struct journal_entry *entry);

/* Reports a finding about the judge's own location, if `rule` is active. */
void judge_report(struct judge *judge, enum rule rule, const struct finding *finding);

#endif
