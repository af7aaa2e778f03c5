/* SPDX-License-Identifier: Apache-2.0 */
/* Commands of backend cpu: barriers, events and timestamps of Vulkan 1.0. Their stages and accesses
 * of ray tracing are translated for the driver. A call without such bits goes down unchanged. So
 * does a call with more barriers than fit on the stack, if memory runs out. */
#include "layer/cpu/driver/block.h"
#include "layer/cpu/driver/masks.h"
#include "layer/cpu/overlay.h"
#include "observers.h"

static VkPipelineStageFlags narrow_stages(VkPipelineStageFlags stages)
{
    return (VkPipelineStageFlags)stages_below(stages);
}

/* The common parameters of vkCmdPipelineBarrier and vkCmdWaitEvents. */
struct dependency {
    VkPipelineStageFlags src, dst;
    uint32_t memory_count, buffer_count, image_count;
    const VkMemoryBarrier *memory;
    const VkBufferMemoryBarrier *buffers;
    const VkImageMemoryBarrier *images;
};

static bool accesses_of_pair_trace(VkAccessFlags src, VkAccessFlags dst)
{
    return accesses_trace(src) || accesses_trace(dst);
}

static bool dependency_traces(const struct dependency *dependency)
{
    bool found = stages_trace(dependency->src) || stages_trace(dependency->dst);
    for (uint32_t i = 0; i < dependency->memory_count && !found; i++)
        found = accesses_of_pair_trace(dependency->memory[i].srcAccessMask,
                                       dependency->memory[i].dstAccessMask);
    for (uint32_t i = 0; i < dependency->buffer_count && !found; i++)
        found = accesses_of_pair_trace(dependency->buffers[i].srcAccessMask,
                                       dependency->buffers[i].dstAccessMask);
    for (uint32_t i = 0; i < dependency->image_count && !found; i++)
        found = accesses_of_pair_trace(dependency->images[i].srcAccessMask,
                                       dependency->images[i].dstAccessMask);
    return found;
}

static void translate_accesses(const struct dependency *dependency, VkAccessFlags *src,
                               VkAccessFlags *dst)
{
    *src = (VkAccessFlags)accesses_below(dependency->src, *src);
    *dst = (VkAccessFlags)accesses_below(dependency->dst, *dst);
}

/* Translates the dependency for the driver, with copies in the block, which the caller ends. */
static void dependency_begin(struct block *block, struct dependency *dependency)
{
    const bool traces = dependency_traces(dependency);
    const size_t size = block_size(dependency->memory_count, sizeof(VkMemoryBarrier)) +
                        block_size(dependency->buffer_count, sizeof(VkBufferMemoryBarrier)) +
                        block_size(dependency->image_count, sizeof(VkImageMemoryBarrier));
    if (!block_begin(block, traces ? size : 0) || !traces)
        return;
    VkMemoryBarrier *memory =
        block_copy(block, dependency->memory, dependency->memory_count, sizeof(*memory));
    for (uint32_t i = 0; i < dependency->memory_count; i++)
        translate_accesses(dependency, &memory[i].srcAccessMask, &memory[i].dstAccessMask);
    VkBufferMemoryBarrier *buffers =
        block_copy(block, dependency->buffers, dependency->buffer_count, sizeof(*buffers));
    for (uint32_t i = 0; i < dependency->buffer_count; i++)
        translate_accesses(dependency, &buffers[i].srcAccessMask, &buffers[i].dstAccessMask);
    VkImageMemoryBarrier *images =
        block_copy(block, dependency->images, dependency->image_count, sizeof(*images));
    for (uint32_t i = 0; i < dependency->image_count; i++)
        translate_accesses(dependency, &images[i].srcAccessMask, &images[i].dstAccessMask);
    dependency->memory = memory;
    dependency->buffers = buffers;
    dependency->images = images;
    dependency->src = narrow_stages(dependency->src);
    dependency->dst = narrow_stages(dependency->dst);
}

VKAPI_ATTR void VKAPI_CALL cpu_CmdPipelineBarrier(
    VkCommandBuffer commandBuffer, VkPipelineStageFlags srcStageMask,
    VkPipelineStageFlags dstStageMask, VkDependencyFlags dependencyFlags,
    uint32_t memoryBarrierCount, const VkMemoryBarrier *pMemoryBarriers,
    uint32_t bufferMemoryBarrierCount, const VkBufferMemoryBarrier *pBufferMemoryBarriers,
    uint32_t imageMemoryBarrierCount, const VkImageMemoryBarrier *pImageMemoryBarriers)
{
    const VkuDeviceDispatchTable *next = cpu_next_of_recording(commandBuffer);
    if (!next)
        return;
    struct dependency below = {
        .src = srcStageMask,
        .dst = dstStageMask,
        .memory_count = memoryBarrierCount,
        .buffer_count = bufferMemoryBarrierCount,
        .image_count = imageMemoryBarrierCount,
        .memory = pMemoryBarriers,
        .buffers = pBufferMemoryBarriers,
        .images = pImageMemoryBarriers,
    };
    struct block block;
    dependency_begin(&block, &below);
    next->CmdPipelineBarrier(commandBuffer, below.src, below.dst, dependencyFlags,
                             below.memory_count, below.memory, below.buffer_count, below.buffers,
                             below.image_count, below.images);
    block_end(&block);
}

VKAPI_ATTR void VKAPI_CALL cpu_CmdWaitEvents(
    VkCommandBuffer commandBuffer, uint32_t eventCount, const VkEvent *pEvents,
    VkPipelineStageFlags srcStageMask, VkPipelineStageFlags dstStageMask,
    uint32_t memoryBarrierCount, const VkMemoryBarrier *pMemoryBarriers,
    uint32_t bufferMemoryBarrierCount, const VkBufferMemoryBarrier *pBufferMemoryBarriers,
    uint32_t imageMemoryBarrierCount, const VkImageMemoryBarrier *pImageMemoryBarriers)
{
    const VkuDeviceDispatchTable *next = cpu_next_of_recording(commandBuffer);
    if (!next)
        return;
    struct dependency below = {
        .src = srcStageMask,
        .dst = dstStageMask,
        .memory_count = memoryBarrierCount,
        .buffer_count = bufferMemoryBarrierCount,
        .image_count = imageMemoryBarrierCount,
        .memory = pMemoryBarriers,
        .buffers = pBufferMemoryBarriers,
        .images = pImageMemoryBarriers,
    };
    struct block block;
    dependency_begin(&block, &below);
    next->CmdWaitEvents(commandBuffer, eventCount, pEvents, below.src, below.dst,
                        below.memory_count, below.memory, below.buffer_count, below.buffers,
                        below.image_count, below.images);
    block_end(&block);
}

VKAPI_ATTR void VKAPI_CALL cpu_CmdSetEvent(VkCommandBuffer commandBuffer, VkEvent event,
                                           VkPipelineStageFlags stageMask)
{
    const VkuDeviceDispatchTable *next = cpu_next_of_recording(commandBuffer);
    if (!next)
        return;
    next->CmdSetEvent(commandBuffer, event, narrow_stages(stageMask));
}

VKAPI_ATTR void VKAPI_CALL cpu_CmdResetEvent(VkCommandBuffer commandBuffer, VkEvent event,
                                             VkPipelineStageFlags stageMask)
{
    const VkuDeviceDispatchTable *next = cpu_next_of_recording(commandBuffer);
    if (!next)
        return;
    next->CmdResetEvent(commandBuffer, event, narrow_stages(stageMask));
}

VKAPI_ATTR void VKAPI_CALL cpu_CmdWriteTimestamp(VkCommandBuffer commandBuffer,
                                                 VkPipelineStageFlagBits pipelineStage,
                                                 VkQueryPool queryPool, uint32_t query)
{
    const VkuDeviceDispatchTable *next = cpu_next_of_recording(commandBuffer);
    if (!next)
        return;
    next->CmdWriteTimestamp(commandBuffer, narrow_stages(pipelineStage), queryPool, query);
}

VKAPI_ATTR void VKAPI_CALL cpu_CmdWriteBufferMarkerAMD(VkCommandBuffer commandBuffer,
                                                       VkPipelineStageFlagBits pipelineStage,
                                                       VkBuffer dstBuffer, VkDeviceSize dstOffset,
                                                       uint32_t marker)
{
    const VkuDeviceDispatchTable *next = cpu_next_of_recording(commandBuffer);
    if (!next)
        return;
    next->CmdWriteBufferMarkerAMD(commandBuffer, narrow_stages(pipelineStage), dstBuffer, dstOffset,
                                  marker);
}
