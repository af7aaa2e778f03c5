/* SPDX-License-Identifier: Apache-2.0 */
/* Translates stages and accesses of ray tracing for a driver without ray tracing.
 *
 * The backend records its part of a build as copies at the build's position in the command buffer.
 * A build may read its inputs with any access of its stage. So the stage becomes all commands, and
 * the accesses at that stage become all memory accesses. That orders at least what the application
 * requests, and the copies too. The bits of VkPipelineStageFlags and VkAccessFlags are the lowest
 * ones of the 64-bit flags. */
#ifndef ASSAY_LAYER_CPU_DRIVER_MASKS_H
#define ASSAY_LAYER_CPU_DRIVER_MASKS_H

#include <stdbool.h>
#include <vulkan/vulkan_core.h>

#include "src/base/block.h"

static const VkPipelineStageFlags2 RAY_TRACING_STAGES =
    VK_PIPELINE_STAGE_2_ACCELERATION_STRUCTURE_BUILD_BIT_KHR |
    VK_PIPELINE_STAGE_2_ACCELERATION_STRUCTURE_COPY_BIT_KHR |
    VK_PIPELINE_STAGE_2_RAY_TRACING_SHADER_BIT_KHR | VK_PIPELINE_STAGE_2_MICROMAP_BUILD_BIT_EXT;

static const VkAccessFlags2 RAY_TRACING_READS = VK_ACCESS_2_ACCELERATION_STRUCTURE_READ_BIT_KHR |
                                                VK_ACCESS_2_SHADER_BINDING_TABLE_READ_BIT_KHR |
                                                VK_ACCESS_2_MICROMAP_READ_BIT_EXT;

static const VkAccessFlags2 RAY_TRACING_WRITES =
    VK_ACCESS_2_ACCELERATION_STRUCTURE_WRITE_BIT_KHR | VK_ACCESS_2_MICROMAP_WRITE_BIT_EXT;

static inline bool stages_trace(VkPipelineStageFlags2 stages)
{
    return stages & RAY_TRACING_STAGES;
}

static inline bool accesses_trace(VkAccessFlags2 accesses)
{
    return accesses & (RAY_TRACING_READS | RAY_TRACING_WRITES);
}

static inline VkPipelineStageFlags2 stages_below(VkPipelineStageFlags2 stages)
{
    return stages_trace(stages)
               ? (stages & ~RAY_TRACING_STAGES) | VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT
               : stages;
}

/* `stages`: the application's stages at which the accesses happen. */
static inline VkAccessFlags2 accesses_below(VkPipelineStageFlags2 stages, VkAccessFlags2 accesses)
{
    VkAccessFlags2 below = accesses & ~(RAY_TRACING_READS | RAY_TRACING_WRITES);
    if (accesses & RAY_TRACING_READS || (accesses && stages_trace(stages)))
        below |= VK_ACCESS_2_MEMORY_READ_BIT;
    if (accesses & RAY_TRACING_WRITES)
        below |= VK_ACCESS_2_MEMORY_WRITE_BIT;
    return below;
}

static inline bool stages_of_array_trace(const VkPipelineStageFlags *stages, uint32_t count)
{
    bool found = false;
    for (uint32_t i = 0; i < count && !found; i++)
        found = stages_trace(stages[i]);
    return found;
}

static inline VkPipelineStageFlags *
stages_of_array_below(struct block *block, const VkPipelineStageFlags *stages, uint32_t count)
{
    VkPipelineStageFlags *below = block_copy(block, stages, count, sizeof(*below));
    for (uint32_t i = 0; i < count; i++)
        below[i] = (VkPipelineStageFlags)stages_below(below[i]);
    return below;
}

#endif
