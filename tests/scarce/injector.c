/* SPDX-License-Identifier: Apache-2.0 */
/* The allocation functions of this program. They forward to those of the C library by the names
 * under which glibc has them beside the standard ones. */
#define _GNU_SOURCE /* _dl_find_object */
#include "injector.h"

#include <dlfcn.h>
#include <errno.h>
#include <execinfo.h>
#include <link.h>
#include <pthread.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

enum { SLOTS = 1 << 16 }; /* far more than blocks that are ever live */

void *__libc_malloc(size_t size);
void *__libc_calloc(size_t count, size_t size);
void *__libc_realloc(void *old, size_t size);
void *__libc_memalign(size_t alignment, size_t size);
void __libc_free(void *block);

/* The watched library's addresses. */
static uintptr_t first, last;

/* The layer has threads, too. Recursive, because backtrace() may free what it allocated. */
static pthread_mutex_t lock = PTHREAD_RECURSIVE_MUTEX_INITIALIZER_NP; /* guards what follows */

static unsigned count, failing;
static size_t failed; /* where */

static uint64_t *stacks; /* of allocations, or NULL */
static unsigned stacks_most;

/* Open addressing with linear probing. A freed block keeps its slot, for the next at its address.
 */
static struct block {
    const void *address;
    unsigned serial; /* 0: freed */
    size_t caller;
} blocks[SLOTS];
static size_t live;

static struct block *slot_of(const void *address)
{
    size_t i = (uintptr_t)address / 16 * 40503 % SLOTS;
    while (blocks[i].address && blocks[i].address != address)
        i = (i + 1) % SLOTS;
    return &blocks[i];
}

static void note(const void *address, uintptr_t caller)
{
    if (!address)
        return;
    pthread_mutex_lock(&lock);
    *slot_of(address) = (struct block){address, count, caller - first};
    live++;
    pthread_mutex_unlock(&lock);
}

static void forget(const void *address)
{
    pthread_mutex_lock(&lock);
    struct block *block = address && live ? slot_of(address) : NULL;
    if (block && block->serial) {
        block->serial = 0;
        live--;
    }
    pthread_mutex_unlock(&lock);
}

static bool is_watched(uintptr_t caller)
{
    return caller >= first && caller < last;
}

static void record_stack(void)
{
    void *frames[64];
    const int depth = backtrace(frames, 64);
    uint64_t hash = 0xcbf29ce484222325u; /* FNV-1a */
    for (int i = 0; i < depth; i++)
        if (is_watched((uintptr_t)frames[i]))
            hash = (hash ^ ((uintptr_t)frames[i] - first)) * 0x100000001b3u;
    stacks[count - 1] = hash;
}

static bool fails(uintptr_t caller)
{
    if (!is_watched(caller))
        return false;
    pthread_mutex_lock(&lock);
    count++;
    if (stacks && count <= stacks_most)
        record_stack();
    const bool is_failing = count == failing;
    if (is_failing)
        failed = caller - first;
    pthread_mutex_unlock(&lock);
    return is_failing;
}

/* ---- the functions, with the names that the C library gives their parameters */

#define CALLER ((uintptr_t)__builtin_return_address(0))
#define REPLACED __attribute__((visibility("default"), noinline))

static void *allocated(void *block, uintptr_t caller)
{
    if (is_watched(caller))
        note(block, caller);
    return block;
}

REPLACED void *malloc(size_t size)
{
    return fails(CALLER) ? NULL : allocated(__libc_malloc(size), CALLER);
}

REPLACED void *calloc(size_t nmemb, size_t size)
{
    return fails(CALLER) ? NULL : allocated(__libc_calloc(nmemb, size), CALLER);
}

REPLACED void *realloc(void *ptr, size_t size)
{
    if (fails(CALLER))
        return NULL;
    forget(ptr); /* first, because another thread may get the block at once */
    return allocated(__libc_realloc(ptr, size), CALLER);
}

REPLACED void *aligned_alloc(size_t alignment, size_t size)
{
    return fails(CALLER) ? NULL : allocated(__libc_memalign(alignment, size), CALLER);
}

REPLACED int posix_memalign(void **memptr, size_t alignment, size_t size)
{
    void *result = fails(CALLER) ? NULL : allocated(__libc_memalign(alignment, size), CALLER);
    if (!result)
        return ENOMEM;
    *memptr = result;
    return 0;
}

REPLACED char *strdup(const char *s)
{
    size_t size = strlen(s) + 1;
    char *copy = fails(CALLER) ? NULL : allocated(__libc_malloc(size), CALLER);
    return copy ? memcpy(copy, s, size) : NULL;
}

REPLACED void free(void *ptr)
{
    forget(ptr);
    __libc_free(ptr);
}

/* ---- control */

bool injector_watch(const char *path)
{
    void *library = dlopen(path, RTLD_NOW | RTLD_LOCAL);
    struct link_map *map;
    struct dl_find_object found;
    if (!library || dlinfo(library, RTLD_DI_LINKMAP, &map) != 0 ||
        _dl_find_object(map->l_ld, &found) != 0)
        return false;
    first = (uintptr_t)found.dlfo_map_start;
    last = (uintptr_t)found.dlfo_map_end;
    return true;
}

void injector_fail_at(unsigned n)
{
    count = 0;
    failing = n;
    failed = 0;
}

void injector_record_stacks(uint64_t *of_allocations, unsigned most)
{
    stacks = of_allocations;
    stacks_most = most;
}

size_t injector_failed(void)
{
    return failed;
}

size_t injector_live(void)
{
    return live;
}

size_t injector_oldest(void)
{
    const struct block *oldest = NULL;
    for (size_t i = 0; i < SLOTS; i++)
        if (blocks[i].serial && (!oldest || blocks[i].serial < oldest->serial))
            oldest = &blocks[i];
    return oldest ? oldest->caller : 0;
}
