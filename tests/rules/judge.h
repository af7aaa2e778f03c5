/* SPDX-License-Identifier: Apache-2.0 */
/* What programs that play cases have in common: fixtures, mutations, and what is expected of
 * messages. */
#ifndef RULES_JUDGE_H
#define RULES_JUDGE_H

#include "case.h"
#include "tally.h"

/* One way to play a case. */
struct play {
    const struct platform *platform;
    const struct test_case *test_case;
    enum build_command command;
    bool geometry_pointers; /* ppGeometries instead of pGeometries */
    const char *level;      /* NULL, or a setting instead of the case's own */
    bool is_mutation_alone; /* neither the valid call nor the twin is played */
};

enum { REPORT_TEXT_MAX = 16384 };

/* What came of it. */
struct report {
    enum outcome outcome;
    bool fired, stayed_silent;  /* as they should have */
    char text[REPORT_TEXT_MAX]; /* why it failed or was skipped */
};

/* The id that a rule has for a command, or NULL. */
const char *rule_id(enum rule rule, enum build_command command);

__attribute__((format(printf, 2, 3))) void judge_say(struct report *report, const char *format,
                                                     ...);
void judge_say_messages(const struct fixture *fixture, struct report *report);

/* The default one for NULL. */
const struct setup *judge_setup(const struct setup *setup);
/* Makes the world be as the setup asks. NULL, or why there is no such world here. */
const char *judge_enter_fixture(const struct play *play, struct fixture *fixture,
                                const struct setup *setup);
/* NULL, or what the world lacks for the case. */
const char *judge_cannot_play(const struct play *play, const struct fixture *fixture);

/* Whether the case has a valid call of its own, here. */
bool judge_has_twin(const struct play *play);

/* Whether the command takes no build of the case's kind. */
bool judge_is_refused(const struct play *play);

/* Whether the mutation breaks a rule of the case where the layer can see it: at the play's level.
 */
bool judge_expects(const struct play *play, enum rule rule);

/* Whether the world's messages are those that the case's mutation is to bring about. */
bool judge_messages(const struct play *play, const struct fixture *fixture, struct report *report);

/* Plays a case (play.c). `fixture` is reused from play to play; zero-initialized before the first,
 * closed after the last. */
void play_case(const struct play *play, struct fixture *fixture, struct report *report);

#endif
