/* SPDX-License-Identifier: Apache-2.0 */
/* The wrapped allocation functions. */
#include "scarce_memory.h"

#include "tests/builder/allocations.h"
#include "tests/builder/guarded.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

enum { OFF = -1 };

static _Thread_local int left = OFF;
static _Thread_local bool has_failed, fails_for_good;
static atomic_int blocks;

int allocations_now(void)
{
    return blocks;
}

void *__real_malloc(size_t size);
void *__real_aligned_alloc(size_t alignment, size_t size);
void *__real_calloc(size_t count, size_t size);
void *__real_realloc(void *old, size_t size);
char *__real_strdup(const char *text);
void __real_free(void *block);
void *__wrap_malloc(size_t size);
void *__wrap_aligned_alloc(size_t alignment, size_t size);
void *__wrap_calloc(size_t count, size_t size);
void *__wrap_realloc(void *old, size_t size);
char *__wrap_strdup(const char *text);
void __wrap_free(void *block);

void memory_fail_after(int count)
{
#ifdef _WIN32
    skip(); /* nothing wraps the functions that allocate: allocations_wrap() in tests/CMakeLists.txt
             */
#endif
    left = count;
    has_failed = fails_for_good = false;
}

void memory_fail_from(int count)
{
    memory_fail_after(count);
    fails_for_good = true;
}

bool memory_is_scarce(int count)
{
    if (count > 0 && !has_failed) {
        assert_true(count > 2); /* memory did run out */
        return false;
    }
    memory_fail_after(count);
    return true;
}

bool memory_fail_no_more(void)
{
    left = OFF;
    return has_failed;
}

int memory_pause(void)
{
    const int before = left;
    left = OFF;
    return before;
}

void memory_resume(int before)
{
    left = before;
}

static bool fails(void)
{
    if (left == OFF)
        return false;
    if (left-- > 0)
        return false;
    has_failed = true;
    if (fails_for_good)
        left = 0;
    return true;
}

static void *counted(void *block)
{
    blocks += block != NULL;
    return block;
}

void *__wrap_malloc(size_t size)
{
    return fails() ? NULL : counted(guarded_open(__real_malloc(guarded_size(size)), size, 0));
}

void *__wrap_aligned_alloc(size_t alignment, size_t size)
{
    const size_t more = (guarded_size(size) - size + alignment - 1) / alignment * alignment;
    if (fails())
        return NULL;
    return counted(guarded_open(__real_aligned_alloc(alignment, size + more), size, 0));
}

void *__wrap_calloc(size_t count, size_t size)
{
    size_t bytes;
    if (fails() || __builtin_mul_overflow(count, size, &bytes))
        return NULL;
    return counted(guarded_open(__real_calloc(1, guarded_size(bytes)), bytes, bytes));
}

void *__wrap_realloc(void *old, size_t size)
{
    if (fails())
        return NULL;
    void *moved = guarded_realloc(__real_realloc, old, size);
    blocks += moved != NULL && old == NULL;
    return moved;
}

char *__wrap_strdup(const char *text)
{
    return fails() ? NULL : counted(__real_strdup(text));
}

void __wrap_free(void *block)
{
    blocks -= block != NULL;
    guarded_close(block);
    __real_free(block);
}
