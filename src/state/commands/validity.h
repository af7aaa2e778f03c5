/* SPDX-License-Identifier: Apache-2.0 */
/* Tracks recordings of primary command buffers that become invalid because a secondary command
 * buffer that they execute is recorded again, reset or freed.
 *
 * The secondary marks the recordings that depend on it. So the check at each build is one atomic
 * load, however many secondaries the primary executes. The list of each secondary has its own lock;
 * all else is atomic. */
#ifndef ASSAY_STATE_COMMANDS_VALIDITY_H
#define ASSAY_STATE_COMMANDS_VALIDITY_H

#include <stdatomic.h>
#include <stdbool.h>
#include <stdint.h>

#include "src/platform/threads.h"

/* The validity of one recording. The recording and the secondaries that it executes share it. */
struct validity {
    atomic_uint references;
    atomic_bool invalidated;
};

struct validity *validity_create(void); /* with one reference; NULL if memory runs out */
void validity_release(struct validity *validity);

/* The recordings that depend on a command buffer. */
struct dependents {
    pthread_mutex_t lock; /* guards the rest, but `count` may be read without it */
    struct validity **items;
    atomic_uint count;
    uint32_t capacity;
};

void dependents_init(struct dependents *dependents);
void dependents_release(struct dependents *dependents); /* invalidates them first */

/* If memory runs out, `validity` will not be invalidated. */
void dependents_add(struct dependents *dependents, struct validity *validity);
void dependents_invalidate(struct dependents *dependents);

#endif
