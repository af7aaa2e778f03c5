/* SPDX-License-Identifier: Apache-2.0 */
/* Random numbers for property tests. A run prints its seed; ASSAY_TEST_SEED repeats it. */
#ifndef STATE_RANDOM_H
#define STATE_RANDOM_H

#include <stdbool.h>
#include <stdint.h>

struct random {
    uint64_t state;
};

/* ASSAY_TEST_SEED, or `otherwise` if that is not set. */
uint64_t random_seed(uint64_t otherwise);

/* Seeds from ASSAY_TEST_SEED, or else from the clock, and prints the seed. */
struct random random_of(const char *test);

uint64_t random_next(struct random *random);

/* 0 to below - 1. */
uint32_t random_below(struct random *random, uint32_t below);

/* True once in `times`. */
bool random_one_in(struct random *random, uint32_t times);

#endif
