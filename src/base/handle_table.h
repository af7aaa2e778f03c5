/* SPDX-License-Identifier: Apache-2.0 */
/* A hash table from handles to records that somebody else owns. Not locked: its owner is.
 *
 * Open addressing with linear probing, at most two thirds full and, unless it is small, at least
 * one eighth. Key 0 (VK_NULL_HANDLE) is never in a table. */
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
    size_t count, mask; /* mask + 1 slots; slots is NULL while empty */
    unsigned shift;     /* see handle_table_home */
};

/* Where the search for a handle begins. Handles are pointers, or counters in any of their bits:
 * multiply by 2^64 / phi and keep the highest bits, so that neighbours spread (Knuth, The Art of
 * Computer Programming, 6.4). */
static inline size_t handle_table_home(const struct handle_table *table, uint64_t handle)
{
    return (size_t)(handle * 0x9e3779b97f4a7c15u >> table->shift);
}

/* The rest of the search, which is seldom. */
void *handle_table_search(const struct handle_table *table, uint64_t handle);

/* NULL where the handle isn't known. */
static inline void *handle_table_find(const struct handle_table *table, uint64_t handle)
{
    if (!table->slots)
        return NULL;
    const struct handle_slot *slot = &table->slots[handle_table_home(table, handle)];
    return slot->handle == handle ? slot->record : handle_table_search(table, handle);
}

/* Will soon be looked for: fetches where its search begins. */
static inline void handle_table_prefetch(const struct handle_table *table, uint64_t handle)
{
    if (table->slots)
        __builtin_prefetch(&table->slots[handle_table_home(table, handle)]);
}

/* False without memory; then the table is as before. An existing record is replaced, which can't
 * fail. */
bool handle_table_set(struct handle_table *table, uint64_t handle, void *record);

/* Returns the record that was there, or NULL. There is room for another then. */
void *handle_table_remove(struct handle_table *table, uint64_t handle);

/* Frees the table, not the records. */
void handle_table_release(struct handle_table *table);

/* Calls `visit` for every record; it must not change the table. */
void handle_table_each(const struct handle_table *table, void (*visit)(void *record, void *context),
                       void *context);

#endif
