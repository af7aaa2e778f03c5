/* SPDX-License-Identifier: Apache-2.0 */
/* Threads that record side by side, each in a command pool of its own. */
#ifndef BENCH_THREADS_H
#define BENCH_THREADS_H

#include "recorder.h"

enum { MOST_THREADS = 4 };

/* Nanoseconds a build, by the wall clock, of `count` threads that all record `times` calls of
 * `builds` builds: the time they take together, over what they record together. The scene has the
 * builds of all of them. */
double threads_time(const struct side *side, const struct scene *scene, uint32_t count,
                    uint32_t builds, uint32_t times);

#endif
