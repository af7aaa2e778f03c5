/* SPDX-License-Identifier: Apache-2.0 */
/* Commands of backend cpu: submissions. They are copied and translated if semaphores wait or signal
 * at stages of ray tracing. Others go down unchanged. */
#include "layer/cpu/driver/block.h"
#include "layer/cpu/driver/masks.h"
#include "layer/cpu/overlay.h"
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

VKAPI_ATTR VkResult VKAPI_CALL cpu_QueueSubmit(VkQueue queue, uint32_t submitCount,
                                               const VkSubmitInfo *pSubmits, VkFence fence)
{
    PFN_vkQueueSubmit submit = cpu_next(queue)->QueueSubmit;
    size_t size = block_size(submitCount, sizeof(VkSubmitInfo));
    bool traces = false;
    for (uint32_t i = 0; i < submitCount; i++) {
        traces |= waits_trace(&pSubmits[i]);
        size += block_size(pSubmits[i].waitSemaphoreCount, sizeof(VkPipelineStageFlags));
    }
    if (!traces)
        return submit(queue, submitCount, pSubmits, fence);
    struct block block;
    if (!block_begin(&block, size))
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    VkSubmitInfo *below = block_copy(&block, pSubmits, submitCount, sizeof(*below));
    for (uint32_t i = 0; i < submitCount; i++)
        translate_waits(&block, &below[i]);
    VkResult result = submit(queue, submitCount, below, fence);
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

static VkResult submit2(PFN_vkQueueSubmit2 submit, VkQueue queue, uint32_t count,
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

VKAPI_ATTR VkResult VKAPI_CALL cpu_QueueSubmit2(VkQueue queue, uint32_t submitCount,
                                                const VkSubmitInfo2 *pSubmits, VkFence fence)
{
    return submit2(cpu_next(queue)->QueueSubmit2, queue, submitCount, pSubmits, fence);
}

VKAPI_ATTR VkResult VKAPI_CALL cpu_QueueSubmit2KHR(VkQueue queue, uint32_t submitCount,
                                                   const VkSubmitInfo2 *pSubmits, VkFence fence)
{
    return submit2(cpu_next(queue)->QueueSubmit2KHR, queue, submitCount, pSubmits, fence);
}
