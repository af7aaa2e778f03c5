/* SPDX-License-Identifier: Apache-2.0 */
/* A hash table from handles to records that somebody else owns. Not locked: its owner is.
 *
 * Open addressing with linear probing, at most two thirds full. Key 0 (VK_NULL_HANDLE) is never in
 * a table. */
#ifndef ASSAY_STATE_HANDLE_TABLE_H
#define ASSAY_STATE_HANDLE_TABLE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct handle_table {
    struct handle_slot {
        uint64_t handle;
        void *record;
    } * slots;
    size_t count, mask; /* mask + 1 slots; slots is NULL while empty */
};

/* NULL where the handle isn't known. */
/* Fetches the slot where a look-up will begin into the processor's cache. */
void handle_table_prefetch(const struct handle_table *table, uint64_t handle);

void *handle_table_find(const struct handle_table *table, uint64_t handle);

/* False without memory; then the table is as before. An existing record is replaced. */
bool handle_table_set(struct handle_table *table, uint64_t handle, void *record);

/* Returns the record that was there, or NULL. */
void *handle_table_remove(struct handle_table *table, uint64_t handle);

/* Frees the table, not the records. */
void handle_table_release(struct handle_table *table);

/* Calls `visit` for every record; it must not change the table. */
void handle_table_each(const struct handle_table *table, void (*visit)(void *record, void *context),
                       void *context);

#endif
