/* SPDX-License-Identifier: Apache-2.0 */
/* Scratch memory, and the list of scratch memory in use. */
#include "src/cpu/scratch.h"

#include <stdbool.h>
#include <stdlib.h>

#include "src/bvh/bvh.h"
#include "src/platform/aligned.h"
#include "src/snapshots/memory.h"

_Static_assert(CPU_SCRATCH_SLACK == BUILDER_ALIGNMENT - 1, "room to align in");

void cpu_scratch_claims_init(struct cpu_scratch_claims *claims)
{
    claims->first = NULL;
    pthread_mutex_init(&claims->lock, NULL);
}

void cpu_scratch_claims_release(struct cpu_scratch_claims *claims)
{
    pthread_mutex_destroy(&claims->lock);
}

static bool overlap(const struct cpu_scratch *a, const struct cpu_scratch *b)
{
    uintptr_t a_begin = (uintptr_t)a->bytes, b_begin = (uintptr_t)b->bytes;
    return a_begin < b_begin + b->size && b_begin < a_begin + a->size;
}

static bool claim(struct cpu_scratch_claims *claims, struct cpu_scratch *scratch)
{
    pthread_mutex_lock(&claims->lock);
    const struct cpu_scratch *other = claims->first;
    while (other && !overlap(other, scratch))
        other = other->next;
    if (!other) {
        scratch->next = claims->first;
        claims->first = scratch;
    }
    pthread_mutex_unlock(&claims->lock);
    return !other;
}

static void unclaim(struct cpu_scratch_claims *claims, struct cpu_scratch *scratch)
{
    pthread_mutex_lock(&claims->lock);
    struct cpu_scratch **link = &claims->first;
    while (*link && *link != scratch)
        link = &(*link)->next;
    if (*link)
        *link = scratch->next;
    pthread_mutex_unlock(&claims->lock);
}

VkResult cpu_scratch_take(struct cpu_scratch_claims *claims, void *given, uint64_t size,
                          struct cpu_scratch *scratch)
{
    uintptr_t misaligned = (uintptr_t)given % BUILDER_ALIGNMENT;
    uint64_t skipped = misaligned ? BUILDER_ALIGNMENT - misaligned : 0;
    *scratch = (struct cpu_scratch){.size = size, .claims = claims};
    if (given && size <= UINT64_MAX - skipped) {
        scratch->bytes = (char *)given + skipped;
        if (claim(claims, scratch)) {
            if (memory_is_writable(scratch->bytes, size))
                return VK_SUCCESS;
            unclaim(claims, scratch);
        }
    }
    uint64_t rounded = (size + BUILDER_ALIGNMENT - 1) & ~(uint64_t)(BUILDER_ALIGNMENT - 1);
    scratch->owned = aligned_allocate(BUILDER_ALIGNMENT, rounded ? rounded : BUILDER_ALIGNMENT);
    scratch->bytes = scratch->owned;
    return scratch->owned ? VK_SUCCESS : VK_ERROR_OUT_OF_HOST_MEMORY;
}

void cpu_scratch_return(struct cpu_scratch *scratch)
{
    if (!scratch->owned)
        unclaim(scratch->claims, scratch);
    aligned_free(scratch->owned);
}
