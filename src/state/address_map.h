/* SPDX-License-Identifier: Apache-2.0 */
/* Which buffers cover a device address: an ordered set of their places, which may overlap (buffers
 * that alias memory share addresses). Not locked: its owner is.
 *
 * Places are kept sorted by address in chunks, so that an insertion moves one chunk at most. A
 * look-up in a large scene waits for memory more than for anything else: it reads one cache line of
 * a chunk, which holds all its addresses, and the place itself, another. Each chunk knows how far
 * it and all before it reach, so that a look-up walks back no further than there is something to
 * find.
 */
#ifndef ASSAY_STATE_ADDRESS_MAP_H
#define ASSAY_STATE_ADDRESS_MAP_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <vulkan/vulkan_core.h>

/* What look-ups say of a buffer; its record keeps the original, see resources_refresh. */
struct buffer_place {
    VkDeviceAddress address; /* 0: not retrieved */
    VkDeviceSize size;
    VkBufferUsageFlags2 usage;
    VkBuffer handle;
    uint64_t id;           /* of this buffer alone */
    VkDeviceMemory memory; /* null: not bound, sparse, or of differing instances */
    VkDeviceSize memory_offset;
    unsigned char status; /* enum address_status of the addresses in it */
    unsigned char backed; /* enum tristate; not of a sparse buffer */
    bool is_sparse;
};

struct address_chunk;

/* Arrays side by side, an item a chunk. */
struct address_map {
    struct address_chunk **chunks;
    uint64_t *firsts;  /* where each begins, to be searched */
    uint64_t *reaches; /* the largest end in it and in all before it */
    size_t chunk_count, chunk_capacity;
    /* Where addresses were found before, by a hash of them; a power of two, several a chunk. They
     * are no more than guesses, which readers make better, so a change of the map leaves them. */
    _Atomic uint32_t *guesses;
    unsigned guess_bits;
};

/* Adds a copy. Size 0 and ranges that wrap are refused, as is a lack of memory. */
bool address_map_add(struct address_map *map, const struct buffer_place *place);

/* Changes what is said of a buffer that keeps its address and size; nothing happens if it isn't
 * there. */
void address_map_update(struct address_map *map, const struct buffer_place *place);

/* Removes the place of that address and id; nothing happens if there is none. */
void address_map_remove(struct address_map *map, const struct buffer_place *place);

/* Where the places that hold an address may be: behind the last that begins at or before it. Good
 * until the map changes. */
struct address_position {
    size_t chunk, entry;
};

/* A search in two steps, each of which fetches what comes next into the processor's cache, so that
 * several searches can wait together. */
struct address_position address_map_find_chunk(const struct address_map *map, uint64_t address);
void address_map_find_entry(const struct address_map *map, uint64_t address,
                            struct address_position *position);

/* The place that holds `address`, which is at that position, where it shows at a glance that it is
 * the only one; else NULL. Good until the map changes. */
const struct buffer_place *address_map_only(const struct address_map *map,
                                            struct address_position position, uint64_t address);

typedef void (*place_visitor)(const struct buffer_place *place, void *context);

/* Calls `visit` for every place that holds `address`, which is at that position. */
void address_map_visit(const struct address_map *map, struct address_position position,
                       uint64_t address, place_visitor visit, void *context);

/* Both at once. */
void address_map_find(const struct address_map *map, uint64_t address, place_visitor visit,
                      void *context);

/* Calls `visit` for every place, in ascending order of addresses; it must not change the map. */
void address_map_each(const struct address_map *map, place_visitor visit, void *context);

void address_map_release(struct address_map *map);

#endif
