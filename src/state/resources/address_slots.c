/* SPDX-License-Identifier: Apache-2.0 */
/* Slots of an address map, and guesses of the buffer range that contains a device address. */
#include "src/state/resources/address_slots.h"

#include <stdlib.h>
#include <string.h>

#include "src/platform/aligned.h"

/* Returns the item of a grain in way `way`; way 0 is tried first. */
static inline _Atomic uint32_t *address_guesses_item(const struct address_guesses *guesses,
                                                     uint64_t grain, size_t way)
{
    return &guesses->items[address_guesses_home(guesses, grain) ^ way];
}

/* Returns whether the tag of a guess matches the grain. */
static inline bool address_guesses_matches(const struct address_guesses *guesses, uint32_t guess,
                                           uint64_t grain)
{
    return (guess ^ (uint32_t)grain * 0x9e3779b9u) <= guesses->mask;
}

enum { LARGEST_GRAIN = 40, SMALLEST_GRAIN = 8, FACTORS = 16 };

const struct address_facts *address_guesses_second(const struct address_guesses *guesses,
                                                   uint64_t address)
{
    uint64_t grain = address >> guesses->grain_shift;
    uint32_t guess = 0;
    for (size_t way = 0; way < ADDRESS_WAYS; way++) {
        guess =
            atomic_load_explicit(address_guesses_item(guesses, grain, way), memory_order_relaxed);
        if (address_guesses_matches(guesses, guess, grain))
            break;
    }
    return &guesses->ranges[guess & guesses->mask];
}

unsigned address_guesses_remember(const struct address_guesses *guesses, uint64_t address,
                                  uint32_t slot)
{
    uint64_t grain = address >> guesses->grain_shift;
    uint32_t guess = ((uint32_t)grain * 0x9e3779b9u & ~guesses->mask) | slot;
    for (unsigned way = 0; way < ADDRESS_WAYS; way++) {
        _Atomic uint32_t *item = address_guesses_item(guesses, grain, way);
        uint32_t old = atomic_load_explicit(item, memory_order_relaxed);
        if (old && !address_guesses_matches(guesses, old, grain))
            continue;
        atomic_store_explicit(item, guess, memory_order_relaxed);
        return old && old != guess ? ADDRESS_WAYS : way;
    }
    atomic_store_explicit(address_guesses_item(guesses, grain, slot % ADDRESS_WAYS), guess,
                          memory_order_relaxed);
    return ADDRESS_WAYS;
}

static void forget_all(const struct address_guesses *guesses)
{
    memset((void *)guesses->items, 0, ((size_t)guesses->mask + 1) * sizeof(*guesses->items));
}

/* The best parameters found so far. */
struct choice {
    const uint64_t *addresses;
    size_t count;
    unsigned grain_shift;
    uint64_t factor;
    uint64_t cost; /* items that are tried and don't match before every range is found */
};

static void try_parameters(struct address_guesses *guesses, unsigned grain_shift, uint64_t factor,
                           struct choice *best)
{
    uint64_t cost = 0;
    guesses->grain_shift = grain_shift;
    guesses->factor = factor;
    forget_all(guesses);
    for (size_t i = 0; i < best->count && cost < best->cost; i++)
        cost += address_guesses_remember(guesses, best->addresses[i], (uint32_t)i + 1);
    if (cost >= best->cost)
        return;
    best->cost = cost;
    best->grain_shift = grain_shift;
    best->factor = factor;
}

/* Chooses the grain size and hash multiplier for `count` ranges that begin at `addresses`. `count`
 * is less than the number of slots. Clears all items.
 *
 * Prefers the largest grain that separates the ranges, with slots in address order: neighbours then
 * share a cache line, and a large buffer needs few guesses. If the ranges are too unevenly spaced
 * for that, uses the smallest grain and the multiplier that spreads these ranges best. */
static void address_guesses_tune(struct address_guesses *guesses, const uint64_t *addresses,
                                 size_t count)
{
    const uint64_t in_order = (uint64_t)1 << 32, good = count / 16;
    struct choice best = {.addresses = addresses, .count = count, .cost = UINT64_MAX};
    for (unsigned shift = LARGEST_GRAIN; shift >= SMALLEST_GRAIN && best.cost > good; shift--)
        try_parameters(guesses, shift, in_order, &best);
    uint64_t factor = 0x9e3779b97f4a7c15u; /* 2^64 / phi, and its powers */
    for (unsigned i = 0; i < FACTORS && best.cost > good; i++, factor *= 0x9e3779b97f4a7c15u)
        try_parameters(guesses, SMALLEST_GRAIN, factor, &best);
    guesses->grain_shift = best.grain_shift;
    guesses->factor = best.factor;
    forget_all(guesses);
}

/* ---- slots of an address map */

enum { FIRST_SLOTS = 128, CACHE_LINE = 64 };
/* Guesses are tuned again if one range in CROWDED_FRACTION has no guess of its own. */
enum { CROWDED_FRACTION = 16 };

_Static_assert(sizeof(struct address_facts) == CACHE_LINE, "a look-up reads one line");

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
        .items = aligned_allocate(CACHE_LINE, slot_count * sizeof(*guesses.items)),
        .ranges = aligned_allocate(CACHE_LINE, slot_count * sizeof(*guesses.ranges)),
        .mask = slot_count - 1};
    uint64_t *begins = begins_of_all(map);
    if (!guesses.items || !guesses.ranges || !begins) {
        aligned_free((void *)guesses.items);
        aligned_free(guesses.ranges);
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
    aligned_free((void *)old.items);
    aligned_free(old.ranges);
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

bool address_map_reserve_slot(struct address_map *map)
{
    return map->range_count < map->slot_count / 2 || rebuild(map, slots_for(map->range_count));
}

void address_map_retune_if_needed(struct address_map *map)
{
    uint32_t count = map->range_count;
    if (map->crowded * CROWDED_FRACTION > count || count > 2 * map->tuned_for ||
        2 * count < map->tuned_for)
        rebuild(map, slots_for(count));
}

bool address_map_store(struct address_map *map, const struct address_facts *range, uint32_t *slot)
{
    return store_range(&map->guesses, range, &map->cursor, slot);
}
