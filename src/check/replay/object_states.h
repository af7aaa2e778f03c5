/* SPDX-License-Identifier: Apache-2.0 */
/* What became of a structure or micromap since a command was recorded. */
#ifndef ASSAY_CHECK_REPLAY_OBJECT_STATES_H
#define ASSAY_CHECK_REPLAY_OBJECT_STATES_H

#include "src/state/resources/resources.h"

struct object_state {
    bool is_destroyed;
    bool lost_memory;         /* it is alive, and its memory was freed or its buffer destroyed */
    bool buffer_is_destroyed; /* if lost_memory */
};

/* `id` and `was_backed`: as known when the command was recorded. `type`: of a structure of either
 * extension, or of a VkMicromapEXT. */
struct object_state object_state_find(struct resources *resources, VkObjectType type,
                                      uint64_t handle, uint64_t id, bool was_backed);

#endif
