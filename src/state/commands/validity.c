/* SPDX-License-Identifier: Apache-2.0 */
/* Lists of recordings that are told when they lose their validity. */
#include "src/state/commands/validity.h"

#include <stdlib.h>

struct validity *validity_create(void)
{
    struct validity *validity = malloc(sizeof(*validity));
    if (!validity)
        return NULL;
    atomic_init(&validity->references, 1);
    atomic_init(&validity->lost, false);
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

/* Takes out recordings that have ended, so that a secondary that is executed again and again
 * remembers no more than what still does. */
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

/* Grows where pruning leaves little room, so that it is rarely done. */
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

/* The application lets nobody execute a command buffer that it records anew. */
void dependents_invalidate(struct dependents *dependents)
{
    if (!dependents->count)
        return;
    pthread_mutex_lock(&dependents->lock);
    while (dependents->count) {
        struct validity *validity = dependents->items[--dependents->count];
        atomic_store_explicit(&validity->lost, true, memory_order_relaxed);
        validity_release(validity);
    }
    pthread_mutex_unlock(&dependents->lock);
}
