/* SPDX-License-Identifier: Apache-2.0 */
/* The threads that take part in one build: the caller's, those of its team, or a few that live as
 * long as the build. What they compute must not depend on how many they are. */
#ifndef ASSAY_BVH_WORKERS_H
#define ASSAY_BVH_WORKERS_H

#include "src/bvh/bvh.h"

#define WORKERS_MAX 64u
#define WORKERS_WORTH 4096u /* primitives; fewer are done sooner than a thread starts */

/* Fields belong to workers.c. */
struct workers {
    struct builder_team *team; /* NULL: the caller is alone */
    struct builder_team own;
    pthread_t threads[WORKERS_MAX - 1];
    uint32_t started;
};

/* The input's team or threads, or fewer where the system gives no more. */
void workers_start(struct workers *workers, const struct builder_input *input, uint32_t primitives);
void workers_stop(struct workers *workers);

static inline bool workers_are_alone(const struct workers *workers)
{
    return !workers->team;
}

/* Runs `job` on each thread that there is or comes, and returns when all have returned. Where one
 * returns, nothing may be left for another that hasn't begun. */
void workers_run(struct workers *workers, void (*job)(void *context), void *context);

/* Calls `body` for [0, count) in steps, on all threads, in any order. */
typedef void workers_body(void *context, uint32_t begin, uint32_t end);
void workers_each(struct workers *workers, uint32_t count, uint32_t step, workers_body *body,
                  void *context);

#endif
