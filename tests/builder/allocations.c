/* SPDX-License-Identifier: Apache-2.0 */
#include "tests/builder/allocations.h"

#include <stdatomic.h>
#include <stdlib.h>

static atomic_int count;

int allocations_now(void)
{
    return count;
}

/* The linker's --wrap calls these in place of the C library's. */
void *__real_malloc(size_t size);
void *__real_calloc(size_t number, size_t size);
void *__real_realloc(void *bytes, size_t size);
void *__real_aligned_alloc(size_t alignment, size_t size);
void __real_free(void *bytes);
void *__wrap_malloc(size_t size);
void *__wrap_calloc(size_t number, size_t size);
void *__wrap_realloc(void *bytes, size_t size);
void *__wrap_aligned_alloc(size_t alignment, size_t size);
void __wrap_free(void *bytes);

static void *counted(void *bytes)
{
    count += bytes != NULL;
    return bytes;
}

void *__wrap_malloc(size_t size)
{
    return counted(__real_malloc(size));
}

void *__wrap_calloc(size_t number, size_t size)
{
    return counted(__real_calloc(number, size));
}

void *__wrap_realloc(void *bytes, size_t size)
{
    void *moved = __real_realloc(bytes, size);
    count += moved != NULL && bytes == NULL;
    return moved;
}

void *__wrap_aligned_alloc(size_t alignment, size_t size)
{
    return counted(__real_aligned_alloc(alignment, size));
}

void __wrap_free(void *bytes)
{
    count -= bytes != NULL;
    __real_free(bytes);
}
