/* SPDX-License-Identifier: Apache-2.0 */
/* Copies of submissions, where semaphores operate at stages of ray tracing. */
#include "cpu/submit_infos.h"

#include "cpu/block.h"
#include "cpu/masks.h"

/* ---- vkQueueSubmit */

static bool waits_trace(const VkSubmitInfo *submit)
{
    bool found = false;
    for (uint32_t i = 0; i < submit->waitSemaphoreCount && !found; i++)
        found = stages_trace(submit->pWaitDstStageMask[i]);
    return found;
}

static void translate_waits(struct block *block, VkSubmitInfo *submit)
{
    VkPipelineStageFlags *stages =
        block_copy(block, submit->pWaitDstStageMask, submit->waitSemaphoreCount, sizeof(*stages));
    for (uint32_t i = 0; i < submit->waitSemaphoreCount; i++)
        stages[i] = (VkPipelineStageFlags)stages_below(stages[i]);
    submit->pWaitDstStageMask = stages;
}

VkResult cpu_submit_below(PFN_vkQueueSubmit submit, VkQueue queue, uint32_t count,
                          const VkSubmitInfo *submits, VkFence fence)
{
    size_t size = block_size(count, sizeof(VkSubmitInfo));
    bool traces = false;
    for (uint32_t i = 0; i < count; i++) {
        traces |= waits_trace(&submits[i]);
        size += block_size(submits[i].waitSemaphoreCount, sizeof(VkPipelineStageFlags));
    }
    if (!traces)
        return submit(queue, count, submits, fence);
    struct block block;
    if (!block_begin(&block, size))
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    VkSubmitInfo *below = block_copy(&block, submits, count, sizeof(*below));
    for (uint32_t i = 0; i < count; i++)
        translate_waits(&block, &below[i]);
    VkResult result = submit(queue, count, below, fence);
    block_end(&block);
    return result;
}

/* ---- vkQueueSubmit2 */

static bool semaphores_trace(uint32_t count, const VkSemaphoreSubmitInfo *semaphores)
{
    bool found = false;
    for (uint32_t i = 0; i < count && !found; i++)
        found = stages_trace(semaphores[i].stageMask);
    return found;
}

static const VkSemaphoreSubmitInfo *translate_semaphores(struct block *block, uint32_t count,
                                                         const VkSemaphoreSubmitInfo *semaphores)
{
    VkSemaphoreSubmitInfo *below = block_copy(block, semaphores, count, sizeof(*below));
    for (uint32_t i = 0; i < count; i++)
        below[i].stageMask = stages_below(below[i].stageMask);
    return below;
}

VkResult cpu_submit2_below(PFN_vkQueueSubmit2 submit, VkQueue queue, uint32_t count,
                           const VkSubmitInfo2 *submits, VkFence fence)
{
    size_t size = block_size(count, sizeof(VkSubmitInfo2));
    bool traces = false;
    for (uint32_t i = 0; i < count; i++) {
        const VkSubmitInfo2 *info = &submits[i];
        traces |= semaphores_trace(info->waitSemaphoreInfoCount, info->pWaitSemaphoreInfos) ||
                  semaphores_trace(info->signalSemaphoreInfoCount, info->pSignalSemaphoreInfos);
        size += block_size(info->waitSemaphoreInfoCount, sizeof(VkSemaphoreSubmitInfo)) +
                block_size(info->signalSemaphoreInfoCount, sizeof(VkSemaphoreSubmitInfo));
    }
    if (!traces)
        return submit(queue, count, submits, fence);
    struct block block;
    if (!block_begin(&block, size))
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    VkSubmitInfo2 *below = block_copy(&block, submits, count, sizeof(*below));
    for (uint32_t i = 0; i < count; i++) {
        below[i].pWaitSemaphoreInfos = translate_semaphores(&block, below[i].waitSemaphoreInfoCount,
                                                            below[i].pWaitSemaphoreInfos);
        below[i].pSignalSemaphoreInfos = translate_semaphores(
            &block, below[i].signalSemaphoreInfoCount, below[i].pSignalSemaphoreInfos);
    }
    VkResult result = submit(queue, count, below, fence);
    block_end(&block);
    return result;
}
