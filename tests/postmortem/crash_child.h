/* SPDX-License-Identifier: Apache-2.0 */
/* Child processes that crash, with setting crash_report. */
#ifndef ASSAY_TESTS_POSTMORTEM_CRASH_CHILD_H
#define ASSAY_TESTS_POSTMORTEM_CRASH_CHILD_H

#include <sys/wait.h>

#include "tests/snapshots/scene.h"

enum { OUTPUT_SIZE = 1 << 16, HANDLED = 42 };

extern char output[OUTPUT_SIZE]; /* what the last child has written to stderr */
extern int status;               /* that waitpid() returned */

/* Runs a function in a child process, with crash_report and, if it is not NULL, a setting. */
void run(void (*child)(void), const char *setting, const char *value);

/* In the child: opens a device without a messenger, and crashes at a build. */
void open_at(const char *level);
void crash(int signal, bool in_thread, bool skips_copies);

/* The same: builds a TLAS with a reference that leads nowhere, waits, and ends the process. */
void build_with_wild_reference(void);

void expect_signal(int number);
void expect_output(const char *part);
void expect_no_output(const char *part);

#endif
