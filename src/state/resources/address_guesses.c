/* SPDX-License-Identifier: Apache-2.0 */
/* Guesses the buffer range that contains a device address: second guesses and tuning. */
#include "src/state/resources/address_guesses.h"

#include <string.h>

enum { LARGEST_GRAIN = 40, SMALLEST_GRAIN = 8, FACTORS = 16 };

const struct address_facts *address_guesses_second(const struct address_guesses *guesses,
                                                   uint64_t address)
{
    uint64_t grain = address >> guesses->grain_shift;
    uint32_t guess = 0;
    for (size_t way = 0; way < ADDRESS_WAYS; way++) {
        guess =
            atomic_load_explicit(address_guesses_item(guesses, grain, way), memory_order_relaxed);
        if (address_guesses_matches(guesses, guess, grain))
            break;
    }
    return &guesses->ranges[guess & guesses->mask];
}

unsigned address_guesses_remember(const struct address_guesses *guesses, uint64_t address,
                                  uint32_t slot)
{
    uint64_t grain = address >> guesses->grain_shift;
    uint32_t guess = ((uint32_t)grain * 0x9e3779b9u & ~guesses->mask) | slot;
    for (unsigned way = 0; way < ADDRESS_WAYS; way++) {
        _Atomic uint32_t *item = address_guesses_item(guesses, grain, way);
        uint32_t old = atomic_load_explicit(item, memory_order_relaxed);
        if (old && !address_guesses_matches(guesses, old, grain))
            continue;
        atomic_store_explicit(item, guess, memory_order_relaxed);
        return old && old != guess ? ADDRESS_WAYS : way;
    }
    atomic_store_explicit(address_guesses_item(guesses, grain, slot % ADDRESS_WAYS), guess,
                          memory_order_relaxed);
    return ADDRESS_WAYS;
}

static void forget_all(const struct address_guesses *guesses)
{
    memset((void *)guesses->items, 0, ((size_t)guesses->mask + 1) * sizeof(*guesses->items));
}

/* The best parameters found so far. */
struct choice {
    const uint64_t *addresses;
    size_t count;
    unsigned grain_shift;
    uint64_t factor;
    uint64_t cost; /* items that are tried and don't match before every range is found */
};

static void try_parameters(struct address_guesses *guesses, unsigned grain_shift, uint64_t factor,
                           struct choice *best)
{
    uint64_t cost = 0;
    guesses->grain_shift = grain_shift;
    guesses->factor = factor;
    forget_all(guesses);
    for (size_t i = 0; i < best->count && cost < best->cost; i++)
        cost += address_guesses_remember(guesses, best->addresses[i], (uint32_t)i + 1);
    if (cost >= best->cost)
        return;
    best->cost = cost;
    best->grain_shift = grain_shift;
    best->factor = factor;
}

/* Prefers the largest grain that separates the ranges, with slots in address order: neighbours then
 * share a cache line, and a large buffer needs few guesses. If the ranges are too unevenly spaced
 * for that, uses the smallest grain and the multiplier that spreads these ranges best. */
void address_guesses_tune(struct address_guesses *guesses, const uint64_t *addresses, size_t count)
{
    const uint64_t in_order = (uint64_t)1 << 32, good = count / 16;
    struct choice best = {.addresses = addresses, .count = count, .cost = UINT64_MAX};
    for (unsigned shift = LARGEST_GRAIN; shift >= SMALLEST_GRAIN && best.cost > good; shift--)
        try_parameters(guesses, shift, in_order, &best);
    uint64_t factor = 0x9e3779b97f4a7c15u; /* 2^64 / phi, and its powers */
    for (unsigned i = 0; i < FACTORS && best.cost > good; i++, factor *= 0x9e3779b97f4a7c15u)
        try_parameters(guesses, SMALLEST_GRAIN, factor, &best);
    guesses->grain_shift = best.grain_shift;
    guesses->factor = best.factor;
    forget_all(guesses);
}
