/* SPDX-License-Identifier: Apache-2.0 */
#include "tests/builder/allocations.h"

#include <stdatomic.h>
#include <stdlib.h>

#include "tests/builder/guarded.h"

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
    return counted(guarded_open(__real_malloc(guarded_size(size)), size, 0));
}

void *__wrap_calloc(size_t number, size_t size)
{
    size_t bytes;
    if (__builtin_mul_overflow(number, size, &bytes))
        return NULL;
    return counted(guarded_open(__real_calloc(1, guarded_size(bytes)), bytes, bytes));
}

void *__wrap_realloc(void *bytes, size_t size)
{
    void *moved = guarded_realloc(__real_realloc, bytes, size);
    count += moved != NULL && bytes == NULL;
    return moved;
}

void *__wrap_aligned_alloc(size_t alignment, size_t size)
{
    const size_t more = (guarded_size(size) - size + alignment - 1) / alignment * alignment;
    return counted(guarded_open(__real_aligned_alloc(alignment, size + more), size, 0));
}

void __wrap_free(void *bytes)
{
    count -= bytes != NULL;
    guarded_close(bytes);
    __real_free(bytes);
}
