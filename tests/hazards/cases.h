/* SPDX-License-Identifier: Apache-2.0 */
/* Cases of the hazard check as text. A case is a program, one command a line:
 *
 *     case a top-level build reads a structure just built
 *     build B0
 *     + barrier build:accel_write > build:accel_read
 *     top T0 B0
 *     expect READ-AFTER-WRITE: an instance of pInfos[0] ... B0
 *
 * The broken program has all lines but those with +, and yields exactly the expected messages. The
 * repaired program has all lines but those with -, and is silent. A case without expectations is
 * one valid program. `level LEVEL` plays a case at another level than content; `only null` is for
 * cases that need the null driver's sizes; `without maintenance1` or `without synchronization2`
 * disables the feature. A line with # is a comment. play_*.c say what the
 * commands are. */
#ifndef ASSAY_TESTS_HAZARDS_CASES_H
#define ASSAY_TESTS_HAZARDS_CASES_H

#include <stdbool.h>

enum { CASE_WORDS = 24, CASE_LINES = 48, CASE_EXPECTATIONS = 6 };

struct case_line {
    char mark;                   /* '+', '-' or ' ' */
    char *words[CASE_WORDS + 1]; /* NULL behind the last */
    unsigned number;             /* in the file */
};

struct case_expectation {
    const char *id; /* without SYNC-HAZARD- */
    char *text;     /* parts in this order, with " ... " between them */
};

struct hazard_case {
    const char *name, *group; /* group: the file's name */
    const char *level;        /* NULL: content */
    struct case_line lines[CASE_LINES];
    unsigned line_count;
    struct case_expectation expected[CASE_EXPECTATIONS];
    unsigned expected_count;
};

struct hazard_cases {
    struct hazard_case *items;
    unsigned count;
};

/* Adds the cases of a file, which stay allocated. A mistake in the file ends the program. */
void cases_read(struct hazard_cases *cases, const char *folder, const char *group);

/* Returns true if the parts of `wanted` are in `text`, in this order. */
bool case_text_matches(const char *text, const char *wanted);

#endif
