/* SPDX-License-Identifier: Apache-2.0 */
/* The ordered set of buffer ranges. */
#include "src/state/resources/address_map.h"

#include <stdlib.h>
#include <string.h>

#include "src/platform/aligned.h"
#include "src/state/resources/address_slots.h"

enum { FIRST_CHUNKS = 8 };

static uint64_t end_of(const struct address_facts *range)
{
    return range->address + range->bytes_left;
}

/* Returns the number of ranges of a chunk that begin at or before `address`. */
static size_t count_up_to(const struct address_chunk *chunk, uint64_t address)
{
    size_t count = 0;
    for (size_t i = 0; i < chunk->count; i++)
        count += chunk->begins[i] <= address;
    return count;
}

/* Returns the last chunk that begins at or before `address`, else chunk 0. Branchless, because no
 * processor could predict the branches. */
static size_t chunk_of(const struct address_map *map, uint64_t address)
{
    size_t low = 0, count = map->chunk_count;
    while (count > 1) {
        size_t half = count / 2;
        low += half & -(size_t)(map->firsts[low + half] <= address);
        count -= half;
    }
    return low;
}

/* ---- what is derived from all ranges together */

static uint64_t larger_of(uint64_t a, uint64_t b)
{
    return a > b ? a : b;
}

/* Returns where the range after range `i` of chunk `c` begins. */
static uint64_t begin_of_next(const struct address_map *map, size_t c, size_t i)
{
    if (i + 1 < map->chunks[c]->count)
        return map->chunks[c]->begins[i + 1];
    return c + 1 < map->chunk_count ? map->chunks[c + 1]->begins[0] : UINT64_MAX;
}

/* Recomputes is_shared of the ranges of a chunk. `reach` is the largest end in the chunks before
 * it. Returns the largest end including this chunk. */
static uint64_t update_chunk(struct address_map *map, size_t c, uint64_t reach)
{
    const struct address_chunk *chunk = map->chunks[c];
    for (size_t i = 0; i < chunk->count; i++) {
        struct address_facts *range = &map->guesses.ranges[chunk->slots[i]];
        uint64_t end = end_of(range);
        range->is_shared = reach > range->address || end > begin_of_next(map, c, i);
        reach = larger_of(reach, end);
    }
    return reach;
}

/* Recomputes what is derived from the ranges after chunk `changed` has changed: for that chunk, for
 * the one before it, whose last range has a new successor, and for the following chunks until the
 * reach stays the same. */
static void update_from(struct address_map *map, size_t changed)
{
    bool reach_changed = true;
    for (size_t c = changed ? changed - 1 : 0;
         c < map->chunk_count && (c <= changed || reach_changed); c++) {
        uint64_t reach = update_chunk(map, c, c ? map->reaches[c - 1] : 0);
        reach_changed = map->reaches[c] != reach;
        map->reaches[c] = reach;
        map->firsts[c] = map->chunks[c]->begins[0];
    }
}

/* ---- chunks */

static bool reserve_items(void *array, size_t size)
{
    void *grown = realloc(*(void **)array, size);
    if (grown)
        *(void **)array = grown;
    return grown;
}

static bool reserve_chunks(struct address_map *map)
{
    if (map->chunk_count < map->chunk_capacity)
        return true;
    size_t capacity = map->chunk_capacity ? map->chunk_capacity * 2 : FIRST_CHUNKS;
    if (!reserve_items(&map->chunks, capacity * sizeof(*map->chunks)) ||
        !reserve_items(&map->firsts, capacity * sizeof(*map->firsts)) ||
        !reserve_items(&map->reaches, capacity * sizeof(*map->reaches)))
        return false;
    map->chunk_capacity = capacity;
    return true;
}

/* Moves the items of the parallel arrays from index `from` on to index `to`. */
static void move_chunks(struct address_map *map, size_t to, size_t from)
{
    size_t count = map->chunk_count - from;
    memmove(&map->chunks[to], &map->chunks[from], count * sizeof(*map->chunks));
    memmove(&map->firsts[to], &map->firsts[from], count * sizeof(*map->firsts));
    memmove(&map->reaches[to], &map->reaches[from], count * sizeof(*map->reaches));
}

/* Inserts an empty chunk at index `c`. Returns NULL if there is no memory. */
static struct address_chunk *insert_chunk(struct address_map *map, size_t c)
{
    if (!reserve_chunks(map))
        return NULL;
    struct address_chunk *chunk = malloc(sizeof(*chunk));
    if (!chunk)
        return NULL;
    chunk->count = 0;
    move_chunks(map, c + 1, c);
    map->chunks[c] = chunk;
    map->reaches[c] = c ? map->reaches[c - 1] : 0;
    map->chunk_count++;
    return chunk;
}

static void remove_chunk(struct address_map *map, size_t c)
{
    free(map->chunks[c]);
    move_chunks(map, c, c + 1);
    map->chunk_count--;
}

/* Moves `count` ranges to index `to` of `target`; `source` may be the same chunk. */
static void move_ranges(struct address_chunk *target, size_t to, const struct address_chunk *source,
                        size_t from, size_t count)
{
    memmove(&target->begins[to], &source->begins[from], count * sizeof(source->begins[0]));
    memmove(&target->slots[to], &source->slots[from], count * sizeof(source->slots[0]));
}

/* Moves the ranges of a full chunk from index `from` on into a new chunk after it. */
static bool split_chunk(struct address_map *map, size_t c, size_t from)
{
    struct address_chunk *upper = insert_chunk(map, c + 1);
    if (!upper)
        return false;
    struct address_chunk *lower = map->chunks[c];
    upper->count = lower->count - from;
    lower->count = from;
    move_ranges(upper, 0, lower, from, upper->count);
    update_from(map, c);
    update_from(map, c + 1);
    return true;
}

/* ---- changes */

/* Returns a chunk that has room for a range at `address`, or chunk_count if there is no memory. */
static size_t make_room_in_chunk(struct address_map *map, uint64_t address)
{
    if (!map->chunk_count)
        return insert_chunk(map, 0) ? 0 : map->chunk_count;
    size_t c = chunk_of(map, address);
    const struct address_chunk *chunk = map->chunks[c];
    if (chunk->count < CHUNK_RANGES)
        return c;
    /* Ranges added in ascending order fill chunks completely. */
    if (address >= chunk->begins[CHUNK_RANGES - 1])
        return insert_chunk(map, c + 1) ? c + 1 : map->chunk_count;
    if (!split_chunk(map, c, CHUNK_RANGES / 2))
        return map->chunk_count;
    return chunk_of(map, address);
}

bool address_map_add(struct address_map *map, const struct address_facts *range)
{
    uint64_t begin = range->address, end = end_of(range);
    if (!range->bytes_left || end <= begin || !address_map_reserve_slot(map))
        return false;
    size_t c = make_room_in_chunk(map, begin);
    if (c == map->chunk_count)
        return false;
    uint32_t slot;
    map->crowded += !address_map_store(map, range, &slot);
    map->range_count++;
    struct address_chunk *chunk = map->chunks[c];
    size_t at = count_up_to(chunk, begin);
    move_ranges(chunk, at + 1, chunk, at, chunk->count - at);
    chunk->begins[at] = begin;
    chunk->slots[at] = slot;
    chunk->count++;
    update_from(map, c);
    address_map_retune_if_needed(map);
    return true;
}

/* The position of a range in the ordered set. */
struct position {
    size_t chunk, entry;
};

static struct address_facts *range_at(const struct address_map *map, struct position position)
{
    return &map->guesses.ranges[map->chunks[position.chunk]->slots[position.entry]];
}

/* Finds the range with that address and buffer_id. Equal addresses may lie in several chunks, so
 * searches back from the last one. */
static bool find_range(const struct address_map *map, const struct address_facts *range,
                       struct position *position)
{
    if (!map->chunk_count)
        return false;
    for (size_t c = chunk_of(map, range->address) + 1; c-- > 0;) {
        for (size_t i = count_up_to(map->chunks[c], range->address); i-- > 0;) {
            *position = (struct position){c, i};
            if (map->chunks[c]->begins[i] != range->address)
                return false;
            if (range_at(map, *position)->buffer_id == range->buffer_id)
                return true;
        }
    }
    return false;
}

void address_map_update(struct address_map *map, const struct address_facts *range)
{
    struct position position;
    if (!find_range(map, range, &position))
        return;
    struct address_facts *stored = range_at(map, position);
    bool is_shared = stored->is_shared;
    *stored = *range;
    stored->is_shared = is_shared;
}

void address_map_remove(struct address_map *map, const struct address_facts *range)
{
    struct position position;
    if (!find_range(map, range, &position))
        return;
    size_t c = position.chunk, at = position.entry;
    struct address_chunk *chunk = map->chunks[c];
    map->guesses.ranges[chunk->slots[at]] = (struct address_facts){0};
    map->range_count--;
    chunk->count--;
    move_ranges(chunk, at, chunk, at + 1, chunk->count - at);
    if (!chunk->count)
        remove_chunk(map, c);
    update_from(map, c);
    address_map_retune_if_needed(map);
}

/* ---- look-ups */

struct address_guesses address_map_guesses(const struct address_map *map)
{
    static _Atomic uint32_t no_items[ADDRESS_WAYS];
    static struct address_facts no_range;
    if (map && map->slot_count)
        return map->guesses;
    return (struct address_guesses){.items = no_items, .ranges = &no_range};
}

/* Every range in the chunks before chunk_of(address) begins before the address. */
void address_map_find(const struct address_map *map, uint64_t address, buffer_range_visitor visit,
                      void *context)
{
    if (!map->chunk_count)
        return;
    size_t c = chunk_of(map, address);
    for (size_t end = count_up_to(map->chunks[c], address);; end = map->chunks[--c]->count) {
        const struct address_chunk *chunk = map->chunks[c];
        for (size_t i = end; i-- > 0;) {
            const struct address_facts *range = &map->guesses.ranges[chunk->slots[i]];
            if (!buffer_range_contains(range, address))
                continue;
            address_guesses_remember(&map->guesses, address, chunk->slots[i]);
            visit(range, context);
        }
        if (c == 0 || map->reaches[c - 1] <= address)
            return;
    }
}

const struct address_facts *address_map_before(const struct address_map *map, uint64_t address)
{
    if (!map->chunk_count)
        return NULL;
    const struct address_chunk *chunk = map->chunks[chunk_of(map, address)];
    const size_t count = count_up_to(chunk, address);
    return count ? &map->guesses.ranges[chunk->slots[count - 1]] : NULL;
}

void address_map_each(const struct address_map *map, buffer_range_visitor visit, void *context)
{
    for (size_t c = 0; c < map->chunk_count; c++)
        for (size_t i = 0; i < map->chunks[c]->count; i++)
            visit(&map->guesses.ranges[map->chunks[c]->slots[i]], context);
}

void address_map_release(struct address_map *map)
{
    for (size_t c = 0; c < map->chunk_count; c++)
        free(map->chunks[c]);
    free(map->chunks);
    free(map->firsts);
    free(map->reaches);
    aligned_free(map->guesses.ranges);
    aligned_free((void *)map->guesses.items);
    *map = (struct address_map){0};
}
