/* SPDX-License-Identifier: Apache-2.0 */
/* What all that plays cases and programs has in common: the options, the count of what passed, and
 * which ids fired and stayed silent. */
#ifndef ASSAY_TESTS_PLAYER_TALLY_H
#define ASSAY_TESTS_PLAYER_TALLY_H

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include "tests/fixture/platform.h"
#include "tests/player/report.h"
#include "vuid-tables/rules.h"

enum { TALLY_REASONS_MAX = 64 };

/* The level of that name in the layer's settings; LEVEL_COUNT if there is none. */
enum level level_named(const char *name);

struct tally {
    struct platform platform;
    const char *filter; /* part of the names to be played, or after "!" not played; NULL: all */
    bool list, verbose;
    bool misaligns;     /* --misaligned */
    bool submits;       /* --submitted */
    bool fails;         /* --fail: debug_action = fail skips calls, and callbacks don't */
    bool refuses;       /* --refused */
    const char *level;  /* that all is played at; NULL: at its own */
    FILE *results;      /* NULL: none wanted */
    int argument_count; /* of the program, which plays a case again with a filter for it */
    char **arguments;
    uint32_t passed, failed, skipped;
    struct {
        char text[128];
        uint32_t count;
    } reasons[TALLY_REASONS_MAX]; /* for skipping */
    bool fired[MESSAGE_ID_COUNT], stayed_silent[MESSAGE_ID_COUNT];
};

/* Reads [--filter [!]NAME] [--list] [--verbose] [--results FILE] [--level NAME] from argument 2 on,
 * and opens the platform that argument 1 names. Returns 0, or the exit status of the program of
 * this usage, which it has explained. */
int tally_open(struct tally *tally, int argc, char **argv, const char *usage);

/* Whether a test of this name is to be run now; those that are listed are not. */
bool tally_starts(const struct tally *tally, const char *name);

/* What was seen of an id. At a level that is asked for, UNSEEN: it cannot see what is broken. */
enum sight { SIGHT_FIRED, SIGHT_SILENT, SIGHT_UNSEEN, SIGHT_FAILED };
/* Notes what the test of this name has seen of an id that a command has, and writes a line of
 * results. Nothing happens for VUID_NONE. */
void tally_note(struct tally *tally, const char *name, enum build_command command, enum vuid vuid,
                enum sight sight);
/* Counts a test of this name, which fails unless each id that is asked for has fired and stayed
 * silent. */
void tally_check_ids(struct tally *tally, const char *name,
                     bool (*is_asked_for)(const struct rule_info *info,
                                          enum build_command command));

/* A word for a build command, or the name of another one. */
const char *command_word(enum build_command command);

void tally_count(struct tally *tally, const char *name, const struct report *report);

/* Prints the count and closes the results. Returns the exit status. */
int tally_close(struct tally *tally);

#endif
