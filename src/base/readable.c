/* SPDX-License-Identifier: Apache-2.0 */
/* Caches of readable ranges. */
#include "src/base/readable.h"

#include <stdatomic.h>
#include <string.h>

#include "src/base/recording_path.h"
#include "src/platform/clock.h"
#include "src/platform/probe.h"

static const uintptr_t page_size = (uintptr_t)1 << READABLE_PAGE_SHIFT;

/* Returns the end of the cached range that contains `address`, or 0. */
static uintptr_t known_end(const struct readable_cache *cache, uintptr_t address)
{
    for (unsigned i = 0; i < cache->count; i++)
        if (cache->ranges[i].begin <= address && address < cache->ranges[i].end)
            return cache->ranges[i].end;
    return 0;
}

/* Adds a page and merges it with the ranges that are adjacent to it. */
static void add_page(struct readable_cache *cache, uintptr_t begin, uintptr_t end)
{
    unsigned kept = 0;
    for (unsigned i = 0; i < cache->count; i++) {
        if (cache->ranges[i].end == begin)
            begin = cache->ranges[i].begin;
        else if (cache->ranges[i].begin == end)
            end = cache->ranges[i].end;
        else
            cache->ranges[kept++] = cache->ranges[i];
    }
    unsigned range = kept;
    if (kept == READABLE_RANGES) {
        range = cache->oldest;
        cache->oldest = (range + 1) % READABLE_RANGES;
    } else {
        cache->count = kept + 1;
    }
    cache->ranges[range].begin = begin;
    cache->ranges[range].end = end;
}

/* Probes the page of `address`. Returns the end of the readable page, or 0. */
static uintptr_t find_end(struct readable_cache *cache, uintptr_t address)
{
    uintptr_t page = address & ~(page_size - 1);
    if (!probe_page(page + page_size))
        return 0;
    add_page(cache, page, page + page_size);
    return page + page_size;
}

void readable_forget(struct readable_cache *cache)
{
    cache->count = 0;
    memset(cache->recent, 0, sizeof(cache->recent));
}

/* How often memory may have become unreadable, as far as is known. */
static _Atomic uint64_t unmappings;

void readable_forget_all(void)
{
    atomic_fetch_add_explicit(&unmappings, 1, memory_order_relaxed);
}

struct cache_of_thread {
    uint64_t filled; /* clock_tick() plus `unmappings`, both of which only grow */
    struct readable_cache cache;
};

/* Noinline, so that the thread-local variable is located once per call: a library loaded by dlopen
 * locates each access through a function call. */
ON_RECORDING_PATH __attribute__((noinline)) static struct cache_of_thread *cache_of_thread(void)
{
    static _Thread_local struct cache_of_thread of_thread;
    return &of_thread;
}

ON_RECORDING_PATH struct readable_cache *readable_cache_of_thread(void)
{
    struct cache_of_thread *own = cache_of_thread();
    const uint64_t now = clock_tick() + atomic_load_explicit(&unmappings, memory_order_relaxed);
    if (now != own->filled) {
        own->filled = now;
        readable_forget(&own->cache);
    }
    return &own->cache;
}

ON_RECORDING_PATH size_t readable_extent(struct readable_cache *cache, const void *pointer,
                                         size_t size)
{
    uintptr_t begin = (uintptr_t)pointer;
    if (!size || !begin)
        return 0;
    uintptr_t last = size - 1 <= UINTPTR_MAX - begin ? begin + (size - 1) : UINTPTR_MAX;
    uintptr_t at = begin;
    while (at <= last) {
        uintptr_t end = known_end(cache, at);
        if (!end)
            end = find_end(cache, at);
        if (!end)
            return at - begin;
        at = end;
    }
    cache->recent[begin / page_size % READABLE_RECENT] = begin | (page_size - 1);
    return size;
}
