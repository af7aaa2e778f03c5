/* SPDX-License-Identifier: Apache-2.0 */
/* The memory of an address map (address_map.h): chunks that order its ranges, and slots that hold
 * them. The functions are private to address_map.c. */
#ifndef ASSAY_STATE_RESOURCES_ADDRESS_SLOTS_H
#define ASSAY_STATE_RESOURCES_ADDRESS_SLOTS_H

#include <stdbool.h>
#include <stddef.h>

#include "src/state/resources/address_guesses.h"

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
