/* SPDX-License-Identifier: Apache-2.0 */
/* Lowers barriers and submissions to the newer version of their commands. */
#include "layer/intercepts/lower.h"

#include "src/base/chain.h"

/* ---- barriers */

const VkDependencyInfo *lower_dependencies(struct block *block, uint32_t count,
                                           VkPipelineStageFlags src, VkPipelineStageFlags dst,
                                           uint32_t memory_count, const VkMemoryBarrier *memory,
                                           uint32_t buffer_count,
                                           const VkBufferMemoryBarrier *buffers)
{
    if (!block_begin(block, block_size(count, sizeof(VkDependencyInfo)) +
                                block_size(1, sizeof(VkMemoryBarrier2)) +
                                block_size(buffer_count, sizeof(VkBufferMemoryBarrier2))))
        return NULL;
    VkDependencyInfo *infos = block_take(block, count, sizeof(*infos));
    VkMemoryBarrier2 *joined = block_take(block, 1, sizeof(*joined));
    VkBufferMemoryBarrier2 *lowered = block_take(block, buffer_count, sizeof(*lowered));
    *joined = (VkMemoryBarrier2){
        .sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER_2, .srcStageMask = src, .dstStageMask = dst};
    for (uint32_t i = 0; i < memory_count; i++) {
        joined->srcAccessMask |= memory[i].srcAccessMask;
        joined->dstAccessMask |= memory[i].dstAccessMask;
    }
    for (uint32_t i = 0; i < buffer_count; i++) {
        const VkBufferMemoryBarrier *from = &buffers[i];
        lowered[i] = (VkBufferMemoryBarrier2){.sType = VK_STRUCTURE_TYPE_BUFFER_MEMORY_BARRIER_2,
                                              .pNext = from->pNext,
                                              .srcStageMask = src,
                                              .srcAccessMask = from->srcAccessMask,
                                              .dstStageMask = dst,
                                              .dstAccessMask = from->dstAccessMask,
                                              .srcQueueFamilyIndex = from->srcQueueFamilyIndex,
                                              .dstQueueFamilyIndex = from->dstQueueFamilyIndex,
                                              .buffer = from->buffer,
                                              .offset = from->offset,
                                              .size = from->size};
    }
    for (uint32_t i = 0; i < count; i++)
        infos[i] = (VkDependencyInfo){.sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO,
                                      .memoryBarrierCount = 1,
                                      .pMemoryBarriers = joined,
                                      .bufferMemoryBarrierCount = buffer_count,
                                      .pBufferMemoryBarriers = lowered};
    return infos;
}

/* ---- submissions */

uint64_t lower_value(const void *chain, enum semaphore_use use, uint32_t index)
{
    const VkTimelineSemaphoreSubmitInfo *timeline =
        chain_find(chain, VK_STRUCTURE_TYPE_TIMELINE_SEMAPHORE_SUBMIT_INFO);
    if (!timeline)
        return 0;
    const uint64_t *values =
        use == WAIT_OF_BATCH ? timeline->pWaitSemaphoreValues : timeline->pSignalSemaphoreValues;
    const uint32_t count = use == WAIT_OF_BATCH ? timeline->waitSemaphoreValueCount
                                                : timeline->signalSemaphoreValueCount;
    return values && index < count ? values[index] : 0;
}

static size_t size_of_submit(const VkSubmitInfo *submit)
{
    return block_size(submit->waitSemaphoreCount, sizeof(VkSemaphoreSubmitInfo)) +
           block_size(submit->commandBufferCount, sizeof(VkCommandBufferSubmitInfo)) +
           block_size(submit->signalSemaphoreCount, sizeof(VkSemaphoreSubmitInfo));
}

/* Without a VkDeviceGroupSubmitInfo, the first device of a group executes all. */
static VkSubmitInfo2 lower_submit(struct block *block, const VkSubmitInfo *from)
{
    static const VkDeviceGroupSubmitInfo none = {0};
    const VkDeviceGroupSubmitInfo *group =
        chain_find(from->pNext, VK_STRUCTURE_TYPE_DEVICE_GROUP_SUBMIT_INFO);
    VkSemaphoreSubmitInfo *waits = block_take(block, from->waitSemaphoreCount, sizeof(*waits));
    VkCommandBufferSubmitInfo *commands =
        block_take(block, from->commandBufferCount, sizeof(*commands));
    VkSemaphoreSubmitInfo *signals =
        block_take(block, from->signalSemaphoreCount, sizeof(*signals));
    group = group ? group : &none;
    for (uint32_t i = 0; i < from->waitSemaphoreCount; i++)
        waits[i] = (VkSemaphoreSubmitInfo){
            .sType = VK_STRUCTURE_TYPE_SEMAPHORE_SUBMIT_INFO,
            .semaphore = from->pWaitSemaphores[i],
            .value = lower_value(from->pNext, WAIT_OF_BATCH, i),
            .stageMask = from->pWaitDstStageMask[i],
            .deviceIndex =
                i < group->waitSemaphoreCount ? group->pWaitSemaphoreDeviceIndices[i] : 0};
    for (uint32_t i = 0; i < from->commandBufferCount; i++)
        commands[i] = (VkCommandBufferSubmitInfo){
            .sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_SUBMIT_INFO,
            .commandBuffer = from->pCommandBuffers[i],
            .deviceMask = i < group->commandBufferCount ? group->pCommandBufferDeviceMasks[i] : 1};
    for (uint32_t i = 0; i < from->signalSemaphoreCount; i++)
        signals[i] = (VkSemaphoreSubmitInfo){
            .sType = VK_STRUCTURE_TYPE_SEMAPHORE_SUBMIT_INFO,
            .semaphore = from->pSignalSemaphores[i],
            .value = lower_value(from->pNext, SIGNAL_OF_BATCH, i),
            .stageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT,
            .deviceIndex =
                i < group->signalSemaphoreCount ? group->pSignalSemaphoreDeviceIndices[i] : 0};
    return (VkSubmitInfo2){
        .sType = VK_STRUCTURE_TYPE_SUBMIT_INFO_2,
        .pNext = from->pNext,
        .waitSemaphoreInfoCount = from->waitSemaphoreCount,
        .pWaitSemaphoreInfos = waits,
        .commandBufferInfoCount = from->commandBufferCount,
        .pCommandBufferInfos = commands,
        .signalSemaphoreInfoCount = from->signalSemaphoreCount,
        .pSignalSemaphoreInfos = signals,
    };
}

const VkSubmitInfo2 *lower_submits(struct block *block, uint32_t count, const VkSubmitInfo *submits)
{
    size_t size = block_size(count, sizeof(VkSubmitInfo2));
    for (uint32_t i = 0; i < count; i++)
        size += size_of_submit(&submits[i]);
    if (!block_begin(block, size))
        return NULL;
    VkSubmitInfo2 *lowered = block_take(block, count, sizeof(*lowered));
    for (uint32_t i = 0; i < count; i++)
        lowered[i] = lower_submit(block, &submits[i]);
    return lowered;
}
