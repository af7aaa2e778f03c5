/* SPDX-License-Identifier: Apache-2.0 */
/* Whether application memory can be read, without touching it.
 *
 * process_vm_readv on the own process copies what it can and reports a fault as an error instead of
 * a signal (man 2 process_vm_readv). Where the system forbids it every pointer counts as readable.
 * A cache remembers pages, so that arrays cost one call a page. */
#ifndef ASSAY_STATE_READABLE_H
#define ASSAY_STATE_READABLE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum { READABLE_CACHE_PAGES = 16 };

/* Pages that were readable when last asked for. Zero-initialized is empty. Not locked. */
struct readable_cache {
    uintptr_t pages[READABLE_CACHE_PAGES]; /* page number + 1; 0: empty */
};

/* Whether all of [pointer, pointer + size) can be read. Size 0: yes. NULL: no. */
bool readable(struct readable_cache *cache, const void *pointer, size_t size);

#endif
