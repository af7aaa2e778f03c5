/* SPDX-License-Identifier: Apache-2.0 */
/* Guesses the buffer range that contains a device address, so that most look-ups need no search of
 * the address map. Not locked: the address map's owner is. */
#ifndef ASSAY_STATE_RESOURCES_ADDRESS_GUESSES_H
#define ASSAY_STATE_RESOURCES_ADDRESS_GUESSES_H

#include <stdatomic.h>
#include <stddef.h>

#include "src/state/facts.h"

/* The address space is split into grains of 2^grain_shift bytes. All addresses of a grain share one
 * guess, so a large buffer needs few guesses.
 *
 * The first guess is the slot that the grain hashes to. It is right if a buffer range begins in
 * that grain and the slot was free. The second guess is an item: the number of the slot where the
 * grain was found before, with some bits of the grain's number as a tag. An item is in one of four
 * ways, the first that was free. Guesses may be wrong; readers improve them as they search. */
struct address_guesses {
    _Atomic uint32_t *items;
    struct address_facts *ranges; /* by slot; slot 0 and free slots contain no address */
    uint32_t mask;                /* number of slots minus 1; there are as many items */
    unsigned grain_shift;         /* grain = address >> grain_shift */
    uint64_t factor;              /* hash multiplier: from grains to slots and items */
};

enum { ADDRESS_WAYS = 4 };

/* Returns the slot that a grain hashes to. */
static inline size_t address_guesses_home(const struct address_guesses *guesses, uint64_t grain)
{
    return (grain * guesses->factor >> 32) & guesses->mask;
}

/* Returns the item of a grain in way `way`; way 0 is tried first. */
static inline _Atomic uint32_t *address_guesses_item(const struct address_guesses *guesses,
                                                     uint64_t grain, size_t way)
{
    return &guesses->items[address_guesses_home(guesses, grain) ^ way];
}

/* Returns whether the tag of a guess matches the grain. */
static inline bool address_guesses_matches(const struct address_guesses *guesses, uint32_t guess,
                                           uint64_t grain)
{
    return (guess ^ (uint32_t)grain * 0x9e3779b9u) <= guesses->mask;
}

static inline bool buffer_range_contains(const struct address_facts *range, uint64_t address)
{
    return address - range->address < range->bytes_left;
}

/* Returns the first guess: never NULL, but possibly a range without the address. */
static inline const struct address_facts *
address_guesses_first(const struct address_guesses *guesses, uint64_t address)
{
    return &guesses->ranges[address_guesses_home(guesses, address >> guesses->grain_shift)];
}

/* Returns the second guess: never NULL, but possibly a range without the address. */
const struct address_facts *address_guesses_second(const struct address_guesses *guesses,
                                                   uint64_t address);

/* Returns the first guess if that contains the address, else the second guess. */
static inline const struct address_facts *
address_guesses_find_from(const struct address_guesses *guesses, const struct address_facts *first,
                          uint64_t address)
{
    return buffer_range_contains(first, address) ? first : address_guesses_second(guesses, address);
}

static inline const struct address_facts *
address_guesses_find(const struct address_guesses *guesses, uint64_t address)
{
    return address_guesses_find_from(guesses, address_guesses_first(guesses, address), address);
}

/* Stores a guess. Replaces an older guess for the same grain if there is one. Returns the way it is
 * stored in, or ADDRESS_WAYS if the guess for another range was overwritten. */
unsigned address_guesses_remember(const struct address_guesses *guesses, uint64_t address,
                                  uint32_t slot);

/* Chooses the grain size and hash multiplier for `count` ranges that begin at `addresses`. `count`
 * is less than the number of slots. Clears all items. */
void address_guesses_tune(struct address_guesses *guesses, const uint64_t *addresses, size_t count);

#endif
