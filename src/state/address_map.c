/* SPDX-License-Identifier: Apache-2.0 */
/* The ordered set of the places of buffers. */
#include "state/address_map.h"

#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

enum { CHUNK_PLACES = 12, FIRST_CHUNKS = 8, CACHE_LINE = 64 };
/* Addresses of a grain share a guess, which is good if it is not far before what is sought. */
enum { GRAIN_SHIFT = 11, GUESSES_PER_CHUNK_SHIFT = 4, FAR = 4 };

/* A search reads the first line, and one of the others for what it finds. */
struct address_chunk {
    uint64_t first;                 /* address of its first place */
    uint32_t offsets[CHUNK_PLACES]; /* of the addresses of all, from there; then UINT32_MAX */
    unsigned char count;            /* never 0 between calls */
    bool is_apart; /* no two places share an address, nor does one of an earlier chunk reach here */
    _Alignas(CACHE_LINE) struct buffer_place places[CHUNK_PLACES];
};
_Static_assert(sizeof(struct buffer_place) == CACHE_LINE &&
                   offsetof(struct address_chunk, places) == CACHE_LINE,
               "a look-up reads two lines");

static uint64_t end_of(const struct buffer_place *place)
{
    return place->address + place->size;
}

/* The number of places of a chunk that begin at or before `address`. Without branches, which no
 * processor could predict; compilers make it a few instructions. */
static size_t count_up_to(const struct address_chunk *chunk, uint64_t address)
{
    if (address < chunk->first)
        return 0;
    uint64_t distance = address - chunk->first;
    uint32_t limit = distance < UINT32_MAX ? (uint32_t)distance : UINT32_MAX;
    size_t count = 0;
    for (size_t i = 0; i < CHUNK_PLACES; i++)
        count += chunk->offsets[i] <= limit;
    return count < chunk->count ? count : chunk->count;
}

/* The last chunk that begins at or before `address`; chunk 0 if none does. */
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

/* ---- guesses */

static _Atomic uint32_t *guess_at(const struct address_map *map, uint64_t address)
{
    return &map->guesses[(address >> GRAIN_SHIFT) * 0x9E3779B97F4A7C15u >> (64 - map->guess_bits)];
}

/* The same as chunk_of, without a search where an address nearby was sought before. */
static size_t guess_chunk(const struct address_map *map, uint64_t address)
{
    _Atomic uint32_t *guess = guess_at(map, address);
    size_t c = atomic_load_explicit(guess, memory_order_relaxed);
    if (c < map->chunk_count && map->firsts[c] <= address)
        for (size_t last = c + FAR; c < last; c++)
            if (c + 1 == map->chunk_count || address < map->firsts[c + 1])
                return c;
    c = chunk_of(map, address);
    atomic_store_explicit(guess, (uint32_t)c, memory_order_relaxed);
    return c;
}

static bool reserve_guesses(struct address_map *map, size_t chunks)
{
    unsigned bits = GUESSES_PER_CHUNK_SHIFT + (unsigned)__builtin_ctzll(chunks);
    _Atomic uint32_t *guesses = calloc((size_t)1 << bits, sizeof(*guesses));
    if (!guesses)
        return false;
    free(map->guesses);
    map->guesses = guesses;
    map->guess_bits = bits;
    return true;
}

/* ---- what chunks know */

static uint64_t larger_of(uint64_t a, uint64_t b)
{
    return a > b ? a : b;
}

/* Restores what a chunk and the map know of its places; `reach` is that of the chunks before it.
 * Returns how far it reaches with them. */
static uint64_t settle_chunk(struct address_chunk *chunk, uint64_t reach)
{
    chunk->first = chunk->places[0].address;
    chunk->is_apart = true;
    for (size_t i = 0; i < CHUNK_PLACES; i++) {
        const struct buffer_place *place = &chunk->places[i];
        if (i >= chunk->count) {
            chunk->offsets[i] = UINT32_MAX;
            continue;
        }
        chunk->offsets[i] = (uint32_t)(place->address - chunk->first);
        chunk->is_apart = chunk->is_apart && reach <= place->address;
        reach = larger_of(reach, end_of(place));
    }
    return reach;
}

/* Restores what is known of chunk `c`, which has changed, and of those behind it as far as it
 * reaches otherwise than before. */
static void settle(struct address_map *map, size_t c)
{
    bool reaches_otherwise = true;
    for (; reaches_otherwise && c < map->chunk_count; c++) {
        uint64_t reach = settle_chunk(map->chunks[c], c ? map->reaches[c - 1] : 0);
        reaches_otherwise = map->reaches[c] != reach;
        map->reaches[c] = reach;
        map->firsts[c] = map->chunks[c]->first;
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
        !reserve_items(&map->reaches, capacity * sizeof(*map->reaches)) ||
        !reserve_guesses(map, capacity))
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
    struct address_chunk *chunk = aligned_alloc(CACHE_LINE, sizeof(*chunk));
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
static void move_places(struct address_chunk *target, size_t to, const struct address_chunk *source,
                        size_t from, size_t count)
{
    memmove(&target->places[to], &source->places[from], count * sizeof(source->places[0]));
}

/* Moves the places of a full chunk from `from` on into a new one behind it. */
static bool split_chunk(struct address_map *map, size_t c, size_t from)
{
    struct address_chunk *upper = insert_chunk(map, c + 1);
    if (!upper)
        return false;
    struct address_chunk *lower = map->chunks[c];
    upper->count = (unsigned char)(lower->count - from);
    lower->count = (unsigned char)from;
    move_places(upper, 0, lower, from, upper->count);
    settle(map, c);
    settle(map, c + 1);
    return true;
}

/* ---- changes */

/* Whether a chunk can tell how far `address` is from all its others. */
static bool spans(const struct address_chunk *chunk, uint64_t address)
{
    uint64_t last = chunk->places[chunk->count - 1].address;
    return address < chunk->first ? last - address < UINT32_MAX
                                  : address - chunk->first < UINT32_MAX;
}

/* The index of a chunk for a place at `address`, with room for it; chunk_count without memory. */
static size_t make_room(struct address_map *map, uint64_t address)
{
    size_t c = map->chunk_count ? chunk_of(map, address) : 0;
    if (!map->chunk_count || !spans(map->chunks[c], address)) {
        if (map->chunk_count && map->firsts[c] <= address)
            c++;
        return insert_chunk(map, c) ? c : map->chunk_count;
    }
    const struct address_chunk *chunk = map->chunks[c];
    if (chunk->count < CHUNK_PLACES)
        return c;
    /* What comes in ascending order fills chunks. */
    if (address >= chunk->places[CHUNK_PLACES - 1].address)
        return insert_chunk(map, c + 1) ? c + 1 : map->chunk_count;
    if (!split_chunk(map, c, CHUNK_PLACES / 2))
        return map->chunk_count;
    return chunk_of(map, address);
}

bool address_map_add(struct address_map *map, const struct buffer_place *place)
{
    uint64_t begin = place->address, end = end_of(place);
    if (!place->size || end <= begin)
        return false;
    size_t c = make_room(map, begin);
    if (c == map->chunk_count)
        return false;
    struct address_chunk *chunk = map->chunks[c];
    size_t at = chunk->count ? count_up_to(chunk, begin) : 0;
    move_places(chunk, at + 1, chunk, at, chunk->count - at);
    chunk->places[at] = *place;
    chunk->count++;
    settle(map, c);
    return true;
}

static void remove_place(struct address_map *map, size_t c, size_t at)
{
    struct address_chunk *chunk = map->chunks[c];
    chunk->count--;
    move_places(chunk, at, chunk, at + 1, chunk->count - at);
    if (!chunk->count)
        remove_chunk(map, c);
    settle(map, c);
}

/* Finds the place of that address and id. Equal addresses may lie in several chunks, so look back
 * from the last of them. */
static bool find_place(const struct address_map *map, const struct buffer_place *place,
                       struct address_position *position)
{
    if (!map->chunk_count)
        return false;
    for (size_t c = chunk_of(map, place->address) + 1; c-- > 0;) {
        const struct address_chunk *chunk = map->chunks[c];
        for (size_t i = count_up_to(chunk, place->address); i-- > 0;) {
            if (chunk->places[i].address != place->address)
                return false;
            if (chunk->places[i].id == place->id) {
                *position = (struct address_position){c, i};
                return true;
            }
        }
    }
    return false;
}

void address_map_update(struct address_map *map, const struct buffer_place *place)
{
    struct address_position position;
    if (find_place(map, place, &position))
        map->chunks[position.chunk]->places[position.entry] = *place;
}

void address_map_remove(struct address_map *map, const struct buffer_place *place)
{
    struct address_position position;
    if (find_place(map, place, &position))
        remove_place(map, position.chunk, position.entry);
}

/* ---- look-ups */

struct address_position address_map_find_chunk(const struct address_map *map, uint64_t address)
{
    if (!map->chunk_count)
        return (struct address_position){0};
    size_t c = guess_chunk(map, address);
    __builtin_prefetch(map->chunks[c]);
    return (struct address_position){.chunk = c};
}

void address_map_find_entry(const struct address_map *map, uint64_t address,
                            struct address_position *position)
{
    if (!map->chunk_count)
        return;
    const struct address_chunk *chunk = map->chunks[position->chunk];
    position->entry = count_up_to(chunk, address);
    if (position->entry)
        __builtin_prefetch(&chunk->places[position->entry - 1]);
}

const struct buffer_place *address_map_only(const struct address_map *map,
                                            struct address_position position, uint64_t address)
{
    if (!position.entry)
        return NULL;
    const struct address_chunk *chunk = map->chunks[position.chunk];
    const struct buffer_place *place = &chunk->places[position.entry - 1];
    return chunk->is_apart && address < end_of(place) ? place : NULL;
}

/* In the chunks before its own every place begins before the address. */
void address_map_visit(const struct address_map *map, struct address_position position,
                       uint64_t address, place_visitor visit, void *context)
{
    if (!map->chunk_count)
        return;
    for (size_t c = position.chunk, end = position.entry;; end = map->chunks[--c]->count) {
        const struct address_chunk *chunk = map->chunks[c];
        for (size_t i = end; i-- > 0;)
            if (address < end_of(&chunk->places[i]))
                visit(&chunk->places[i], context);
        if (c == 0 || map->reaches[c - 1] <= address)
            return;
    }
}

void address_map_find(const struct address_map *map, uint64_t address, place_visitor visit,
                      void *context)
{
    struct address_position position = address_map_find_chunk(map, address);
    address_map_find_entry(map, address, &position);
    address_map_visit(map, position, address, visit, context);
}

void address_map_each(const struct address_map *map, place_visitor visit, void *context)
{
    for (size_t c = 0; c < map->chunk_count; c++)
        for (size_t i = 0; i < map->chunks[c]->count; i++)
            visit(&map->chunks[c]->places[i], context);
}

void address_map_release(struct address_map *map)
{
    for (size_t c = 0; c < map->chunk_count; c++)
        free(map->chunks[c]);
    free(map->chunks);
    free(map->firsts);
    free(map->reaches);
    free(map->guesses);
    *map = (struct address_map){0};
}
