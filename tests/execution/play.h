/* SPDX-License-Identifier: Apache-2.0 */
/* Playing one program for one difference on one command, or its twin. */
#ifndef EXECUTION_PLAY_H
#define EXECUTION_PLAY_H

#include "program.h"
#include "tally.h"

struct play {
    const struct platform *platform;
    const struct program *program;
    const struct difference *difference; /* NULL where the program is played once */
    enum build_command command;          /* of updates */
    bool is_twin;
    const char *level; /* NULL, or a setting; below execution nothing is reported */
};

enum { REPORT_TEXT_MAX = 16384 };

struct report {
    enum outcome outcome;
    char text[REPORT_TEXT_MAX]; /* why it failed or was skipped */
};

/* `world` is reused from play to play; zero-initialized before the first, closed after the last. */
void play_program(const struct play *play, struct fixture *fixture, struct report *report);

/* Whether the play's level sees what is broken. */
bool play_sees(const struct play *play);

/* Whether any step of it breaks rules. */
bool program_reports(const struct program *program);

/* The rules that a play is about. */
uint32_t play_rules(const struct play *play, enum rule rules[SHAPE_RULES]);

#endif
