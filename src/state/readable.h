/* SPDX-License-Identifier: Apache-2.0 */
/* Whether application memory can be read, without touching it.
 *
 * rt_sigprocmask with a `how` that there is not reports a fault as an error instead of a signal,
 * and does nothing else (process_vm_readv on the own process, which is for copies, does so, too).
 * Where the system forbids them every pointer counts as readable. A cache remembers a few ranges
 * that were found readable, which grow page by page and together, so that arrays that are walked
 * side by side do not drive each other out. */
#ifndef ASSAY_STATE_READABLE_H
#define ASSAY_STATE_READABLE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum { READABLE_RANGES = 8 };

/* Ranges of whole pages that were readable when last asked for. Zero-initialized is empty. Not
 * locked. */
struct readable_cache {
    struct {
        uintptr_t begin, end; /* addresses */
    } ranges[READABLE_RANGES];
    unsigned count;
    unsigned oldest; /* the next to be replaced */
};

/* The calling thread's, for the arrays that commands are recorded from: of pages that were readable
 * a few milliseconds ago at most, since commands come in runs and each probe is a system call. What
 * an application unmaps and hands over within that time is not noticed; the driver reads it, too.
 */
struct readable_cache *readable_cache_of_thread(void);

/* How many bytes from `pointer` on can be read, at most `size`. */
size_t readable_extent(struct readable_cache *cache, const void *pointer, size_t size);

/* Whether all of [pointer, pointer + size) can be read. Size 0: yes. NULL: no. */
static inline bool readable(struct readable_cache *cache, const void *pointer, size_t size)
{
    uintptr_t begin = (uintptr_t)pointer;
    for (unsigned i = cache->count; i-- > 0;)
        if (cache->ranges[i].begin <= begin && begin < cache->ranges[i].end &&
            size <= cache->ranges[i].end - begin)
            return true;
    return readable_extent(cache, pointer, size) == size;
}

/* Copies as much of [from, from + size) as can be read from its begin on; `size` is a page at most.
 * Returns how much that was. */
size_t readable_copy(void *to, const void *from, size_t size);

#endif
