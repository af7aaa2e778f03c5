/* SPDX-License-Identifier: Apache-2.0 */
/* Lives of an application with memory running out: each life lacks another of the layer's
 * allocations. Whatever was lost, nothing crashes, nothing leaks, and no message goes out that is
 * not true.
 *
 * Where the same calls within the layer lead to several allocations, only the first and the last of
 * them fail, once for all applications. With ASSAY_SCARCE_ONE_OF=N, which scripts/test --all sets,
 * one of N of all allocations fails, too, by chance (ASSAY_TEST_SEED). ASSAY_SCARCE_AT repeats one
 * life.
 *
 * Each life is a process, so that a crash tells which allocation it was. */
#ifndef SCARCE_LIVES_H
#define SCARCE_LIVES_H

#include <stdbool.h>

/* How a life ended. */
enum life_end { LIFE_WELL, LIFE_SKIPPED, LIFE_BADLY };

/* Watches the layer. Ends the process if it cannot. */
void lives_open(void);

/* Has an application live: first without a failure, then again and again, until a life ends badly.
 * `live` returns what was wrong: "" for nothing, or NULL if the application cannot live here.
 * `is_scarce`: memory may run out. If a life goes badly, `live` may print a message and exit. */
void lives_play(const char *name, const char *(*live)(bool is_scarce));

/* Whether so many lives have ended badly that others need not begin. */
bool lives_are_enough(void);
/* Prints how they ended. Returns the exit status: too few lives are no success, either. */
int lives_close(unsigned least);

#endif
