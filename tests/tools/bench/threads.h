/* SPDX-License-Identifier: Apache-2.0 */
/* Threads that record side by side, each in a command pool of its own. */
#ifndef BENCH_THREADS_H
#define BENCH_THREADS_H

#include "recorder.h"

enum { MOST_THREADS = 4 };

/* Nanoseconds a build: over what the threads record together, the time that they take together by
 * the wall clock, which also tells of waits but needs a machine that is idle, and the sum of their
 * CPU times. */
struct thread_times {
    double wall, cpu;
};

/* Of `count` threads that all record `times` calls of `builds` builds. The scene has the builds of
 * all of them. */
struct thread_times threads_time(const struct side *side, const struct scene *scene, uint32_t count,
                                 uint32_t builds, uint32_t times);

#endif
