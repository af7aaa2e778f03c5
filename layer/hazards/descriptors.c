/* SPDX-License-Identifier: Apache-2.0 */
#include "layer/hazards/descriptors.h"

#include <stdlib.h>

enum { SETS_KEPT = 1 << 16 };

struct held_set {
    bool is_unknown;
    uint32_t count;
    struct held_structure {
        uint32_t binding, element;
        uint64_t structure;
    } items[TRACED_MAX];
};

void descriptor_sets_end(struct descriptor_sets *sets)
{
    handle_table_drop(&sets->sets, free);
}

void descriptor_sets_lack(struct descriptor_sets *sets)
{
    atomic_store(&sets->lacks, true);
}

void descriptor_sets_forget(struct descriptor_sets *sets, uint64_t set)
{
    reader_lock_write(&sets->lock);
    struct held_set *held = handle_table_remove(&sets->sets, set);
    sets->count -= held != NULL;
    reader_lock_write_done(&sets->lock);
    free(held);
}

/* Returns the record of a set; adds one if there is none. Call with the lock for writing. */
static struct held_set *hold_set(struct descriptor_sets *sets, uint64_t set)
{
    struct held_set *held = handle_table_find(&sets->sets, set);
    if (held)
        return held;
    held = sets->count < SETS_KEPT ? calloc(1, sizeof(*held)) : NULL;
    if (held && handle_table_set(&sets->sets, set, held)) {
        sets->count++;
        return held;
    }
    free(held);
    descriptor_sets_lack(sets);
    return NULL;
}

/* Returns the item of a descriptor, or the first one that is free. */
static uint32_t find_item(const struct held_set *held, uint32_t binding, uint32_t element)
{
    uint32_t i = 0;
    while (i < held->count &&
           (held->items[i].binding != binding || held->items[i].element != element))
        i++;
    return i;
}

void descriptor_sets_write(struct descriptor_sets *sets, uint64_t set, uint32_t binding,
                           uint32_t element, uint64_t structure)
{
    reader_lock_write(&sets->lock);
    struct held_set *held = hold_set(sets, set);
    const uint32_t i = held ? find_item(held, binding, element) : TRACED_MAX;
    if (i < TRACED_MAX)
        held->items[i] = (struct held_structure){binding, element, structure};
    if (held && i == held->count && i < TRACED_MAX)
        held->count++;
    else if (held && i == TRACED_MAX)
        held->is_unknown = true;
    reader_lock_write_done(&sets->lock);
}

void descriptor_sets_lose(struct descriptor_sets *sets, uint64_t set)
{
    reader_lock_write(&sets->lock);
    struct held_set *held = hold_set(sets, set);
    if (held)
        held->is_unknown = true;
    reader_lock_write_done(&sets->lock);
}

static bool is_held_set(struct descriptor_sets *sets, uint64_t set)
{
    const unsigned stripe = reader_lock_enter(&sets->lock);
    const bool is_held = handle_table_find(&sets->sets, set);
    reader_lock_leave(&sets->lock, stripe);
    return is_held;
}

void descriptor_sets_copy(struct descriptor_sets *sets, uint64_t set, uint64_t to)
{
    if (is_held_set(sets, set))
        descriptor_sets_lose(sets, to);
}

bool descriptor_sets_find(struct descriptor_sets *sets, uint64_t set, uint64_t found[TRACED_MAX],
                          uint32_t *count)
{
    const unsigned stripe = reader_lock_enter(&sets->lock);
    const struct held_set *held = handle_table_find(&sets->sets, set);
    const bool is_known = !held || (!held->is_unknown && held->count <= TRACED_MAX - *count);
    for (uint32_t i = 0; held && is_known && i < held->count; i++)
        found[(*count)++] = held->items[i].structure;
    reader_lock_leave(&sets->lock, stripe);
    return is_known;
}
