/* SPDX-License-Identifier: Apache-2.0 */
/* Which records cover a device address: an ordered set of ranges that may overlap (buffers that
 * alias memory share addresses). Not locked: its owner is.
 *
 * Ranges are kept sorted by first byte in chunks, so that an insertion moves one chunk at most.
 * Each entry and each chunk knows how far it and all before it reach, so that a look-up walks back
 * no further than there is something to find. */
#ifndef ASSAY_STATE_ADDRESS_MAP_H
#define ASSAY_STATE_ADDRESS_MAP_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct address_chunk;

struct address_map {
    struct address_chunk **chunks;
    uint64_t *firsts; /* where each chunk begins, side by side, to be searched */
    size_t chunk_count, chunk_capacity;
};

/* Adds [begin, begin + size). Size 0 and ranges that wrap are refused, as is a lack of memory. */
bool address_map_add(struct address_map *map, uint64_t begin, uint64_t size, void *record);

/* Removes the range of that record which begins there; nothing happens if there is none. */
void address_map_remove(struct address_map *map, uint64_t begin, const void *record);

/* Calls `visit` for every record whose range holds `address`. */
void address_map_find(const struct address_map *map, uint64_t address,
                      void (*visit)(void *record, void *context), void *context);

void address_map_release(struct address_map *map);

#endif
