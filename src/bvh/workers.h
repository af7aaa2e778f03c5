/* SPDX-License-Identifier: Apache-2.0 */
/* The threads that take part in one build: the caller's thread, the threads of its team, or threads
 * that live as long as the build. Results must not depend on the number of threads. */
#ifndef ASSAY_BVH_WORKERS_H
#define ASSAY_BVH_WORKERS_H

#include "src/bvh/bvh.h"

#define WORKERS_MAX 64u
/* With fewer primitives, a single thread finishes before another one starts. */
#define WORKERS_MIN_PRIMITIVES 4096u

/* The members belong to workers.c. */
struct workers {
    struct builder_team *team; /* NULL if the caller is the only thread */
    struct builder_team own;
    pthread_t threads[WORKERS_MAX - 1];
    uint32_t started;
};

/* Uses the team or the thread count of the input. Starts fewer threads if the system refuses them.
 * The caller calls workers_stop(). */
void workers_start(struct workers *workers, const struct builder_input *input, uint32_t primitives);
/* Ends the threads that workers_start() started. */
void workers_stop(struct workers *workers);

static inline bool workers_are_alone(const struct workers *workers)
{
    return !workers->team;
}

/* Runs `job` on every thread that is present or joins, and returns when all have returned. When
 * `job` returns on one thread, no work may be left for threads that have not started. */
void workers_run(struct workers *workers, void (*job)(void *context), void *context);

/* Calls `body` for [0, count) in steps, on all threads and in any order. */
typedef void workers_body(void *context, uint32_t begin, uint32_t end);
void workers_each(struct workers *workers, uint32_t count, uint32_t step, workers_body *body,
                  void *context);

#endif
