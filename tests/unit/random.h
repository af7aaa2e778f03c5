/* SPDX-License-Identifier: Apache-2.0 */
/* Random numbers for property tests: SplitMix64 (Steele, Lea, Flood 2014). A run prints its seed;
 * ASSAY_TEST_SEED repeats it. */
#ifndef ASSAY_TESTS_UNIT_RANDOM_H
#define ASSAY_TESTS_UNIT_RANDOM_H

#include <inttypes.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

struct random {
    uint64_t state;
};

/* ASSAY_TEST_SEED, or `otherwise` if that is not set. */
static inline uint64_t random_seed(uint64_t otherwise)
{
    const char *given = getenv("ASSAY_TEST_SEED");
    return given ? strtoull(given, NULL, 0) : otherwise;
}

/* Seeds from ASSAY_TEST_SEED, or else from the clock, and prints the seed. */
static inline struct random random_of(const char *test)
{
    struct timespec now;
    clock_gettime(CLOCK_REALTIME, &now);
    uint64_t seed = random_seed((uint64_t)now.tv_sec * 1000000000u + (uint64_t)now.tv_nsec);
    printf("%s: ASSAY_TEST_SEED=%" PRIu64 "\n", test, seed);
    fflush(stdout);
    return (struct random){seed};
}

static inline uint64_t random_next(struct random *random)
{
    uint64_t z = random->state += 0x9e3779b97f4a7c15u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
}

/* 0 to below - 1. */
static inline uint32_t random_below(struct random *random, uint32_t below)
{
    return (uint32_t)((random_next(random) >> 32) * below >> 32);
}

/* True once in `times`. */
static inline bool random_one_in(struct random *random, uint32_t times)
{
    return random_below(random, times) == 0;
}

#endif
