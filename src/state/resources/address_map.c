/* SPDX-License-Identifier: Apache-2.0 */
/* The ordered set of the places of buffers. */
#include "src/state/resources/address_map.h"

#include <stdlib.h>
#include <string.h>

enum { CHUNK_PLACES = 16, FIRST_CHUNKS = 8, FIRST_SLOTS = 128, CACHE_LINE = 64 };
/* Guesses are chosen anew where one in so many places has no room among them. */
enum { CROWD = 16 };

_Static_assert(sizeof(struct address_facts) == CACHE_LINE, "a look-up reads one line");

/* Places in order. */
struct address_chunk {
    uint64_t begins[CHUNK_PLACES];
    uint32_t slots[CHUNK_PLACES];
    size_t count; /* never 0 between calls */
};

static uint64_t end_of(const struct address_facts *range)
{
    return range->address + range->bytes_left;
}

/* The number of places of a chunk that begin at or before `address`. */
static size_t count_up_to(const struct address_chunk *chunk, uint64_t address)
{
    size_t count = 0;
    for (size_t i = 0; i < chunk->count; i++)
        count += chunk->begins[i] <= address;
    return count;
}

/* The last chunk that begins at or before `address`; chunk 0 if none does. Without branches, which
 * no processor could predict. */
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

/* ---- what is known of places together */

static uint64_t larger_of(uint64_t a, uint64_t b)
{
    return a > b ? a : b;
}

/* The beginning of the place behind place `i` of chunk `c`. */
static uint64_t begin_of_next(const struct address_map *map, size_t c, size_t i)
{
    if (i + 1 < map->chunks[c]->count)
        return map->chunks[c]->begins[i + 1];
    return c + 1 < map->chunk_count ? map->chunks[c + 1]->begins[0] : UINT64_MAX;
}

/* Restores what a chunk and the map know of its places; `reach` is that of the chunks before it.
 * Returns how far it reaches with them. */
static uint64_t settle_chunk(struct address_map *map, size_t c, uint64_t reach)
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

/* Restores what is known of chunk `c`, which has changed, of the one before it, whose last place
 * has another behind it now, and of those behind it as far as it reaches otherwise than before. */
static void settle(struct address_map *map, size_t changed)
{
    bool reaches_otherwise = true;
    for (size_t c = changed ? changed - 1 : 0;
         c < map->chunk_count && (c <= changed || reaches_otherwise); c++) {
        uint64_t reach = settle_chunk(map, c, c ? map->reaches[c - 1] : 0);
        reaches_otherwise = map->reaches[c] != reach;
        map->reaches[c] = reach;
        map->firsts[c] = map->chunks[c]->begins[0];
    }
}

/* ---- slots */

/* The slot that an address leads to or one beside it, or, where these are taken, the next behind
 * `cursor` that isn't. */
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

/* Puts a place into a slot; returns whether there is room for a guess at it. */
static bool settle_range(const struct address_guesses *guesses, const struct address_facts *range,
                         size_t *cursor, uint32_t *slot)
{
    *slot = take_slot(guesses, range->address, cursor);
    guesses->ranges[*slot] = *range;
    return address_guesses_remember(guesses, range->address, *slot) < ADDRESS_WAYS;
}

/* Where places begin, in their order; NULL without memory. */
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

/* Makes so many slots, chosen anew for the places that there are. */
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
            settle_range(&guesses, &old.ranges[*slot], &map->cursor, slot);
        }
    free((void *)old.items);
    free(old.ranges);
    map->guesses = guesses;
    map->slot_count = slot_count;
    map->crowded = 0;
    map->chosen_for = map->range_count;
    return true;
}

/* So many that half of them at least stay free, also when one place more comes. */
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

/* Chooses guesses anew, if that succeeds, where they are for others than there are: where places
 * crowd, and whenever there are twice as many as there were, or half as many, which gives back
 * slots. */
static void adapt(struct address_map *map)
{
    uint32_t count = map->range_count;
    if (map->crowded * CROWD > count || count > 2 * map->chosen_for || 2 * count < map->chosen_for)
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

/* Moves the items of chunks from `from` on to `to`. */
static void move_chunks(struct address_map *map, size_t to, size_t from)
{
    size_t count = map->chunk_count - from;
    memmove(&map->chunks[to], &map->chunks[from], count * sizeof(*map->chunks));
    memmove(&map->firsts[to], &map->firsts[from], count * sizeof(*map->firsts));
    memmove(&map->reaches[to], &map->reaches[from], count * sizeof(*map->reaches));
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

/* Moves `count` places from `from` of one chunk to `to` of another, or of the same. */
static void move_ranges(struct address_chunk *target, size_t to, const struct address_chunk *source,
                        size_t from, size_t count)
{
    memmove(&target->begins[to], &source->begins[from], count * sizeof(source->begins[0]));
    memmove(&target->slots[to], &source->slots[from], count * sizeof(source->slots[0]));
}

/* Moves the places of a full chunk from `from` on into a new one behind it. */
static bool split_chunk(struct address_map *map, size_t c, size_t from)
{
    struct address_chunk *upper = insert_chunk(map, c + 1);
    if (!upper)
        return false;
    struct address_chunk *lower = map->chunks[c];
    upper->count = lower->count - from;
    lower->count = from;
    move_ranges(upper, 0, lower, from, upper->count);
    settle(map, c);
    settle(map, c + 1);
    return true;
}

/* ---- changes */

/* The index of a chunk for a place at `address`, with room for it; chunk_count without memory. */
static size_t make_room(struct address_map *map, uint64_t address)
{
    if (!map->chunk_count)
        return insert_chunk(map, 0) ? 0 : map->chunk_count;
    size_t c = chunk_of(map, address);
    const struct address_chunk *chunk = map->chunks[c];
    if (chunk->count < CHUNK_PLACES)
        return c;
    /* What comes in ascending order fills chunks. */
    if (address >= chunk->begins[CHUNK_PLACES - 1])
        return insert_chunk(map, c + 1) ? c + 1 : map->chunk_count;
    if (!split_chunk(map, c, CHUNK_PLACES / 2))
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
    map->crowded += !settle_range(&map->guesses, range, &map->cursor, &slot);
    map->range_count++;
    struct address_chunk *chunk = map->chunks[c];
    size_t at = count_up_to(chunk, begin);
    move_ranges(chunk, at + 1, chunk, at, chunk->count - at);
    chunk->begins[at] = begin;
    chunk->slots[at] = slot;
    chunk->count++;
    settle(map, c);
    adapt(map);
    return true;
}

/* Where a place is in the order. */
struct position {
    size_t chunk, entry;
};

static struct address_facts *range_at(const struct address_map *map, struct position position)
{
    return &map->guesses.ranges[map->chunks[position.chunk]->slots[position.entry]];
}

/* Finds the place of that address and buffer. Equal addresses may lie in several chunks, so look
 * back from the last of them. */
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
    struct address_facts *kept = range_at(map, position);
    bool is_shared = kept->is_shared;
    *kept = *range;
    kept->is_shared = is_shared;
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
    settle(map, c);
    adapt(map);
}

/* ---- look-ups */

struct address_guesses address_map_guesses(const struct address_map *map)
{
    static _Atomic uint32_t no_items[ADDRESS_WAYS];
    static struct address_facts nobody;
    if (map && map->slot_count)
        return map->guesses;
    return (struct address_guesses){.items = no_items, .ranges = &nobody};
}

/* In the chunks before its own every place begins before the address. */
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
