/* SPDX-License-Identifier: Apache-2.0 */
/* A hash table from handles to records. The table does not own the records. It has no lock; its
 * owner serializes access.
 *
 * Open addressing with linear probing. A table is at most two thirds full, and at least one eighth
 * full unless it is small. Key 0 (VK_NULL_HANDLE) is never in a table. */
#ifndef ASSAY_BASE_HANDLE_TABLE_H
#define ASSAY_BASE_HANDLE_TABLE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct handle_table {
    struct handle_slot {
        uint64_t handle;
        void *record;
    } * slots;
    size_t count, mask; /* mask + 1 slots; `slots` is NULL while the table is empty */
    unsigned shift;     /* see handle_table_home */
};

/* Returns the slot at which the search for a handle begins. Handles are pointers or counters, so
 * any of their bits may vary: the hash multiplies by 2^64 / phi and keeps the highest bits, which
 * spreads neighbouring handles (Knuth, The Art of Computer Programming, 6.4). */
static inline size_t handle_table_home(const struct handle_table *table, uint64_t handle)
{
    return (size_t)(handle * 0x9e3779b97f4a7c15u >> table->shift);
}

/* Completes a search that does not end at the first slot, which is rare. */
void *handle_table_search(const struct handle_table *table, uint64_t handle);

/* Returns the record of a handle, or NULL if the table has no such handle. */
static inline void *handle_table_find(const struct handle_table *table, uint64_t handle)
{
    if (!table->slots)
        return NULL;
    const struct handle_slot *slot = &table->slots[handle_table_home(table, handle)];
    return slot->handle == handle ? slot->record : handle_table_search(table, handle);
}

/* Prefetches the first slot of a search for `handle` that follows soon. */
static inline void handle_table_prefetch(const struct handle_table *table, uint64_t handle)
{
    if (table->slots)
        __builtin_prefetch(&table->slots[handle_table_home(table, handle)]);
}

/* Adds a record, or replaces the record of this handle. A replacement cannot fail. Returns false,
 * and leaves the table unchanged, if memory runs out. */
bool handle_table_set(struct handle_table *table, uint64_t handle, void *record);

/* Removes a handle and returns its record, or NULL if there was none. Afterwards, adding one handle
 * cannot fail. */
void *handle_table_remove(struct handle_table *table, uint64_t handle);

/* Frees the table but not the records. */
void handle_table_release(struct handle_table *table);
/* Calls `release` for every record, and then frees the table. */
void handle_table_drop(struct handle_table *table, void (*release)(void *record));

/* Calls `visit` for every record. `visit` must not change the table. */
void handle_table_each(const struct handle_table *table, void (*visit)(void *record, void *context),
                       void *context);

#endif
