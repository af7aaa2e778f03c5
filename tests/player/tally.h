/* SPDX-License-Identifier: Apache-2.0 */
/* What the programs that play cases have in common: their options, and the count of what passed. */
#ifndef RULES_TALLY_H
#define RULES_TALLY_H

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include "tests/fixture/platform.h"
#include "vuid-tables/rules.h"

enum outcome { OUTCOME_PASSED, OUTCOME_FAILED, OUTCOME_SKIPPED };

enum { TALLY_REASONS_MAX = 64 };

/* The level of that name in the layer's settings; LEVEL_COUNT if there is none. */
enum level level_named(const char *name);

struct tally {
    const char *filter; /* part of the names to be played, or after "!" not played; NULL: all */
    bool list, verbose;
    bool misaligns;     /* --misaligned */
    bool fails;         /* --fail: debug_action = fail skips calls, and callbacks don't */
    const char *level;  /* that all is played at; NULL: at its own */
    FILE *results;      /* NULL: none wanted */
    int argument_count; /* of the program, which plays a case again with a filter for it */
    char **arguments;
    uint32_t passed, failed, skipped;
    struct {
        char text[128];
        uint32_t count;
    } reasons[TALLY_REASONS_MAX]; /* for skipping */
};

/* Reads [--filter [!]NAME] [--list] [--verbose] [--results FILE] [--level NAME] from argument 2 on,
 * and opens the platform that argument 1 names. Returns 0, or the exit status of the program of
 * this usage, which it has explained. */
int tally_open(struct tally *tally, struct platform *platform, int argc, char **argv,
               const char *usage);

/* Whether a test of this name is to be run now; those that are listed are not. */
bool tally_starts(const struct tally *tally, const char *name);

/* Writes a line of results: that a rule's id was `word`, or failed. */
void tally_write(const struct tally *tally, const struct platform *platform, const char *name,
                 enum build_command command, const char *id, const char *word);
/* A word for a build command, or the name of another one. */
const char *command_word(enum build_command command);

/* `text` tells why it failed or was skipped. */
void tally_count(struct tally *tally, enum outcome outcome, const char *name, const char *text);

/* Prints the count and closes the results. Returns the exit status. */
int tally_close(struct tally *tally);

#endif
