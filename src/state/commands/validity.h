/* SPDX-License-Identifier: Apache-2.0 */
/* Which recordings of command buffers are no longer valid, because a secondary command buffer that
 * they execute was recorded anew, reset or freed.
 *
 * The secondary tells them: a primary command buffer is asked at each build, and may execute many.
 * Each secondary has a lock of its own for its list; the rest is atomic. */
#ifndef ASSAY_STATE_COMMANDS_VALIDITY_H
#define ASSAY_STATE_COMMANDS_VALIDITY_H

#include <pthread.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdint.h>

/* Of one recording; shared by it and what it executes. */
struct validity {
    atomic_uint references;
    atomic_bool lost;
};

struct validity *validity_create(void); /* with one reference; NULL without memory */
void validity_release(struct validity *validity);

/* The recordings that depend on a command buffer. */
struct dependents {
    pthread_mutex_t lock; /* guards the rest, but whether there are any is asked without it */
    struct validity **items;
    atomic_uint count;
    uint32_t capacity;
};

void dependents_init(struct dependents *dependents);
void dependents_release(struct dependents *dependents); /* tells them first */

/* Without memory it is not told. */
void dependents_add(struct dependents *dependents, struct validity *validity);
void dependents_invalidate(struct dependents *dependents);

#endif
