/* SPDX-License-Identifier: Apache-2.0 */
/* How guesses at places are made. */
#include "state/address_guesses.h"

#include <string.h>

enum { LARGEST_GRAIN = 40, SMALLEST_GRAIN = 8, FACTORS = 16 };

uint32_t address_guesses_search(const struct address_guesses *guesses, uint64_t grain,
                                uint32_t first)
{
    for (size_t way = 1; way < ADDRESS_WAYS; way++) {
        uint32_t guess =
            atomic_load_explicit(address_guesses_item(guesses, grain, way), memory_order_relaxed);
        if (address_guesses_know(guesses, guess, grain))
            return guess;
    }
    return first;
}

unsigned address_guesses_remember(const struct address_guesses *guesses, uint64_t address,
                                  uint32_t slot)
{
    uint64_t grain = address >> guesses->grain_shift;
    uint32_t guess = ((uint32_t)grain * 0x9e3779b9u & ~guesses->slot_mask) | slot;
    for (unsigned way = 0; way < ADDRESS_WAYS; way++) {
        _Atomic uint32_t *item = address_guesses_item(guesses, grain, way);
        uint32_t old = atomic_load_explicit(item, memory_order_relaxed);
        if (old && !address_guesses_know(guesses, old, grain))
            continue;
        atomic_store_explicit(item, guess, memory_order_relaxed);
        return old && old != guess ? ADDRESS_WAYS : way;
    }
    atomic_store_explicit(address_guesses_item(guesses, grain, slot % ADDRESS_WAYS), guess,
                          memory_order_relaxed);
    return ADDRESS_WAYS;
}

/* Makes a guess of every place anew. Returns how many items are looked at in vain until all are
 * found, or more than `limit`. */
static uint64_t remember_all(const struct address_guesses *guesses, uint32_t place_count,
                             uint64_t limit)
{
    uint64_t cost = 0;
    memset((void *)guesses->items, 0, ((size_t)guesses->item_mask + 1) * sizeof(*guesses->items));
    for (uint32_t slot = 1; slot < place_count && cost <= limit; slot++)
        if (guesses->places[slot].bytes_left)
            cost += address_guesses_remember(guesses, guesses->places[slot].address, slot);
    return cost;
}

/* Of what was tried so far. */
struct choice {
    unsigned grain_shift;
    uint64_t factor, cost;
};

static void attempt(struct address_guesses *guesses, uint32_t place_count, unsigned grain_shift,
                    uint64_t factor, struct choice *best)
{
    guesses->grain_shift = grain_shift;
    guesses->factor = factor;
    uint64_t cost = remember_all(guesses, place_count, best->cost);
    if (cost < best->cost)
        *best = (struct choice){grain_shift, factor, cost};
}

/* The largest grains that tell places apart, in their order, are the best: neighbours then share a
 * cache line, and a large buffer takes few guesses. Where places lie too unevenly for that, small
 * ones are spread, by a factor that happens to be good for how they lie. */
void address_guesses_tune(struct address_guesses *guesses, uint32_t place_count)
{
    const uint64_t in_order = (uint64_t)1 << 32, good = place_count / 16;
    struct choice best = {.cost = UINT64_MAX};
    for (unsigned shift = LARGEST_GRAIN; shift >= SMALLEST_GRAIN && best.cost > good; shift--)
        attempt(guesses, place_count, shift, in_order, &best);
    uint64_t factor = 0x9e3779b97f4a7c15u; /* 2^64 / phi, and its powers */
    for (unsigned i = 0; i < FACTORS && best.cost > good; i++, factor *= 0x9e3779b97f4a7c15u)
        attempt(guesses, place_count, SMALLEST_GRAIN, factor, &best);
    guesses->grain_shift = best.grain_shift;
    guesses->factor = best.factor;
    remember_all(guesses, place_count, UINT64_MAX);
}
