/* SPDX-License-Identifier: Apache-2.0 */
/* Which structures the descriptor sets of a device hold, so that the hazard check knows what a
 * command may trace. A set may hold more than is known only if it says so: by unknown(), or by
 * `lacks`, for all sets. Has a lock of its own. */
#ifndef ASSAY_LAYER_HAZARDS_DESCRIPTORS_H
#define ASSAY_LAYER_HAZARDS_DESCRIPTORS_H

#include <stdatomic.h>

#include "src/base/handle_table.h"
#include "src/base/reader_lock.h"

enum { TRACED_MAX = 16 }; /* structures of the sets that one command may trace; more are unknown */

/* All-zero: no set holds a structure. */
struct descriptor_sets {
    struct reader_lock lock;
    struct handle_table sets; /* those to which a structure was written */
    uint32_t count;
    /* Shaders may find structures elsewhere: by their addresses, in buffers or heaps of
     * descriptors, in sets that change after they are bound; or memory ran out. */
    atomic_bool lacks;
};

void descriptor_sets_end(struct descriptor_sets *sets);
void descriptor_sets_lack(struct descriptor_sets *sets);

/* A new set holds nothing. */
void descriptor_sets_forget(struct descriptor_sets *sets, uint64_t set);
void descriptor_sets_write(struct descriptor_sets *sets, uint64_t set, uint32_t binding,
                           uint32_t element, uint64_t structure);
/* What the set holds is unknown. */
void descriptor_sets_lose(struct descriptor_sets *sets, uint64_t set);
/* If the set may hold structures, so may `to`. */
void descriptor_sets_copy(struct descriptor_sets *sets, uint64_t set, uint64_t to);

/* Adds what a set holds to the first `*count` elements. Returns false if that is unknown, or if it
 * is too much. */
bool descriptor_sets_find(struct descriptor_sets *sets, uint64_t set, uint64_t found[TRACED_MAX],
                          uint32_t *count);

#endif
