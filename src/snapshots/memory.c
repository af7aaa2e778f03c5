/* SPDX-License-Identifier: Apache-2.0 */
/* The host's memory, probed before it is read. */
#define _GNU_SOURCE /* process_vm_readv */
#include "src/snapshots/memory.h"

#include <errno.h>
#include <sys/uio.h>
#include <unistd.h>

void host_memory_init(struct host_memory *host)
{
    pthread_mutex_init(&host->lock, NULL);
    host->readable = (struct readable_cache){0};
}

void host_memory_release(struct host_memory *host)
{
    pthread_mutex_destroy(&host->lock);
}

/* No array is larger. If probing is forbidden, everything counts as readable, and a wrong stride
 * would otherwise be probed for hours. */
#define EXTENT_MAX (SIZE_MAX >> 24)

static uint64_t find(void *context, uint64_t address, uint64_t size, const void **bytes)
{
    struct host_memory *host = context;
    *bytes = (const void *)(uintptr_t)address; // NOLINT(performance-no-int-to-ptr)
    if ((uintptr_t)address != address)
        return 0;
    pthread_mutex_lock(&host->lock);
    size_t found =
        readable_extent(&host->readable, *bytes, size < EXTENT_MAX ? (size_t)size : EXTENT_MAX);
    pthread_mutex_unlock(&host->lock);
    return found;
}

struct input_memory host_memory_of(struct host_memory *host)
{
    return (struct input_memory){.find = find, .context = host};
}

/* The smallest page size of the platforms. */
#define PAGE_SIZE 4096u
enum { PROBED_PAGES = 64 };

/* Probes one byte of each page. The kernel also faults on the local side of the copy, and reports
 * that as an error. */
static bool probe(char *const bytes[], unsigned count)
{
    struct iovec pages[PROBED_PAGES];
    for (unsigned i = 0; i < count; i++)
        pages[i] = (struct iovec){.iov_base = bytes[i], .iov_len = 1};
    ssize_t copied = process_vm_readv(getpid(), pages, count, pages, count, 0);
    return copied == (ssize_t)count || (copied < 0 && errno != EFAULT);
}

bool memory_is_writable(void *pointer, uint64_t size)
{
    uintptr_t begin = (uintptr_t)pointer;
    if (size == 0)
        return true;
    if (!begin || size - 1 > UINTPTR_MAX - begin)
        return false;
    uintptr_t last = begin + (uintptr_t)(size - 1);
    char *bytes[PROBED_PAGES];
    unsigned count = 0;
    for (uintptr_t at = begin;;) {
        bytes[count++] = (char *)at; // NOLINT(performance-no-int-to-ptr)
        uintptr_t next = (at / PAGE_SIZE + 1) * PAGE_SIZE;
        bool is_end = next > last || next < at;
        if ((is_end || count == PROBED_PAGES) && !probe(bytes, count))
            return false;
        if (is_end)
            return true;
        if (count == PROBED_PAGES)
            count = 0;
        at = next;
    }
}
