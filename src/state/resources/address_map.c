/* SPDX-License-Identifier: Apache-2.0 */
/* The ordered set of buffer ranges. */
#include "src/state/resources/address_map.h"

#include <stdlib.h>
#include <string.h>

enum { CHUNK_RANGES = 16, FIRST_CHUNKS = 8, FIRST_SLOTS = 128, CACHE_LINE = 64 };
/* Guesses are tuned again if one range in CROWDED_FRACTION has no guess of its own. */
enum { CROWDED_FRACTION = 16 };

_Static_assert(sizeof(struct address_facts) == CACHE_LINE, "a look-up reads one line");

/* Ranges in ascending order of addresses. */
struct address_chunk {
    uint64_t begins[CHUNK_RANGES];
    uint32_t slots[CHUNK_RANGES];
    size_t count; /* never 0 between calls */
};

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

/* ---- slots */

/* Returns the slot that an address hashes to or another way of it; if these are taken, the next
 * free slot after `cursor`. */
static uint32_t take_slot(const struct address_guesses *guesses, uint64_t address, size_t *cursor)
{
    size_t home = address_guesses_home(guesses, address >> guesses->grain_shift);
    for (size_t way = 0; way < ADDRESS_WAYS; way++)
        if (home != way && !guesses->ranges[home ^ way].bytes_left)
            return (uint32_t)(home ^ way);
    do
        *cursor = (*cursor + 1) & guesses->mask;
    while (!*cursor || guesses->ranges[*cursor].bytes_left);
    return (uint32_t)*cursor;
}

/* Copies a range into a slot. Returns whether its guess overwrites no other. */
static bool store_range(const struct address_guesses *guesses, const struct address_facts *range,
                        size_t *cursor, uint32_t *slot)
{
    *slot = take_slot(guesses, range->address, cursor);
    guesses->ranges[*slot] = *range;
    return address_guesses_remember(guesses, range->address, *slot) < ADDRESS_WAYS;
}

/* Returns the ascending addresses of all ranges; the caller frees them. NULL: no memory. */
static uint64_t *begins_of_all(const struct address_map *map)
{
    uint64_t *begins = malloc((map->range_count + 1) * sizeof(*begins)), *next = begins;
    for (size_t c = 0; begins && c < map->chunk_count; c++) {
        const struct address_chunk *chunk = map->chunks[c];
        memcpy(next, chunk->begins, chunk->count * sizeof(*next));
        next += chunk->count;
    }
    return begins;
}

/* Allocates `slot_count` slots and tunes the guesses for the ranges of the map. */
static bool rebuild(struct address_map *map, uint32_t slot_count)
{
    const struct address_guesses old = map->guesses;
    struct address_guesses guesses = {
        .items = aligned_alloc(CACHE_LINE, slot_count * sizeof(*guesses.items)),
        .ranges = aligned_alloc(CACHE_LINE, slot_count * sizeof(*guesses.ranges)),
        .mask = slot_count - 1};
    uint64_t *begins = begins_of_all(map);
    if (!guesses.items || !guesses.ranges || !begins) {
        free((void *)guesses.items);
        free(guesses.ranges);
        free(begins);
        return false;
    }
    address_guesses_tune(&guesses, begins, map->range_count);
    free(begins);
    memset(guesses.ranges, 0, slot_count * sizeof(*guesses.ranges));
    for (size_t c = 0; c < map->chunk_count; c++)
        for (size_t i = 0; i < map->chunks[c]->count; i++) {
            uint32_t *slot = &map->chunks[c]->slots[i];
            store_range(&guesses, &old.ranges[*slot], &map->cursor, slot);
        }
    free((void *)old.items);
    free(old.ranges);
    map->guesses = guesses;
    map->slot_count = slot_count;
    map->crowded = 0;
    map->tuned_for = map->range_count;
    return true;
}

/* Returns a number of slots of which at least half stay free after one more range is added. */
static uint32_t slots_for(uint32_t range_count)
{
    uint32_t slots = FIRST_SLOTS;
    while (range_count >= slots / 2)
        slots *= 2;
    return slots;
}

static bool reserve_slot(struct address_map *map)
{
    return map->range_count < map->slot_count / 2 || rebuild(map, slots_for(map->range_count));
}

/* Tunes the guesses again if too many ranges have none, or if the number of ranges has doubled or
 * halved. Halving frees slots. Keeps the old guesses if there is no memory. */
static void retune_if_needed(struct address_map *map)
{
    uint32_t count = map->range_count;
    if (map->crowded * CROWDED_FRACTION > count || count > 2 * map->tuned_for ||
        2 * count < map->tuned_for)
        rebuild(map, slots_for(count));
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
static size_t make_room(struct address_map *map, uint64_t address)
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
    if (!range->bytes_left || end <= begin || !reserve_slot(map))
        return false;
    size_t c = make_room(map, begin);
    if (c == map->chunk_count)
        return false;
    uint32_t slot;
    map->crowded += !store_range(&map->guesses, range, &map->cursor, &slot);
    map->range_count++;
    struct address_chunk *chunk = map->chunks[c];
    size_t at = count_up_to(chunk, begin);
    move_ranges(chunk, at + 1, chunk, at, chunk->count - at);
    chunk->begins[at] = begin;
    chunk->slots[at] = slot;
    chunk->count++;
    update_from(map, c);
    retune_if_needed(map);
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
    retune_if_needed(map);
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
    free(map->guesses.ranges);
    free((void *)map->guesses.items);
    *map = (struct address_map){0};
}
