/* SPDX-License-Identifier: Apache-2.0 */
/* Maps device addresses to buffers: an ordered set of buffer ranges, which may overlap because
 * buffers that alias memory share addresses. Not locked: its owner is.
 *
 * A buffer range is stored as the facts about its first address; the facts about another address
 * follow from the offset. Each range is one cache line, in a slot. A look-up in a large scene
 * mostly waits for memory, so it reads one slot, which is guessed (address_slots.h). The ordered
 * set is searched only if the guess is wrong or if buffers overlap: slot numbers sorted by address,
 * in chunks, so that an insertion moves one chunk at most. Each chunk stores the largest end of its
 * ranges and of all ranges before it, which bounds the backward search. */
#ifndef ASSAY_STATE_RESOURCES_ADDRESS_MAP_H
#define ASSAY_STATE_RESOURCES_ADDRESS_MAP_H

#include <stddef.h>

#include "src/state/resources/address_slots.h"

/* Adds a copy of `range`. Returns false if the range is empty (bytes_left 0) or wraps around, or if
 * there is no memory. */
bool address_map_add(struct address_map *map, const struct address_facts *range);

/* Replaces the facts about a buffer whose address and size stay the same. Does nothing if the map
 * has no such range. */
void address_map_update(struct address_map *map, const struct address_facts *range);

/* Removes the range with that address and buffer_id. Does nothing if there is none. */
void address_map_remove(struct address_map *map, const struct address_facts *range);

/* Returns the guesses of a map, or those of an empty map if `map` is NULL. Valid until the map
 * changes. Returned by value so that the compiler can keep them in registers. */
struct address_guesses address_map_guesses(const struct address_map *map);

typedef void (*buffer_range_visitor)(const struct address_facts *range, void *context);

/* Calls `visit` for every range that contains `address`, and stores a guess for each. */
void address_map_find(const struct address_map *map, uint64_t address, buffer_range_visitor visit,
                      void *context);

/* Returns the last range that begins at or before `address`, or NULL. */
const struct address_facts *address_map_before(const struct address_map *map, uint64_t address);

/* Calls `visit` for every range in ascending order of addresses. `visit` must not change the
 * map. */
void address_map_each(const struct address_map *map, buffer_range_visitor visit, void *context);

/* Frees the memory of the map and makes it empty. */
void address_map_release(struct address_map *map);

#endif
