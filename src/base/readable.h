/* SPDX-License-Identifier: Apache-2.0 */
/* Determines whether application memory is readable, without accessing it directly.
 *
 * src/platform/probe.h asks the system. A cache remembers a few readable ranges. Ranges grow page
 * by page and merge, so that arrays that are read in parallel do not evict each other. */
#ifndef ASSAY_BASE_READABLE_H
#define ASSAY_BASE_READABLE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "src/platform/probe.h"

enum {
    READABLE_RANGES = 8,
    READABLE_RECENT = 64, /* a power of two */
    READABLE_PAGE_SHIFT = PROBE_PAGE_SHIFT
};

/* Ranges of whole pages that were readable at the last probe. A zero-initialized cache is empty.
 * The cache has no lock. */
struct readable_cache {
    struct {
        uintptr_t begin, end; /* addresses */
    } ranges[READABLE_RANGES];
    unsigned count;
    unsigned oldest; /* index of the next range to be replaced */
    /* The last address of recently probed readable pages, indexed by the low bits of the page
     * number; 0 if empty. */
    uintptr_t recent[READABLE_RECENT];
};

/* Empties the cache. */
void readable_forget(struct readable_cache *cache);

/* Empties the caches of all threads before they are used again: the driver unmaps memory. */
void readable_forget_all(void);

/* Returns the cache of the calling thread, for the arrays that commands are recorded from. Its
 * entries are at most a few milliseconds old: commands come in bursts, and each probe is a system
 * call. If an application unmaps memory of its own and passes a pointer to it within that time, the
 * cache still reports the memory as readable, unless the caller empties the cache first; the driver
 * would read the same memory. docs/probes.md lists the cost of both. */
struct readable_cache *readable_cache_of_thread(void);

/* Returns the number of readable bytes from `pointer` on, at most `size`. */
size_t readable_extent(struct readable_cache *cache, const void *pointer, size_t size);

/* Returns whether all of [pointer, pointer + size) is readable. Size 0 is readable; NULL is not.
 * The inline part covers a pointer into a page that was probed recently. */
static inline bool readable(struct readable_cache *cache, const void *pointer, size_t size)
{
    const uintptr_t page = (uintptr_t)1 << READABLE_PAGE_SHIFT;
    uintptr_t begin = (uintptr_t)pointer, last = begin | (page - 1);
    uintptr_t recent = cache->recent[begin / page % READABLE_RECENT];
    return (recent == last && size - 1 <= last - begin) ||
           readable_extent(cache, pointer, size) == size;
}

#endif
