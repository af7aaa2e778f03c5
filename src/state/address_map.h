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

/* Where the ranges that hold an address may be: behind the last that begins at or before it. Good
 * until the map changes. */
struct address_position {
    size_t chunk, entry;
};

/* A search in three steps, each of which fetches what the next needs into the processor's cache, so
 * that several searches can wait together; the last fetches the record. */
struct address_position address_map_find_chunk(const struct address_map *map, uint64_t address);
/* The same, sooner where it is a chunk of the last few of the `count` positions found before:
 * addresses that are looked up together are often neighbours. */
struct address_position address_map_find_chunk_near(const struct address_map *map, uint64_t address,
                                                    const struct address_position *found,
                                                    unsigned count);
void address_map_find_entry(const struct address_map *map, uint64_t address,
                            struct address_position *position);
void address_map_fetch(const struct address_map *map, struct address_position position);

/* The record whose range holds `address`, which is at that position, where it shows at a glance
 * that it is the only one; else NULL. */
void *address_map_only(const struct address_map *map, struct address_position position,
                       uint64_t address);

/* Calls `visit` for every record whose range holds `address`, which is at that position. */
void address_map_visit(const struct address_map *map, struct address_position position,
                       uint64_t address, void (*visit)(void *record, void *context), void *context);

/* Both at once. */
void address_map_find(const struct address_map *map, uint64_t address,
                      void (*visit)(void *record, void *context), void *context);

/* Calls `visit` for every range, in ascending order of where they begin; it must not change the
 * map.
 */
void address_map_each(const struct address_map *map,
                      void (*visit)(uint64_t begin, uint64_t end, void *record, void *context),
                      void *context);

void address_map_release(struct address_map *map);

#endif
