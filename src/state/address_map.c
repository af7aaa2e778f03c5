/* SPDX-License-Identifier: Apache-2.0 */
/* The ordered set of address ranges. */
#include "state/address_map.h"

#include <stdlib.h>
#include <string.h>

enum { CHUNK_ENTRIES = 64, FIRST_CHUNKS = 8 };

/* Entries as arrays of their members: a search reads only `begins`. */
struct address_chunk {
    uint64_t reach_before; /* the largest end in all chunks before this one */
    size_t count;          /* never 0 between calls */
    uint64_t begins[CHUNK_ENTRIES], ends[CHUNK_ENTRIES];
    uint64_t reaches[CHUNK_ENTRIES]; /* the largest end of this chunk's entries up to each */
    void *records[CHUNK_ENTRIES];
};

/* The number of values, in ascending order, that are at most `limit`. */
static size_t count_up_to(const uint64_t *values, size_t count, uint64_t limit)
{
    size_t low = 0;
    while (count) {
        size_t half = count / 2;
        bool is_up_to = values[low + half] <= limit;
        low = is_up_to ? low + half + 1 : low;
        count = is_up_to ? count - half - 1 : half;
    }
    return low;
}

/* The last chunk whose first entry begins at or before `address`; chunk 0 if none does. */
static size_t chunk_of(const struct address_map *map, uint64_t address)
{
    size_t count = count_up_to(map->firsts, map->chunk_count, address);
    return count ? count - 1 : 0;
}

static uint64_t larger_of(uint64_t a, uint64_t b)
{
    return a > b ? a : b;
}

static uint64_t reach_of(const struct address_chunk *chunk)
{
    return larger_of(chunk->reach_before, chunk->count ? chunk->reaches[chunk->count - 1] : 0);
}

/* Restores `reaches` from entry `from` of chunk `c` on, and `reach_before` of the chunks from
 * `c` + 1 on, up to the first where it is right already. */
static void restore_reach(struct address_map *map, size_t c, size_t from)
{
    struct address_chunk *chunk = map->chunks[c];
    for (size_t i = from; i < chunk->count; i++)
        chunk->reaches[i] = larger_of(chunk->ends[i], i ? chunk->reaches[i - 1] : 0);
    map->firsts[c] = chunk->begins[0];

    for (c++; c < map->chunk_count; c++) {
        uint64_t reach = reach_of(map->chunks[c - 1]);
        if (map->chunks[c]->reach_before == reach)
            return;
        map->chunks[c]->reach_before = reach;
    }
}

static bool reserve_chunks(struct address_map *map)
{
    if (map->chunk_count < map->chunk_capacity)
        return true;
    size_t capacity = map->chunk_capacity ? map->chunk_capacity * 2 : FIRST_CHUNKS;
    struct address_chunk **chunks = realloc(map->chunks, capacity * sizeof(*chunks));
    if (chunks)
        map->chunks = chunks;
    uint64_t *firsts = realloc(map->firsts, capacity * sizeof(*firsts));
    if (firsts)
        map->firsts = firsts;
    if (!chunks || !firsts)
        return false;
    map->chunk_capacity = capacity;
    return true;
}

/* Makes room for an empty chunk at index `c`; NULL without memory. */
static struct address_chunk *insert_chunk(struct address_map *map, size_t c)
{
    if (!reserve_chunks(map))
        return NULL;
    struct address_chunk *chunk = malloc(sizeof(*chunk));
    if (!chunk)
        return NULL;
    chunk->count = 0;
    chunk->reach_before = c ? reach_of(map->chunks[c - 1]) : 0;
    size_t behind = map->chunk_count - c;
    memmove(&map->chunks[c + 1], &map->chunks[c], behind * sizeof(*map->chunks));
    memmove(&map->firsts[c + 1], &map->firsts[c], behind * sizeof(*map->firsts));
    map->chunks[c] = chunk;
    map->chunk_count++;
    return chunk;
}

static void remove_chunk(struct address_map *map, size_t c)
{
    free(map->chunks[c]);
    map->chunk_count--;
    size_t behind = map->chunk_count - c;
    memmove(&map->chunks[c], &map->chunks[c + 1], behind * sizeof(*map->chunks));
    memmove(&map->firsts[c], &map->firsts[c + 1], behind * sizeof(*map->firsts));
}

/* Moves `count` entries from `from` of one chunk to `to` of another, or of the same. */
static void move_entries(struct address_chunk *target, size_t to, const struct address_chunk *source,
                         size_t from, size_t count)
{
    memmove(&target->begins[to], &source->begins[from], count * sizeof(source->begins[0]));
    memmove(&target->ends[to], &source->ends[from], count * sizeof(source->ends[0]));
    memmove(&target->records[to], &source->records[from], count * sizeof(source->records[0]));
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
    move_entries(upper, 0, lower, lower->count, upper->count);
    restore_reach(map, c, 0);
    restore_reach(map, c + 1, 0);
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
    size_t at = count_up_to(chunk->begins, chunk->count, begin);
    move_entries(chunk, at + 1, chunk, at, chunk->count - at);
    chunk->begins[at] = begin;
    chunk->ends[at] = begin + size;
    chunk->records[at] = record;
    chunk->count++;
    restore_reach(map, c, at);
    return true;
}

static void remove_entry(struct address_map *map, size_t c, size_t at)
{
    struct address_chunk *chunk = map->chunks[c];
    chunk->count--;
    move_entries(chunk, at, chunk, at + 1, chunk->count - at);
    if (chunk->count) {
        restore_reach(map, c, at);
        return;
    }
    uint64_t reach_before = chunk->reach_before;
    remove_chunk(map, c);
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
        for (size_t i = count_up_to(chunk->begins, chunk->count, begin); i-- > 0;) {
            if (chunk->begins[i] != begin)
                return;
            if (chunk->records[i] == record) {
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
        for (size_t i = count_up_to(chunk->begins, chunk->count, address); i-- > 0;) {
            if (chunk->reaches[i] <= address)
                break;
            if (chunk->ends[i] > address)
                visit(chunk->records[i], context);
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
    free(map->firsts);
    *map = (struct address_map){0};
}
