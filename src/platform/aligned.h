/* SPDX-License-Identifier: Apache-2.0 */
/* Memory with an alignment greater than malloc's. Windows frees it by a function of its own, so all
 * of it goes through these two functions. */
#ifndef ASSAY_PLATFORM_ALIGNED_H
#define ASSAY_PLATFORM_ALIGNED_H

#include <stddef.h>
#include <stdlib.h>
#ifdef _WIN32
#include <malloc.h>
#endif

/* `size` is a multiple of `alignment`. Returns NULL if memory runs out. */
static inline void *aligned_allocate(size_t alignment, size_t size)
{
#ifdef _WIN32
    return _aligned_malloc(size, alignment);
#else
    return aligned_alloc(alignment, size);
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
