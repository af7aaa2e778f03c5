/* SPDX-License-Identifier: Apache-2.0 */
/* The facts that structures and micromaps have in common, and what became of one since a command
 * was recorded. `type`: of a structure of either extension, or of a VkMicromapEXT. */
#ifndef ASSAY_CHECK_REPLAY_OBJECT_STATES_H
#define ASSAY_CHECK_REPLAY_OBJECT_STATES_H

#include "src/state/commands/journal.h"
#include "src/state/resources/resources.h"

struct object_facts {
    enum tristate alive, backed;
    bool buffer_is_destroyed;
    uint64_t id;             /* 0 unless alive */
    VkDeviceSize size;       /* that it was created with, in bytes; 0: unknown */
    struct memory_span span; /* its bytes; memory null: unknown */
};

/* The value of journal_entry.dst_backing or src_backing. */
static inline unsigned char object_backing(const struct object_facts *facts)
{
    return facts->backed == YES ? BACKED_BY_MEMORY : 0;
}

struct object_facts object_facts_find(struct resources *resources, VkObjectType type,
                                      uint64_t handle);

struct object_state {
    bool is_destroyed;
    bool has_no_memory;       /* it is alive, and its memory was freed or its buffer destroyed */
    bool buffer_is_destroyed; /* if has_no_memory */
};

/* `id` and `was_backed`: as known when the command was recorded. */
struct object_state object_state_find(struct resources *resources, VkObjectType type,
                                      uint64_t handle, uint64_t id, bool was_backed);

#endif
