/* SPDX-License-Identifier: Apache-2.0 */
/* Guesses at which place an address is in, which make most searches of an address map needless. */
#ifndef ASSAY_STATE_RESOURCES_ADDRESS_GUESSES_H
#define ASSAY_STATE_RESOURCES_ADDRESS_GUESSES_H

#include <stdatomic.h>
#include <stddef.h>

#include "src/state/facts.h"

/* All addresses of a grain share a guess, so that a large buffer takes few of them.
 *
 * The first guess is the slot that a grain leads to: a place is there if it begins in that grain,
 * and if the slot was free. The second is an item, the number of a slot where the grain was found
 * before: in one of a set of four, the first that was free, with some bits of what names the grain.
 * They are no more than guesses, which readers make better. */
struct address_guesses {
    _Atomic uint32_t *items;
    struct address_facts *ranges; /* by slot; 0 is nobody's, unused ones hold no address */
    uint32_t mask;                /* the number of slots, and of items, less 1 */
    unsigned grain_shift;         /* from addresses to grains, */
    uint64_t factor;              /* and on to slots and items */
};

enum { ADDRESS_WAYS = 4 };

/* Where a grain leads to. */
static inline size_t address_guesses_home(const struct address_guesses *guesses, uint64_t grain)
{
    return (grain * guesses->factor >> 32) & guesses->mask;
}

/* Where a guess is sought first (way 0), and then. */
static inline _Atomic uint32_t *address_guesses_item(const struct address_guesses *guesses,
                                                     uint64_t grain, size_t way)
{
    return &guesses->items[address_guesses_home(guesses, grain) ^ way];
}

/* Whether a guess was made for a grain. */
static inline bool address_guesses_know(const struct address_guesses *guesses, uint32_t guess,
                                        uint64_t grain)
{
    return (guess ^ (uint32_t)grain * 0x9e3779b9u) <= guesses->mask;
}

static inline bool buffer_range_contains(const struct address_facts *range, uint64_t address)
{
    return address - range->address < range->bytes_left;
}

/* The first guess; no more than that, but always a place. */
static inline const struct address_facts *
address_guesses_first(const struct address_guesses *guesses, uint64_t address)
{
    return &guesses->ranges[address_guesses_home(guesses, address >> guesses->grain_shift)];
}

/* The second, likewise. */
const struct address_facts *address_guesses_second(const struct address_guesses *guesses,
                                                   uint64_t address);

/* Both, after the first. */
static inline const struct address_facts *
address_guesses_go_on(const struct address_guesses *guesses, const struct address_facts *first,
                      uint64_t address)
{
    return buffer_range_contains(first, address) ? first : address_guesses_second(guesses, address);
}

static inline const struct address_facts *
address_guesses_find(const struct address_guesses *guesses, uint64_t address)
{
    return address_guesses_go_on(guesses, address_guesses_first(guesses, address), address);
}

/* Makes a guess, which takes the place of an older one of the same grain, or of none. Returns in
 * which item of its set it is; ADDRESS_WAYS where a guess at another place is lost for it. */
unsigned address_guesses_remember(const struct address_guesses *guesses, uint64_t address,
                                  uint32_t slot);

/* Chooses grains, and where they lead to, for places that begin at so many addresses, fewer than
 * there are slots; there is no guess of any then. */
void address_guesses_tune(struct address_guesses *guesses, const uint64_t *addresses, size_t count);

#endif
