/* SPDX-License-Identifier: Apache-2.0 */
/* The host's memory, probed before it is read; and buffers by address. */
#include "src/snapshots/memory.h"

#include "src/platform/probe.h"

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

static uint64_t find_snapshot_bytes(void *context, uint64_t address, uint64_t size,
                                    const void **bytes)
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
    return (struct input_memory){.find = find_snapshot_bytes, .context = host, .is_host = true};
}

static const uintptr_t page_size = (uintptr_t)1 << PROBE_PAGE_SHIFT;

bool memory_is_writable(void *pointer, uint64_t size)
{
    uintptr_t begin = (uintptr_t)pointer;
    if (size == 0)
        return true;
    if (!begin || size - 1 > UINTPTR_MAX - begin)
        return false;
    uintptr_t last = begin + (uintptr_t)(size - 1);
    char *bytes[PROBE_PAGES];
    unsigned count = 0;
    for (uintptr_t at = begin;;) {
        bytes[count++] = (char *)at; // NOLINT(performance-no-int-to-ptr)
        uintptr_t last_of_page = at | (page_size - 1);
        bool is_end = last_of_page >= last;
        if ((is_end || count == PROBE_PAGES) && !probe_writable(bytes, count))
            return false;
        if (is_end)
            return true;
        if (count == PROBE_PAGES)
            count = 0;
        at = last_of_page + 1;
    }
}

/* ---- buffers by address */

bool buffer_target_find(struct resources *resources, VkDeviceAddress address,
                        struct buffer_target *target)
{
    struct address_facts facts;
    struct buffer_facts buffer;
    unsigned token = resources_begin_reading(resources);
    resources_find_address(resources, address, &facts);
    resources_find_buffer(resources, facts.buffer, &buffer);
    resources_end_reading(resources, token);
    *target = (struct buffer_target){0};
    if (facts.status != ADDRESS_IN_BUFFER)
        return false;
    *target = (struct buffer_target){facts.buffer, buffer.size - facts.bytes_left, facts.bytes_left,
                                     facts.is_protected};
    return true;
}
