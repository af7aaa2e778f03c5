/* SPDX-License-Identifier: Apache-2.0 */
/* Child processes that crash, with setting crash_report. */
#ifndef ASSAY_TESTS_POSTMORTEM_CRASH_CHILD_H
#define ASSAY_TESTS_POSTMORTEM_CRASH_CHILD_H

#include <sys/wait.h>

#include "tests/player/play.h"
#include "tests/unit/unit_test.h"

enum { OUTPUT_SIZE = 1 << 16, HANDLED = 42 };

extern char output[OUTPUT_SIZE]; /* what the last child has written to stderr */
extern int status;               /* that waitpid() returned */

/* Runs a function in a child process, with crash_report and, if it is not NULL, a setting. */
void run(void (*child)(void), const char *setting, const char *value);

/* In the child: opens a device without a messenger, at a level (NULL: content). */
extern struct play play;
void open_at(const char *level);
void close_device(void);
/* Executes a line of a program. */
void execute_line(const char *text);
/* A build of a box whose minimum is above its maximum, which level content reports; and a
 * submission of one. */
#define BUILD_BOX "build B0 boxes V1 primitives 1"
void submit_box(void);

/* Crashes at a build. */
struct crash {
    const char *level; /* NULL: content */
    int signal;        /* that the driver raises; 0: it accesses an invalid address */
    bool in_thread, skips_copies;
    uint32_t number; /* of the build; 0 is 1 */
};
void plan_crash(const struct crash *crash);
void crash(const struct crash *crash);
#define CRASH(...) crash(&(struct crash){__VA_ARGS__})

/* How a child ends: by this signal, or, if it is 0, with the exit code HANDLED. */
struct ending {
    int signal;
    const char *says, *lacks; /* texts in the output, with "..." between them; and one that is not
                                 in it */
};
void expect_ending(const struct ending *ending);
#define EXPECT_ENDING(...) expect_ending(&(struct ending){__VA_ARGS__})

#endif
