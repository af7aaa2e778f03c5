/* SPDX-License-Identifier: Apache-2.0 */
/* The ordered set of address ranges. */
#include "state/address_map.h"

#include <stdlib.h>
#include <string.h>

enum { CHUNK_ENTRIES = 256, FIRST_CHUNKS = 8 };

struct address_entry {
    uint64_t begin, end;
    uint64_t reach; /* the largest end of this chunk's entries up to here */
    void *record;
};

struct address_chunk {
    uint64_t reach_before; /* the largest end in all chunks before this one */
    size_t count;          /* never 0 */
    struct address_entry entries[CHUNK_ENTRIES];
};

/* The number of entries that begin at or before `address`. */
static size_t entries_up_to(const struct address_chunk *chunk, uint64_t address)
{
    size_t low = 0, high = chunk->count;
    while (low < high) {
        size_t middle = low + (high - low) / 2;
        if (chunk->entries[middle].begin <= address)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

/* The last chunk whose first entry begins at or before `address`; chunk 0 if none does. */
static size_t chunk_of(const struct address_map *map, uint64_t address)
{
    size_t low = 0, high = map->chunk_count;
    while (low < high) {
        size_t middle = low + (high - low) / 2;
        if (map->chunks[middle]->entries[0].begin <= address)
            low = middle + 1;
        else
            high = middle;
    }
    return low ? low - 1 : 0;
}

static uint64_t larger_of(uint64_t a, uint64_t b)
{
    return a > b ? a : b;
}

/* Restores `reach` from entry `from` of a chunk on, and `reach_before` of the chunks behind it. */
static void restore_reach(struct address_map *map, size_t c, size_t from)
{
    struct address_chunk *chunk = map->chunks[c];
    for (size_t i = from; i < chunk->count; i++)
        chunk->entries[i].reach =
            larger_of(chunk->entries[i].end, i ? chunk->entries[i - 1].reach : 0);

    uint64_t reach = c ? map->chunks[c]->reach_before : 0;
    for (; c < map->chunk_count; c++) {
        chunk = map->chunks[c];
        chunk->reach_before = reach;
        reach = larger_of(reach, chunk->entries[chunk->count - 1].reach);
    }
}

/* Makes room for a chunk at index `c`; NULL without memory. */
static struct address_chunk *insert_chunk(struct address_map *map, size_t c)
{
    if (map->chunk_count == map->chunk_capacity) {
        size_t capacity = map->chunk_capacity ? map->chunk_capacity * 2 : FIRST_CHUNKS;
        struct address_chunk **chunks =
            realloc(map->chunks, capacity * sizeof(struct address_chunk *));
        if (!chunks)
            return NULL;
        map->chunks = chunks;
        map->chunk_capacity = capacity;
    }
    struct address_chunk *chunk = malloc(sizeof(*chunk));
    if (!chunk)
        return NULL;
    chunk->count = 0;
    chunk->reach_before = 0;
    memmove(&map->chunks[c + 1], &map->chunks[c],
            (map->chunk_count - c) * sizeof(struct address_chunk *));
    map->chunks[c] = chunk;
    map->chunk_count++;
    return chunk;
}

/* Moves the upper half of a full chunk into a new one behind it. */
static bool split_chunk(struct address_map *map, size_t c)
{
    struct address_chunk *upper = insert_chunk(map, c + 1);
    if (!upper)
        return false;
    struct address_chunk *lower = map->chunks[c];
    upper->count = lower->count / 2;
    lower->count -= upper->count;
    memcpy(upper->entries, &lower->entries[lower->count], upper->count * sizeof(upper->entries[0]));
    restore_reach(map, c + 1, 0);
    restore_reach(map, c, 0);
    return true;
}

bool address_map_add(struct address_map *map, uint64_t begin, uint64_t size, void *record)
{
    if (!size || begin + (size - 1) < begin || begin + size == 0)
        return false;
    if (!map->chunk_count && !insert_chunk(map, 0))
        return false;
    size_t c = chunk_of(map, begin);
    if (map->chunks[c]->count == CHUNK_ENTRIES) {
        if (!split_chunk(map, c))
            return false;
        c = chunk_of(map, begin);
    }
    struct address_chunk *chunk = map->chunks[c];
    size_t at = entries_up_to(chunk, begin);
    memmove(&chunk->entries[at + 1], &chunk->entries[at],
            (chunk->count - at) * sizeof(chunk->entries[0]));
    chunk->entries[at] =
        (struct address_entry){.begin = begin, .end = begin + size, .record = record};
    chunk->count++;
    restore_reach(map, c, at);
    return true;
}

static void remove_entry(struct address_map *map, size_t c, size_t at)
{
    struct address_chunk *chunk = map->chunks[c];
    chunk->count--;
    memmove(&chunk->entries[at], &chunk->entries[at + 1],
            (chunk->count - at) * sizeof(chunk->entries[0]));
    if (chunk->count) {
        restore_reach(map, c, at);
        return;
    }
    uint64_t reach_before = chunk->reach_before;
    free(chunk);
    map->chunk_count--;
    memmove(&map->chunks[c], &map->chunks[c + 1],
            (map->chunk_count - c) * sizeof(struct address_chunk *));
    if (c < map->chunk_count) {
        map->chunks[c]->reach_before = reach_before;
        restore_reach(map, c, 0);
    }
}

/* Equal beginnings may lie in several chunks, so look back from the last of them. */
void address_map_remove(struct address_map *map, uint64_t begin, const void *record)
{
    if (!map->chunk_count)
        return;
    for (size_t c = chunk_of(map, begin) + 1; c-- > 0;) {
        struct address_chunk *chunk = map->chunks[c];
        for (size_t i = entries_up_to(chunk, begin); i-- > 0;) {
            if (chunk->entries[i].begin != begin)
                return;
            if (chunk->entries[i].record == record) {
                remove_entry(map, c, i);
                return;
            }
        }
    }
}

void address_map_find(const struct address_map *map, uint64_t address,
                      void (*visit)(void *record, void *context), void *context)
{
    if (!map->chunk_count)
        return;
    for (size_t c = chunk_of(map, address) + 1; c-- > 0;) {
        const struct address_chunk *chunk = map->chunks[c];
        for (size_t i = entries_up_to(chunk, address); i-- > 0;) {
            if (chunk->entries[i].reach <= address)
                break;
            if (chunk->entries[i].end > address)
                visit(chunk->entries[i].record, context);
        }
        if (chunk->reach_before <= address)
            return;
    }
}

void address_map_release(struct address_map *map)
{
    for (size_t c = 0; c < map->chunk_count; c++)
        free(map->chunks[c]);
    free(map->chunks);
    *map = (struct address_map){0};
}
