/* SPDX-License-Identifier: Apache-2.0 */
/* Submissions: execute and complete at once, and signal what they are to signal. */
#include "internal.h"

/* values may be shorter than semaphores, or missing: binary semaphores have none. */
static void signal_semaphores(uint32_t count, const VkSemaphore *semaphores, const void *pNext)
{
    const VkTimelineSemaphoreSubmitInfo *timeline =
        chain_find(pNext, VK_STRUCTURE_TYPE_TIMELINE_SEMAPHORE_SUBMIT_INFO);
    if (timeline == NULL || timeline->pSignalSemaphoreValues == NULL || semaphores == NULL)
        return;
    for (uint32_t i = 0; i < count && i < timeline->signalSemaphoreValueCount; i++)
        sync_signal_semaphore(semaphores[i], timeline->pSignalSemaphoreValues[i]);
}

static VkResult finish(VkFence fence)
{
    if (fence != VK_NULL_HANDLE)
        sync_signal_fence(fence);
    sync_wake();
    return VK_SUCCESS;
}

COMMAND(QueueSubmit)
{
    if (device_is_lost())
        return VK_ERROR_DEVICE_LOST;
    for (uint32_t i = 0; i < submitCount; i++) {
        for (uint32_t j = 0; j < pSubmits[i].commandBufferCount; j++)
            transfers_execute(pSubmits[i].pCommandBuffers[j]);
        signal_semaphores(pSubmits[i].signalSemaphoreCount, pSubmits[i].pSignalSemaphores,
                          pSubmits[i].pNext);
    }
    return finish(fence);
}

COMMAND(QueueSubmit2)
{
    if (device_is_lost())
        return VK_ERROR_DEVICE_LOST;
    for (uint32_t i = 0; i < submitCount; i++) {
        for (uint32_t j = 0; j < pSubmits[i].commandBufferInfoCount; j++)
            transfers_execute(pSubmits[i].pCommandBufferInfos[j].commandBuffer);
        for (uint32_t j = 0; j < pSubmits[i].signalSemaphoreInfoCount; j++) {
            const VkSemaphoreSubmitInfo *info = &pSubmits[i].pSignalSemaphoreInfos[j];
            sync_signal_semaphore(info->semaphore, info->value);
        }
    }
    return finish(fence);
}

static void bind_sparse(const VkSparseBufferMemoryBindInfo *info)
{
    struct object *buffer = FIND(BUFFER, info->buffer);
    for (uint32_t i = 0; buffer != NULL && i < info->bindCount; i++) {
        const VkSparseMemoryBind *bind = &info->pBinds[i];
        buffer_bind(buffer, &(struct binding){.offset = bind->resourceOffset,
                                              .size = bind->size,
                                              .memory = RAW(bind->memory),
                                              .memory_offset = bind->memoryOffset});
    }
}

COMMAND(QueueBindSparse)
{
    if (device_is_lost())
        return VK_ERROR_DEVICE_LOST;
    for (uint32_t i = 0; i < bindInfoCount; i++) {
        for (uint32_t j = 0; j < pBindInfo[i].bufferBindCount; j++)
            bind_sparse(&pBindInfo[i].pBufferBinds[j]);
        signal_semaphores(pBindInfo[i].signalSemaphoreCount, pBindInfo[i].pSignalSemaphores,
                          pBindInfo[i].pNext);
    }
    return finish(fence);
}

COMMAND(QueueWaitIdle)
{
    return device_is_lost() ? VK_ERROR_DEVICE_LOST : VK_SUCCESS;
}

COMMAND(DeviceWaitIdle)
{
    return device_is_lost() ? VK_ERROR_DEVICE_LOST : VK_SUCCESS;
}
