/* SPDX-License-Identifier: Apache-2.0 */
/* Guesses at which place an address is in, which make most searches of an address map needless. */
#ifndef ASSAY_STATE_ADDRESS_GUESSES_H
#define ASSAY_STATE_ADDRESS_GUESSES_H

#include <stdatomic.h>
#include <stddef.h>

#include "state/facts.h"

/* Slots where places begin and where addresses were found before. All addresses of a grain share a
 * guess, so that a large buffer takes few of them; it stands in one of the four items of a set, the
 * first that was free, with some bits of what names the grain. They are no more than guesses, which
 * readers make better.
 */
struct address_guesses {
    _Atomic uint32_t *items;
    struct address_facts *places; /* by slot; 0 is nobody's, unused ones hold no address */
    uint32_t slot_mask;           /* the bits of an item that are the slot */
    uint32_t item_mask;           /* the number of items less 1 */
    uint64_t factor;              /* takes a grain to its item */
    unsigned grain_shift;         /* from addresses to grains */
};

enum { ADDRESS_WAYS = 4 };

/* Where a guess is sought first (way 0), and then. */
static inline _Atomic uint32_t *address_guesses_item(const struct address_guesses *guesses,
                                                     uint64_t grain, size_t way)
{
    return &guesses->items[((grain * guesses->factor >> 32) & guesses->item_mask) ^ way];
}

/* Whether a guess was made for a grain. */
static inline bool address_guesses_know(const struct address_guesses *guesses, uint32_t guess,
                                        uint64_t grain)
{
    return (guess ^ (uint32_t)grain * 0x9e3779b9u) <= guesses->slot_mask;
}

/* The guess for a grain, or any, where `first`, the first of its items, is of another. */
uint32_t address_guesses_search(const struct address_guesses *guesses, uint64_t grain,
                                uint32_t first);

/* Where the address, or one near it, was found last: no more than a guess, but always a place. */
static inline const struct address_facts *
address_guesses_find(const struct address_guesses *guesses, uint64_t address)
{
    uint64_t grain = address >> guesses->grain_shift;
    uint32_t guess =
        atomic_load_explicit(address_guesses_item(guesses, grain, 0), memory_order_relaxed);
    if (__builtin_expect(!address_guesses_know(guesses, guess, grain), false))
        guess = address_guesses_search(guesses, grain, guess);
    return &guesses->places[guess & guesses->slot_mask];
}

static inline bool place_holds(const struct address_facts *place, uint64_t address)
{
    return address - place->address < place->bytes_left;
}

/* Makes a guess, which takes the place of an older one of the same grain, or of none. Returns in
 * which item of its set it is; ADDRESS_WAYS where a guess at another place is lost for it. */
unsigned address_guesses_remember(const struct address_guesses *guesses, uint64_t address,
                                  uint32_t slot);

/* Chooses grains and items for the places in slots below `place_count`, and makes a guess of each:
 * to begin with, and where grains have become too coarse, or items too crowded, for what came
 * since. */
void address_guesses_tune(struct address_guesses *guesses, uint32_t place_count);

#endif
