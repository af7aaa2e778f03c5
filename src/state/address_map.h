/* SPDX-License-Identifier: Apache-2.0 */
/* Which buffers cover a device address: an ordered set of their places, which may overlap (buffers
 * that alias memory share addresses). Not locked: its owner is.
 *
 * A place is what there is to say of its first address; what there is to say of another is that,
 * moved. It is one cache line and stays in its slot as long as it is in the map. For a look-up in a
 * large scene waits for memory more than for anything else: it reads one slot, where the address,
 * or one near it, was found before. Only where that is wrong, or where buffers overlap, the order
 * of places is searched: slots sorted by address in chunks, so that an insertion moves one chunk at
 * most. Each chunk knows how far it and all before it reach, so that a search walks back no further
 * than there is something to find.
 */
#ifndef ASSAY_STATE_ADDRESS_MAP_H
#define ASSAY_STATE_ADDRESS_MAP_H

#include <stdatomic.h>
#include <stddef.h>

#include "state/facts.h"

struct address_chunk;

/* Slots where addresses were found before, with other bits of the hash that leads to them. They are
 * no more than guesses, which readers make better, so a change of the map leaves them. */
struct address_guesses {
    _Atomic uint32_t *items;
    struct address_facts *places; /* by slot; 0 is nobody's, unused ones hold no address */
    uint32_t slot_mask;           /* the bits of an item that are the slot */
    unsigned shift;
};

struct address_map {
    struct address_guesses guesses;
    uint32_t place_count, place_capacity;
    uint32_t unused; /* the slot that was given back last; 0: none. It names the next as address */
    /* Arrays side by side, an item a chunk. */
    struct address_chunk **chunks;
    uint64_t *firsts;  /* where each begins, to be searched */
    uint64_t *reaches; /* the largest end in it and in all before it */
    size_t chunk_count, chunk_capacity;
};

/* Adds a copy. Of size (bytes_left) 0 and ranges that wrap are refused, as is a lack of memory. */
bool address_map_add(struct address_map *map, const struct address_facts *place);

/* Changes what is said of a buffer that keeps its address and size; nothing happens if it isn't
 * there. */
void address_map_update(struct address_map *map, const struct address_facts *place);

/* Removes the place of that address and buffer_id; nothing happens if there is none. */
void address_map_remove(struct address_map *map, const struct address_facts *place);

/* Those of a map, or, where that is NULL, of an empty one; good until the map changes. A copy of
 * them can stay in the processor's registers. */
struct address_guesses address_map_guesses(const struct address_map *map);

/* Addresses of a grain share a guess, which is one of a few that stand together. */
enum { ADDRESS_GRAIN_SHIFT = 8, ADDRESS_GUESSES = 4 };

static inline uint64_t address_hash(uint64_t address)
{
    return (address >> ADDRESS_GRAIN_SHIFT) * 0x9E3779B97F4A7C15u;
}

/* Whether a guess was made with a hash. */
static inline bool address_is_guess_of(struct address_guesses guesses, uint32_t guess,
                                       uint64_t hash)
{
    return (guess ^ (uint32_t)hash) <= guesses.slot_mask;
}

/* Where the address, or one near it, was found last: no more than a guess, but always a place. */
static inline const struct address_facts *address_guess(struct address_guesses guesses,
                                                        uint64_t address)
{
    uint64_t hash = address_hash(address);
    const _Atomic uint32_t *items = &guesses.items[hash >> guesses.shift];
    for (size_t i = 0; i < ADDRESS_GUESSES; i++) {
        uint32_t guess = atomic_load_explicit(&items[i], memory_order_relaxed);
        if (address_is_guess_of(guesses, guess, hash))
            return &guesses.places[guess & guesses.slot_mask];
    }
    return guesses.places;
}

static inline bool place_holds(const struct address_facts *place, uint64_t address)
{
    return address - place->address < place->bytes_left;
}

typedef void (*place_visitor)(const struct address_facts *place, void *context);

/* Calls `visit` for every place that holds `address`, and remembers where that was. */
void address_map_find(const struct address_map *map, uint64_t address, place_visitor visit,
                      void *context);

/* Calls `visit` for every place, in ascending order of addresses; it must not change the map. */
void address_map_each(const struct address_map *map, place_visitor visit, void *context);

void address_map_release(struct address_map *map);

#endif
