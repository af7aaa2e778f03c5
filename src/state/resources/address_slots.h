/* SPDX-License-Identifier: Apache-2.0 */
/* The slots of an address map, which hold its ranges, and when their guesses are tuned again.
 * Private to address_map.c. */
#ifndef ASSAY_STATE_RESOURCES_ADDRESS_SLOTS_H
#define ASSAY_STATE_RESOURCES_ADDRESS_SLOTS_H

#include "src/state/resources/address_map.h"

enum { CHUNK_RANGES = 16 };

/* Ranges in ascending order of addresses. */
struct address_chunk {
    uint64_t begins[CHUNK_RANGES];
    uint32_t slots[CHUNK_RANGES];
    size_t count; /* never 0 between calls */
};

/* Makes sure that one more range finds a free slot. Returns false if there is no memory. */
bool address_map_reserve_slot(struct address_map *map);

/* Copies a range into a free slot. Returns whether its guess overwrites no other. */
bool address_map_store(struct address_map *map, const struct address_facts *range, uint32_t *slot);

/* Tunes the guesses again if too many ranges have none, or if the number of ranges has doubled or
 * halved. Halving frees slots. Keeps the old guesses if there is no memory. */
void address_map_retune_if_needed(struct address_map *map);

#endif
