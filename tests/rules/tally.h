/* SPDX-License-Identifier: Apache-2.0 */
/* What the programs that play cases have in common: their options, and the count of what passed. */
#ifndef RULES_TALLY_H
#define RULES_TALLY_H

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

enum outcome { OUTCOME_PASSED, OUTCOME_FAILED, OUTCOME_SKIPPED };

enum { TALLY_REASONS_MAX = 64 };

struct tally {
    const char *filter; /* part of the names to be played; NULL: all */
    bool list, verbose;
    bool misaligns;    /* --misaligned */
    bool fails;        /* --fail: debug_action = fail skips calls, and callbacks don't */
    const char *level; /* that all is played at; NULL: at its own */
    FILE *results;     /* NULL: none wanted */
    uint32_t passed, failed, skipped;
    struct {
        char text[128];
        uint32_t count;
    } reasons[TALLY_REASONS_MAX]; /* for skipping */
};

/* Reads [--filter NAME] [--list] [--verbose] [--results FILE] [--level NAME] from argument 2 on;
 * false if it can't, or if the file can't be written. */
bool tally_read_arguments(struct tally *tally, int argc, char **argv);

/* `text` tells why it failed or was skipped. */
void tally_count(struct tally *tally, enum outcome outcome, const char *name, const char *text);

/* Prints the count and closes the results. Returns the exit status. */
int tally_close(struct tally *tally);

#endif
