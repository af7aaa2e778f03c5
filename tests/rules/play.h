/* SPDX-License-Identifier: Apache-2.0 */
/* Playing one case: on one command, in one form. */
#ifndef RULES_PLAY_H
#define RULES_PLAY_H

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

/* `world` is reused from play to play; zero-initialized before the first, closed after the last. */
void play_case(const struct play *play, struct world *world, struct report *report);

/* Whether the mutation breaks a rule of the case where the layer can see it: at the play's level.
 */
bool play_expects(const struct play *play, enum rule rule);

/* The id that a rule has for a command, or NULL. */
const char *rule_id(enum rule rule, enum build_command command);

#endif
