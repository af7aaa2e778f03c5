/* SPDX-License-Identifier: Apache-2.0 */
/* Copies of what an application passes at misaligned addresses.
 *
 * Vulkan wants pointers aligned as the processor requires, and most processors require nothing, but
 * C wants a structure aligned as its type. The copies of one call are released together. Not
 * locked. */
#ifndef ASSAY_STATE_ALIGNED_COPIES_H
#define ASSAY_STATE_ALIGNED_COPIES_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct aligned_copies {
    struct aligned_copy *first; /* NULL: none. All bits 0 is empty */
};

__attribute__((cold)) void aligned_copies_release(struct aligned_copies *copies);

static inline bool is_aligned(const void *pointer, size_t alignment)
{
    return ((uintptr_t)pointer & (alignment - 1)) == 0;
}

/* A copy of `size` readable bytes, aligned for every type. Returns NULL without memory. */
__attribute__((cold)) void *aligned_copies_take(struct aligned_copies *copies, const void *from,
                                                size_t size);

#endif
