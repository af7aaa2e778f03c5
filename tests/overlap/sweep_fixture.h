/* SPDX-License-Identifier: Apache-2.0 */
/* What tests of the sweep make. */
#ifndef ASSAY_TESTS_OVERLAP_SWEEP_FIXTURE_H
#define ASSAY_TESTS_OVERLAP_SWEEP_FIXTURE_H

#include "src/check/overlap/sweep.h"

static inline struct used_range range_of(enum range_role role, uint32_t build, uintptr_t handle,
                                         uintptr_t memory, VkDeviceSize begin, VkDeviceSize end)
{
    return (struct used_range){.role = role,
                               .build = build,
                               .handle = (VkAccelerationStructureKHR)handle,
                               .span = {(VkDeviceMemory)memory, begin, end}};
}

/* A visitor that wants all; `user` is a number. */
static inline bool count_pair(void *user, const struct used_range *a, const struct used_range *b,
                              const struct memory_span *shared)
{
    ++*(uint32_t *)user;
    return true;
}

/* Adds a range that no variable holds. */
static inline void add_range(struct sweep *sweep, struct used_range range)
{
    sweep_add(sweep, &range);
}

/* How many pairs the sweep finds. */
static inline uint32_t count_pairs(struct sweep *sweep)
{
    uint32_t pairs = 0;
    sweep_equal_handles(sweep, count_pair, &pairs);
    sweep_shared_memory(sweep, count_pair, &pairs);
    return pairs;
}

#endif
