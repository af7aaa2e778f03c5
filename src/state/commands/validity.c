/* SPDX-License-Identifier: Apache-2.0 */
/* Lists of recordings that depend on a secondary command buffer. */
#include "src/state/commands/validity.h"

#include <stdlib.h>

struct validity *validity_create(void)
{
    struct validity *validity = malloc(sizeof(*validity));
    if (!validity)
        return NULL;
    atomic_init(&validity->references, 1);
    atomic_init(&validity->invalidated, false);
    return validity;
}

void validity_release(struct validity *validity)
{
    if (validity && atomic_fetch_sub_explicit(&validity->references, 1, memory_order_acq_rel) == 1)
        free(validity);
}

void dependents_init(struct dependents *dependents)
{
    *dependents = (struct dependents){.items = NULL};
    pthread_mutex_init(&dependents->lock, NULL);
}

void dependents_release(struct dependents *dependents)
{
    dependents_invalidate(dependents);
    free(dependents->items);
    pthread_mutex_destroy(&dependents->lock);
}

/* Removes recordings that no longer exist, so that the list of a secondary that is executed again
 * and again does not grow without bound. */
static void prune(struct dependents *dependents)
{
    uint32_t kept = 0;
    for (uint32_t i = 0; i < dependents->count; i++) {
        struct validity *validity = dependents->items[i];
        if (atomic_load_explicit(&validity->references, memory_order_acquire) == 1)
            validity_release(validity);
        else
            dependents->items[kept++] = validity;
    }
    dependents->count = kept;
}

/* Grows the list if pruning leaves it more than half full, so that pruning stays rare. */
static bool reserve(struct dependents *dependents)
{
    if (dependents->count < dependents->capacity)
        return true;
    prune(dependents);
    if (dependents->count < dependents->capacity / 2)
        return true;
    uint32_t capacity = dependents->capacity ? dependents->capacity * 2 : 4;
    struct validity **items = realloc(dependents->items, capacity * sizeof(struct validity *));
    if (!items)
        return dependents->count < dependents->capacity;
    dependents->items = items;
    dependents->capacity = capacity;
    return true;
}

void dependents_add(struct dependents *dependents, struct validity *validity)
{
    pthread_mutex_lock(&dependents->lock);
    uint32_t count = dependents->count;
    bool is_there = count && dependents->items[count - 1] == validity;
    if (!is_there && reserve(dependents)) {
        atomic_fetch_add_explicit(&validity->references, 1, memory_order_relaxed);
        dependents->items[dependents->count++] = validity;
    }
    pthread_mutex_unlock(&dependents->lock);
}

/* Reads `count` without the lock: the application must not execute a command buffer while it
 * records it again. */
void dependents_invalidate(struct dependents *dependents)
{
    if (!dependents->count)
        return;
    pthread_mutex_lock(&dependents->lock);
    while (dependents->count) {
        struct validity *validity = dependents->items[--dependents->count];
        atomic_store_explicit(&validity->invalidated, true, memory_order_relaxed);
        validity_release(validity);
    }
    pthread_mutex_unlock(&dependents->lock);
}
