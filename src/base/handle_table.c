/* SPDX-License-Identifier: Apache-2.0 */
/* A hash table from handles to records. */
#include "src/base/handle_table.h"

#include <stdlib.h>

/* A table larger than FIRST_SLOTS shrinks if fewer than one slot in MIN_LOAD_DIVISOR is in use. */
enum { FIRST_SLOTS = 64, MIN_LOAD_DIVISOR = 8 };

static struct handle_slot *find_slot(const struct handle_table *table, uint64_t handle)
{
    size_t i = handle_table_home(table, handle);
    while (table->slots[i].handle && table->slots[i].handle != handle)
        i = (i + 1) & table->mask;
    return &table->slots[i];
}

void *handle_table_search(const struct handle_table *table, uint64_t handle)
{
    return find_slot(table, handle)->record;
}

static bool resize(struct handle_table *table, size_t size)
{
    struct handle_table resized = {.slots = calloc(size, sizeof(*resized.slots)),
                                   .count = table->count,
                                   .mask = size - 1,
                                   .shift = 64 - (unsigned)__builtin_ctzll(size)};
    if (!resized.slots)
        return false;

    for (size_t i = 0; table->slots && i <= table->mask; i++)
        if (table->slots[i].handle)
            *find_slot(&resized, table->slots[i].handle) = table->slots[i];
    free(table->slots);
    *table = resized;
    return true;
}

static bool grow_table(struct handle_table *table)
{
    return resize(table, table->slots ? (table->mask + 1) * 2 : FIRST_SLOTS);
}

/* A sparse table wastes cache. If memory runs out, the table keeps its size. */
static void shrink(struct handle_table *table)
{
    size_t size = table->mask + 1;
    if (size > FIRST_SLOTS && table->count < size / MIN_LOAD_DIVISOR)
        resize(table, size / 2);
}

bool handle_table_set(struct handle_table *table, uint64_t handle, void *record)
{
    if (!handle)
        return false;
    struct handle_slot *slot = table->slots ? find_slot(table, handle) : NULL;
    if (!slot || !slot->handle) {
        if (!slot || (table->count + 1) * 3 > (table->mask + 1) * 2) {
            if (!grow_table(table))
                return false;
            slot = find_slot(table, handle);
        }
        table->count++;
    }
    *slot = (struct handle_slot){.handle = handle, .record = record};
    return true;
}

void *handle_table_remove(struct handle_table *table, uint64_t handle)
{
    if (!table->slots || !handle)
        return NULL;
    struct handle_slot *slot = find_slot(table, handle);
    if (!slot->handle)
        return NULL;
    void *record = slot->record;

    /* Close the gap: move each later slot of the run into the gap, unless the slot's home lies
     * after the gap. */
    size_t gap = (size_t)(slot - table->slots);
    for (size_t i = (gap + 1) & table->mask; table->slots[i].handle; i = (i + 1) & table->mask) {
        size_t home = handle_table_home(table, table->slots[i].handle);
        if (((i - home) & table->mask) >= ((i - gap) & table->mask)) {
            table->slots[gap] = table->slots[i];
            gap = i;
        }
    }
    table->slots[gap] = (struct handle_slot){0};
    table->count--;
    shrink(table);
    return record;
}

void handle_table_release(struct handle_table *table)
{
    free(table->slots);
    *table = (struct handle_table){0};
}

void handle_table_drop(struct handle_table *table, void (*release)(void *record))
{
    for (size_t i = 0; table->slots && i <= table->mask; i++)
        if (table->slots[i].handle)
            release(table->slots[i].record);
    handle_table_release(table);
}

void handle_table_each(const struct handle_table *table, void (*visit)(void *record, void *context),
                       void *context)
{
    for (size_t i = 0; table->slots && i <= table->mask; i++)
        if (table->slots[i].handle)
            visit(table->slots[i].record, context);
}
