/* SPDX-License-Identifier: Apache-2.0 */
/* Memory with an alignment greater than malloc's. Windows frees it by a function of its own, so all
 * of it goes through these two functions. */
#ifndef ASSAY_PLATFORM_ALIGNED_H
#define ASSAY_PLATFORM_ALIGNED_H

#include <stdbool.h>
#include <stddef.h>
#include <stdlib.h>
#ifdef _WIN32
#include <malloc.h>
#else
#include <sys/mman.h>
#endif

#define HUGE_PAGE ((size_t)2 << 20)

/* `size` is a multiple of `alignment`. Returns NULL if memory runs out. Large memory asks for huge
 * pages: rays read large structures at random, and each read of small pages costs a look-up. */
static inline void *aligned_allocate(size_t alignment, size_t size)
{
#ifdef _WIN32
    return _aligned_malloc(size, alignment);
#else
    const bool is_large = size >= 2 * HUGE_PAGE;
    void *memory = aligned_alloc(is_large ? HUGE_PAGE : alignment, size);
#ifdef MADV_HUGEPAGE
    if (memory && is_large)
        (void)madvise(memory, size & ~(HUGE_PAGE - 1), MADV_HUGEPAGE);
#endif
    return memory;
#endif
}

/* `memory` is from aligned_allocate(), or NULL. */
static inline void aligned_free(void *memory)
{
#ifdef _WIN32
    _aligned_free(memory);
#else
    free(memory);
#endif
}

#endif
