/* SPDX-License-Identifier: Apache-2.0 */
/* Probing memory through process_vm_readv. */
#define _GNU_SOURCE /* process_vm_readv */
#include "state/readable.h"

#include <errno.h>
#include <sys/uio.h>
#include <unistd.h>

enum { PAGE_SHIFT = 12 }; /* the smallest page of the platforms; larger ones are probed in parts */

static bool probe(uintptr_t address)
{
    char byte;
    struct iovec local = {.iov_base = &byte, .iov_len = 1};
    struct iovec remote = {.iov_base = (void *)address, .iov_len = 1};
    return process_vm_readv(getpid(), &local, 1, &remote, 1, 0) == 1 || errno != EFAULT;
}

bool readable(struct readable_cache *cache, const void *pointer, size_t size)
{
    uintptr_t begin = (uintptr_t)pointer;
    if (!size)
        return true;
    if (!begin || begin + (size - 1) < begin)
        return false;
    uintptr_t last = (begin + (size - 1)) >> PAGE_SHIFT;
    for (uintptr_t page = begin >> PAGE_SHIFT; page <= last; page++) {
        uintptr_t *slot = &cache->pages[page % READABLE_CACHE_PAGES];
        if (*slot == page + 1)
            continue;
        if (!probe(page << PAGE_SHIFT))
            return false;
        *slot = page + 1;
    }
    return true;
}
