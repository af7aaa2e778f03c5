/* SPDX-License-Identifier: Apache-2.0 */
/* Slots of an address map. */
#include "src/state/resources/address_slots.h"

#include <stdlib.h>
#include <string.h>

#include "src/platform/aligned.h"

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
