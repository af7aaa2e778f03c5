/* SPDX-License-Identifier: Apache-2.0 */
/* How builds and copies read the application's data. Unreadable memory is never dereferenced. */
#ifndef ASSAY_SNAPSHOTS_MEMORY_H
#define ASSAY_SNAPSHOTS_MEMORY_H

#include <stdbool.h>
#include <stdint.h>

#include "src/base/readable.h"
#include "src/platform/threads.h"
#include "src/state/resources/resources.h"

/* `find` may be called from several threads at once. It returns how many bytes from the address on
 * can be read, at most `size`, and sets `bytes` to them. */
struct input_memory {
    uint64_t (*find)(void *context, uint64_t address, uint64_t size, const void **bytes);
    void *context;
    /* Returns the number of bytes from an address to the end of its buffer; 0 if that is unknown.
     * May be NULL. */
    uint64_t (*find_left)(void *context, uint64_t address);
    /* Nothing can be read yet: each `find` only requests data for later. If the amount depends on
     * data that can't be read yet, all possible data is requested. */
    bool is_later;
    bool is_host;      /* addresses are pointers */
    bool is_for_rules; /* only rules read the input: data that no rule reads is not requested */
};

/* The host's own memory; addresses are pointers. For one operation, because readable pages are
 * cached. */
struct host_memory {
    pthread_mutex_t lock; /* guards the cache */
    struct readable_cache readable;
};

void host_memory_init(struct host_memory *host);
void host_memory_release(struct host_memory *host);
struct input_memory host_memory_of(struct host_memory *host);

/* Whether all of [pointer, pointer + size) can be written. Overwrites bytes of it with themselves,
 * so no other thread may write there at the same time. */
bool memory_is_writable(void *pointer, uint64_t size);

struct buffer_target {
    VkBuffer buffer;
    VkDeviceSize offset, size; /* bytes from the offset to the buffer's end */
    bool is_protected;         /* unprotected commands may not access it */
};

/* The buffer that has the address now. Returns false, with zeros in `target`, if no buffer has it
 * or if that is unknown. */
bool buffer_target_find(struct resources *resources, VkDeviceAddress address,
                        struct buffer_target *target);

#endif
