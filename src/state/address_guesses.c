/* SPDX-License-Identifier: Apache-2.0 */
/* How guesses at places are made. */
#include "state/address_guesses.h"

#include <string.h>

enum { LARGEST_GRAIN = 40, SMALLEST_GRAIN = 8 };
/* Grains are good where no more than one in so many places has no room. */
enum { GOOD = 32 };

bool address_guesses_remember(const struct address_guesses *guesses, uint64_t address,
                              uint32_t slot)
{
    uint64_t grain = address >> guesses->grain_shift;
    uint32_t guess = ((uint32_t)grain * 0x9e3779b9u & ~guesses->slot_mask) | slot;
    _Atomic uint32_t *item = address_guesses_item(guesses, grain, slot % ADDRESS_WAYS);
    bool displaces = true;
    for (size_t way = 0; way < ADDRESS_WAYS; way++) {
        _Atomic uint32_t *other = address_guesses_item(guesses, grain, way);
        uint32_t old = atomic_load_explicit(other, memory_order_relaxed);
        if (old && !address_guesses_know(guesses, old, grain))
            continue;
        item = other;
        displaces = old && old != guess;
        break;
    }
    atomic_store_explicit(item, guess, memory_order_relaxed);
    return displaces;
}

/* Makes a guess of every place anew; returns whether no more than `limit` are lost. */
static bool remember_all(const struct address_guesses *guesses, uint32_t place_count,
                         uint32_t limit)
{
    uint32_t lost = 0;
    memset((void *)guesses->items, 0, ((size_t)guesses->item_mask + 1) * sizeof(*guesses->items));
    for (uint32_t slot = 1; slot < place_count && lost <= limit; slot++)
        if (guesses->places[slot].bytes_left)
            lost += address_guesses_remember(guesses, guesses->places[slot].address, slot);
    return lost <= limit;
}

/* The largest grains that tell places apart are the best: neighbours then share a cache line, and a
 * large buffer takes few guesses. Where places lie too unevenly for that, they are spread. */
void address_guesses_tune(struct address_guesses *guesses, uint32_t place_count)
{
    guesses->factor = (uint64_t)1 << 32;
    for (unsigned shift = LARGEST_GRAIN; shift >= SMALLEST_GRAIN; shift--) {
        guesses->grain_shift = shift;
        if (remember_all(guesses, place_count, place_count / GOOD))
            return;
    }
    guesses->factor = 0x9e3779b97f4a7c15u; /* 2^64 / phi */
    remember_all(guesses, place_count, UINT32_MAX);
}
