/* SPDX-License-Identifier: Apache-2.0 */
/* Where builds and copies read the application's data, without ever touching what can't be read. */
#ifndef ASSAY_SNAPSHOTS_MEMORY_H
#define ASSAY_SNAPSHOTS_MEMORY_H

#include <pthread.h>
#include <stdbool.h>
#include <stdint.h>

#include "src/base/readable.h"

/* `find` may be called from several threads at once. It returns how many bytes from the address on
 * can be read, at most `size`, and where they are. */
struct input_memory {
    uint64_t (*find)(void *context, uint64_t address, uint64_t size, const void **bytes);
    void *context;
    /* How many bytes there are from an address to the end of its buffer; 0: it is not known. May be
     * NULL. */
    uint64_t (*find_left)(void *context, uint64_t address);
    /* Nothing can be read yet: what is asked for will be. Where data that can't be read tell how
     * much that is, all is asked for. */
    bool is_later;
    bool is_for_rules; /* nothing is built from it: what no rule looks at isn't asked for */
};

/* The host's own memory: addresses are pointers. For one operation: what was found readable is
 * remembered. */
struct host_memory {
    pthread_mutex_t lock; /* of the cache */
    struct readable_cache readable;
};

void host_memory_init(struct host_memory *host);
void host_memory_release(struct host_memory *host);
struct input_memory host_memory_of(struct host_memory *host);

/* Whether all of [pointer, pointer + size) can be written. Writes bytes of it over themselves, so
 * nobody else may be writing there. */
bool memory_is_writable(void *pointer, uint64_t size);

#endif
