/* SPDX-License-Identifier: Apache-2.0 */
/* Which buffers cover a device address: an ordered set of their places, which may overlap (buffers
 * that alias memory share addresses). Not locked: its owner is.
 *
 * A place is what there is to say of its first address; what there is to say of another is that,
 * moved. It is one cache line, in a slot. For a look-up in a large scene waits for memory more than
 * for anything else: it reads one slot, which is guessed (address_guesses.h). Only where that is
 * wrong, or where buffers overlap, the order of places is searched: slots sorted by address in
 * chunks, so that an insertion moves one chunk at most. Each chunk knows how far it and all before
 * it reach, so that a search walks back no further than there is something to find.
 */
#ifndef ASSAY_STATE_RESOURCES_ADDRESS_MAP_H
#define ASSAY_STATE_RESOURCES_ADDRESS_MAP_H

#include <stddef.h>

#include "src/state/resources/address_guesses.h"

struct address_chunk;

struct address_map {
    struct address_guesses guesses;
    uint32_t chosen_for; /* so many places */
    uint32_t crowded;    /* places for which there was no room among them since */
    uint32_t range_count, slot_count;
    size_t cursor; /* the last slot that was taken for its being free */
    /* Arrays side by side, an item a chunk. */
    struct address_chunk **chunks;
    uint64_t *firsts;  /* where each begins, to be searched */
    uint64_t *reaches; /* the largest end in it and in all before it */
    size_t chunk_count, chunk_capacity;
};

/* Adds a copy. Of size (bytes_left) 0 and ranges that wrap are refused, as is a lack of memory. */
bool address_map_add(struct address_map *map, const struct address_facts *range);

/* Changes what is said of a buffer that keeps its address and size; nothing happens if it isn't
 * there. */
void address_map_update(struct address_map *map, const struct address_facts *range);

/* Removes the place of that address and buffer_id; nothing happens if there is none. */
void address_map_remove(struct address_map *map, const struct address_facts *range);

/* Those of a map, or, where that is NULL, of an empty one; good until the map changes. A copy of
 * them can stay in the processor's registers. */
struct address_guesses address_map_guesses(const struct address_map *map);

typedef void (*buffer_range_visitor)(const struct address_facts *range, void *context);

/* Calls `visit` for every place that holds `address`, and remembers where that was. */
void address_map_find(const struct address_map *map, uint64_t address, buffer_range_visitor visit,
                      void *context);

/* Calls `visit` for every place, in ascending order of addresses; it must not change the map. */
void address_map_each(const struct address_map *map, buffer_range_visitor visit, void *context);

void address_map_release(struct address_map *map);

#endif
