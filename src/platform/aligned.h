/* SPDX-License-Identifier: Apache-2.0 */
/* Memory with an alignment greater than malloc's. Windows frees it by a function of its own, so all
 * of it goes through these two functions. */
#ifndef ASSAY_PLATFORM_ALIGNED_H
#define ASSAY_PLATFORM_ALIGNED_H

#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#ifdef _WIN32
#include <malloc.h>
#else
#include <sys/mman.h>
#endif

/* `size` is a multiple of `alignment`. Returns NULL if memory runs out. Large memory asks for huge
 * pages: rays read large structures at random, and each read of small pages costs a look-up. */
static inline void *aligned_allocate(size_t alignment, size_t size)
{
#ifdef _WIN32
    return _aligned_malloc(size, alignment);
#else
    void *memory = aligned_alloc(alignment, size);
#ifdef MADV_HUGEPAGE
    const uintptr_t page = (uintptr_t)2 << 20;
    const uintptr_t begin = ((uintptr_t)memory + page - 1) & ~(page - 1),
                    end = ((uintptr_t)memory + size) & ~(page - 1);
    if (memory && begin < end)
        (void)madvise((void *)begin, end - begin, MADV_HUGEPAGE);
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
