/* SPDX-License-Identifier: Apache-2.0 */
/* Backend cpu: submissions. They are copied and translated if semaphores wait or signal
 * at stages of ray tracing. Others go down unchanged. */
#include "layer/cpu/driver/block.h"
#include "layer/cpu/driver/masks.h"
#include "observers.h"

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

VkResult cpu_submit(PFN_vkQueueSubmit down, VkQueue queue, uint32_t count,
                    const VkSubmitInfo *submits, VkFence fence)
{
    size_t size = block_size(count, sizeof(VkSubmitInfo));
    bool traces = false;
    for (uint32_t i = 0; i < count; i++) {
        traces |= waits_trace(&submits[i]);
        size += block_size(submits[i].waitSemaphoreCount, sizeof(VkPipelineStageFlags));
    }
    if (!traces)
        return down(queue, count, submits, fence);
    struct block block;
    if (!block_begin(&block, size))
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    VkSubmitInfo *below = block_copy(&block, submits, count, sizeof(*below));
    for (uint32_t i = 0; i < count; i++)
        translate_waits(&block, &below[i]);
    VkResult result = down(queue, count, below, fence);
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

VkResult cpu_submit_2(PFN_vkQueueSubmit2 down, VkQueue queue, uint32_t count,
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
        return down(queue, count, submits, fence);
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
    VkResult result = down(queue, count, below, fence);
    block_end(&block);
    return result;
}
