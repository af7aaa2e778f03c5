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

/* Whether a barrier or subpass dependency traces: any structure with srcStageMask, srcAccessMask,
 * dstStageMask and dstAccessMask, of 32 or 64 bits. */
#define MASKS_TRACE(masks)                                                                         \
    (stages_trace((masks)->srcStageMask) || stages_trace((masks)->dstStageMask) ||                 \
     accesses_trace((masks)->srcAccessMask) || accesses_trace((masks)->dstAccessMask))

#define MASKS_TRANSLATE(masks)                                                                     \
    do {                                                                                           \
        (masks)->srcAccessMask = (__typeof__((masks)->srcAccessMask))accesses_below(               \
            (masks)->srcStageMask, (masks)->srcAccessMask);                                        \
        (masks)->dstAccessMask = (__typeof__((masks)->dstAccessMask))accesses_below(               \
            (masks)->dstStageMask, (masks)->dstAccessMask);                                        \
        (masks)->srcStageMask =                                                                    \
            (__typeof__((masks)->srcStageMask))stages_below((masks)->srcStageMask);                \
        (masks)->dstStageMask =                                                                    \
            (__typeof__((masks)->dstStageMask))stages_below((masks)->dstStageMask);                \
    } while (0)

#endif
