/* SPDX-License-Identifier: Apache-2.0 */
/* Whether application memory can be read, without touching it.
 *
 * rt_sigprocmask with a `how` that there is not reports a fault as an error instead of a signal,
 * and does nothing else (process_vm_readv on the own process, which is for copies and for programs
 * under Valgrind, does so, too).
 * Where the system forbids them every pointer counts as readable. A cache remembers a few ranges
 * that were found readable, which grow page by page and together, so that arrays that are walked
 * side by side do not drive each other out. */
#ifndef ASSAY_BASE_READABLE_H
#define ASSAY_BASE_READABLE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum {
    READABLE_RANGES = 8,
    READABLE_RECENT = 64,    /* a power of two */
    READABLE_PAGE_SHIFT = 12 /* of the smallest pages of the platforms; larger ones are probed in
                                parts */
};

/* Ranges of whole pages that were readable when last asked for. Zero-initialized is empty. Not
 * locked. */
struct readable_cache {
    struct {
        uintptr_t begin, end; /* addresses */
    } ranges[READABLE_RANGES];
    unsigned count;
    unsigned oldest; /* the next to be replaced */
    /* The last addresses of pages found readable, by the low bits of the page's number; 0: none. */
    uintptr_t recent[READABLE_RECENT];
};

/* Empties it. */
void readable_forget(struct readable_cache *cache);

/* The calling thread's, for the arrays that commands are recorded from: of pages that were readable
 * a few milliseconds ago at most, since commands come in runs and each probe is a system call. What
 * an application unmaps and hands over within that time is not noticed, unless the caller empties
 * the cache before; the driver reads it, too. docs/probes.md has the cost of both. */
struct readable_cache *readable_cache_of_thread(void);

/* How many bytes from `pointer` on can be read, at most `size`. */
size_t readable_extent(struct readable_cache *cache, const void *pointer, size_t size);

/* Whether all of [pointer, pointer + size) can be read. Size 0: yes. NULL: no. Most of what is
 * asked for lies in a page that was asked for before. */
static inline bool readable(struct readable_cache *cache, const void *pointer, size_t size)
{
    const uintptr_t page = (uintptr_t)1 << READABLE_PAGE_SHIFT;
    uintptr_t begin = (uintptr_t)pointer, last = begin | (page - 1);
    uintptr_t recent = cache->recent[begin / page % READABLE_RECENT];
    return (recent == last && size - 1 <= last - begin) ||
           readable_extent(cache, pointer, size) == size;
}

/* Copies as much of [from, from + size) as can be read from its begin on; `size` is a page at most.
 * Returns how much that was. */
size_t readable_copy(void *to, const void *from, size_t size);

#endif
