/* SPDX-License-Identifier: Apache-2.0 */
/* Translates the dependencies of synchronization commands into entries of a journal. */
#ifndef ASSAY_LAYER_HAZARDS_BARRIERS_H
#define ASSAY_LAYER_HAZARDS_BARRIERS_H

#include "layer/hazards/recording.h"

/* The parameters that vkCmdPipelineBarrier and vkCmdWaitEvents share. An image barrier orders
 * commands as the stage masks say, and no bytes that are tracked. */
struct barrier_parameters {
    VkPipelineStageFlags src_stages, dst_stages;
    uint32_t memory_count;
    const VkMemoryBarrier *memory;
    uint32_t buffer_count;
    const VkBufferMemoryBarrier *buffers;
};
void barriers_add(struct hazard_recording *recording, const struct barrier_parameters *parameters);
void barriers_add_wait(struct hazard_recording *recording, VkEvent event,
                       const struct barrier_parameters *parameters);

/* For the commands of synchronization2. */
void barriers_add_2(struct hazard_recording *recording, const VkDependencyInfo *info);
void barriers_add_wait_2(struct hazard_recording *recording, VkEvent event,
                         const VkDependencyInfo *info);
/* vkCmdSetEvent and vkCmdSetEvent2: the first scope has all src stages. */
void barriers_add_set(struct hazard_recording *recording, VkEvent event,
                      VkPipelineStageFlags2 stages);
void barriers_add_set_2(struct hazard_recording *recording, VkEvent event,
                        const VkDependencyInfo *info);

/* A dependency of a render pass, for all bytes. */
void barriers_add_global(struct hazard_recording *recording, const struct dependency *dependency);

/* Adds the access flags of a VkMemoryBarrierAccessFlags3KHR in a chain. */
struct dependency barriers_with_flags_3(struct dependency dependency, const void *chain);

/* All commands before, and all after, with all their accesses. */
struct dependency barriers_full_dependency(void);

#endif
