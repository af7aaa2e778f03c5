/* SPDX-License-Identifier: Apache-2.0 */
/* Guesses the buffer range that contains a device address, so that most look-ups need no search of
 * the address map. Not locked: the address map's owner is. */
#ifndef ASSAY_STATE_RESOURCES_ADDRESS_SLOTS_H
#define ASSAY_STATE_RESOURCES_ADDRESS_SLOTS_H

#include <stdatomic.h>
#include <stdbool.h>
#include <stddef.h>

#include "src/state/facts.h"

/* The address space is split into grains of 2^grain_shift bytes. All addresses of a grain share one
 * guess, so a large buffer needs few guesses.
 *
 * The first guess is the slot that the grain hashes to. It is right if a buffer range begins in
 * that grain and the slot was free. The second guess is an item: the number of the slot where the
 * grain was found before, with some bits of the grain's number as a tag. An item is in one of four
 * ways, the first that was free. Guesses may be wrong; readers improve them as they search. */
struct address_guesses {
    _Atomic uint32_t *items;
    struct address_facts *ranges; /* by slot; slot 0 and free slots contain no address */
    uint32_t mask;                /* number of slots minus 1; there are as many items */
    unsigned grain_shift;         /* grain = address >> grain_shift */
    uint64_t factor;              /* hash multiplier: from grains to slots and items */
};

enum { ADDRESS_WAYS = 4 };

/* Returns the slot that a grain hashes to. */
static inline size_t address_guesses_home(const struct address_guesses *guesses, uint64_t grain)
{
    return (grain * guesses->factor >> 32) & guesses->mask;
}

static inline bool buffer_range_contains(const struct address_facts *range, uint64_t address)
{
    return address - range->address < range->bytes_left;
}

/* Returns the first guess: never NULL, but possibly a range without the address. */
static inline const struct address_facts *
address_guesses_first(const struct address_guesses *guesses, uint64_t address)
{
    return &guesses->ranges[address_guesses_home(guesses, address >> guesses->grain_shift)];
}

/* Returns the second guess: never NULL, but possibly a range without the address. */
const struct address_facts *address_guesses_second(const struct address_guesses *guesses,
                                                   uint64_t address);

/* Returns the first guess if that contains the address, else the second guess. */
static inline const struct address_facts *
address_guesses_find_from(const struct address_guesses *guesses, const struct address_facts *first,
                          uint64_t address)
{
    return buffer_range_contains(first, address) ? first : address_guesses_second(guesses, address);
}

static inline const struct address_facts *
address_guesses_find(const struct address_guesses *guesses, uint64_t address)
{
    return address_guesses_find_from(guesses, address_guesses_first(guesses, address), address);
}

/* Stores a guess. Replaces an older guess for the same grain if there is one. Returns the way it is
 * stored in, or ADDRESS_WAYS if the guess for another range was overwritten. */
unsigned address_guesses_remember(const struct address_guesses *guesses, uint64_t address,
                                  uint32_t slot);

/* ---- The memory of an address map (address_map.h): chunks that order its ranges, and slots that
 * hold them. The functions are private to address_map.c. */

enum { CHUNK_RANGES = 16 };

/* Ranges in ascending order of addresses. */
struct address_chunk {
    uint64_t begins[CHUNK_RANGES];
    uint32_t slots[CHUNK_RANGES];
    size_t count; /* never 0 between calls */
};

struct address_map {
    struct address_guesses guesses;
    uint32_t tuned_for; /* number of ranges that the guesses were tuned for */
    uint32_t crowded;   /* guesses overwritten since then */
    uint32_t range_count, slot_count;
    size_t cursor; /* the last slot that take_slot found by linear search */
    /* Parallel arrays, one item for each chunk. */
    struct address_chunk **chunks;
    uint64_t *firsts;  /* address of the first range of each chunk, for binary search */
    uint64_t *reaches; /* largest end in each chunk and all chunks before it */
    size_t chunk_count, chunk_capacity;
};

/* Makes sure that one more range finds a free slot. Returns false if there is no memory. */
bool address_map_reserve_slot(struct address_map *map);

/* Copies a range into a free slot. Returns whether its guess overwrites no other. */
bool address_map_store(struct address_map *map, const struct address_facts *range, uint32_t *slot);

/* Tunes the guesses again if too many ranges have none, or if the number of ranges has doubled or
 * halved. Halving frees slots. Keeps the old guesses if there is no memory. */
void address_map_retune_if_needed(struct address_map *map);

#endif
