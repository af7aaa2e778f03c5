/* SPDX-License-Identifier: Apache-2.0 */
/* The ordered set of address ranges. */
#include "state/address_map.h"

#include <stdlib.h>
#include <string.h>

enum { CHUNK_ENTRIES = 32, FIRST_CHUNKS = 8, CACHE_LINE = 64, NEAR = 4 };

/* A search reads `begins` alone, and one of the others for what it finds. */
struct address_chunk {
    uint64_t reach_before; /* the largest end in all chunks before this one */
    size_t count;          /* never 0 between calls */
    uint64_t begins[CHUNK_ENTRIES];
    struct address_entry {
        uint64_t end, reach; /* the largest end of this chunk's entries up to this one */
        void *record;
    } entries[CHUNK_ENTRIES];
};

/* The number of values, in ascending order, that are at most `limit`. Without branches on them,
 * which no processor could predict. */
static size_t count_up_to(const uint64_t *values, size_t count, uint64_t limit)
{
    size_t low = 0;
    while (count > 1) {
        size_t half = count / 2;
        low += half & -(size_t)(values[low + half - 1] <= limit);
        count -= half;
    }
    return low + (count && values[low] <= limit);
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
    return larger_of(chunk->reach_before,
                     chunk->count ? chunk->entries[chunk->count - 1].reach : 0);
}

/* Restores the reaches from entry `from` of chunk `c` on, and `reach_before` of the chunks from
 * `c` + 1 on, up to the first where it is right already. */
static void restore_reach(struct address_map *map, size_t c, size_t from)
{
    struct address_chunk *chunk = map->chunks[c];
    for (size_t i = from; i < chunk->count; i++)
        chunk->entries[i].reach =
            larger_of(chunk->entries[i].end, i ? chunk->entries[i - 1].reach : 0);
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
static void move_entries(struct address_chunk *target, size_t to,
                         const struct address_chunk *source, size_t from, size_t count)
{
    memmove(&target->begins[to], &source->begins[from], count * sizeof(source->begins[0]));
    memmove(&target->entries[to], &source->entries[from], count * sizeof(source->entries[0]));
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
    chunk->entries[at] = (struct address_entry){.end = begin + size, .record = record};
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
            if (chunk->entries[i].record == record) {
                remove_entry(map, c, i);
                return;
            }
        }
    }
}

static struct address_position fetch_chunk(const struct address_map *map, size_t c)
{
    const char *chunk = (const char *)map->chunks[c];
    for (size_t i = 0; i < offsetof(struct address_chunk, entries); i += CACHE_LINE)
        __builtin_prefetch(chunk + i);
    return (struct address_position){.chunk = c};
}

struct address_position address_map_find_chunk(const struct address_map *map, uint64_t address)
{
    if (!map->chunk_count)
        return (struct address_position){0};
    return fetch_chunk(map, chunk_of(map, address));
}

struct address_position address_map_find_chunk_near(const struct address_map *map, uint64_t address,
                                                    const struct address_position *found,
                                                    unsigned count)
{
    for (unsigned i = 0; map->chunk_count && i < count && i < NEAR; i++) {
        size_t c = found[count - 1 - i].chunk;
        if (map->firsts[c] <= address &&
            (c + 1 == map->chunk_count || address < map->firsts[c + 1]))
            return fetch_chunk(map, c);
    }
    return address_map_find_chunk(map, address);
}

void address_map_find_entry(const struct address_map *map, uint64_t address,
                            struct address_position *position)
{
    if (!map->chunk_count)
        return;
    const struct address_chunk *chunk = map->chunks[position->chunk];
    position->entry = count_up_to(chunk->begins, chunk->count, address);
    if (position->entry)
        __builtin_prefetch(&chunk->entries[position->entry - 1]);
}

void address_map_fetch(const struct address_map *map, struct address_position position)
{
    if (!position.entry)
        return;
    const char *record = map->chunks[position.chunk]->entries[position.entry - 1].record;
    __builtin_prefetch(record);
    __builtin_prefetch(record + CACHE_LINE - 1);
}

void *address_map_only(const struct address_map *map, struct address_position position,
                       uint64_t address)
{
    if (!position.entry)
        return NULL;
    const struct address_chunk *chunk = map->chunks[position.chunk];
    const struct address_entry *entry = &chunk->entries[position.entry - 1];
    uint64_t before = position.entry > 1 ? entry[-1].reach : 0;
    bool is_only = before <= address && chunk->reach_before <= address && entry->end > address;
    return is_only ? entry->record : NULL;
}

/* In the chunks before its own every range begins before the address. */
void address_map_visit(const struct address_map *map, struct address_position position,
                       uint64_t address, void (*visit)(void *record, void *context), void *context)
{
    if (!map->chunk_count)
        return;
    for (size_t c = position.chunk, end = position.entry;; end = map->chunks[--c]->count) {
        const struct address_chunk *chunk = map->chunks[c];
        for (size_t i = end; i-- > 0;) {
            if (chunk->entries[i].reach <= address)
                break;
            if (chunk->entries[i].end > address)
                visit(chunk->entries[i].record, context);
        }
        if (chunk->reach_before <= address || c == 0)
            return;
    }
}

void address_map_find(const struct address_map *map, uint64_t address,
                      void (*visit)(void *record, void *context), void *context)
{
    struct address_position position = address_map_find_chunk(map, address);
    address_map_find_entry(map, address, &position);
    address_map_visit(map, position, address, visit, context);
}

void address_map_release(struct address_map *map)
{
    for (size_t c = 0; c < map->chunk_count; c++)
        free(map->chunks[c]);
    free(map->chunks);
    free(map->firsts);
    *map = (struct address_map){0};
}

void address_map_each(const struct address_map *map,
                      void (*visit)(uint64_t begin, uint64_t end, void *record, void *context),
                      void *context)
{
    for (size_t c = 0; c < map->chunk_count; c++) {
        const struct address_chunk *chunk = map->chunks[c];
        for (size_t i = 0; i < chunk->count; i++)
            visit(chunk->begins[i], chunk->entries[i].end, chunk->entries[i].record, context);
    }
}
