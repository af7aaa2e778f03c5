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

enum { COMMANDS_MAX = 256, SIGNALS_MAX = 64 };

/* Returns whether the batch was executed; if the device hangs, it is kept for later. */
static bool execute(const VkSubmitInfo2 *info)
{
    VkCommandBuffer commands[COMMANDS_MAX];
    bool goes_on = !device_hangs();
    barriers_note_submission(info);
    for (uint32_t i = 0; i < info->commandBufferInfoCount; i++) {
        const VkCommandBuffer own = info->pCommandBufferInfos[i].commandBuffer;
        if (i < COMMANDS_MAX)
            commands[i] = own;
        goes_on = goes_on && transfers_execute(own);
    }
    if (!goes_on && device_hangs() && info->commandBufferInfoCount <= COMMANDS_MAX)
        fault_keep(info, commands, VK_NULL_HANDLE);
    for (uint32_t i = 0; goes_on && i < info->signalSemaphoreInfoCount; i++) {
        const VkSemaphoreSubmitInfo *signal = &info->pSignalSemaphoreInfos[i];
        sync_signal_semaphore(signal->semaphore, signal->value);
    }
    return goes_on;
}

static VkResult end(VkFence fence, bool goes_on)
{
    if (goes_on && !device_hangs())
        return finish(fence);
    if (device_hangs())
        fault_keep(&(VkSubmitInfo2){0}, NULL, fence);
    return loss_is_at_once() ? VK_ERROR_DEVICE_LOST : VK_SUCCESS;
}

/* The same batch in the newer form; false: it is too large for that, and cannot be kept. */
static bool execute1(const VkSubmitInfo *info)
{
    const VkTimelineSemaphoreSubmitInfo *timeline =
        chain_find(info->pNext, VK_STRUCTURE_TYPE_TIMELINE_SEMAPHORE_SUBMIT_INFO);
    VkCommandBufferSubmitInfo commands[COMMANDS_MAX];
    VkSemaphoreSubmitInfo signals[SIGNALS_MAX];
    VkSubmitInfo2 own = {.pCommandBufferInfos = commands, .pSignalSemaphoreInfos = signals};
    bool goes_on = true;
    barriers_note_old_submission(info);
    for (uint32_t i = 0; i < info->commandBufferCount; i++) {
        if (own.commandBufferInfoCount == COMMANDS_MAX) {
            goes_on = execute(&own) && goes_on;
            own.commandBufferInfoCount = 0;
        }
        commands[own.commandBufferInfoCount++] =
            (VkCommandBufferSubmitInfo){.commandBuffer = info->pCommandBuffers[i]};
    }
    for (uint32_t i = 0; timeline != NULL && timeline->pSignalSemaphoreValues != NULL &&
                         info->pSignalSemaphores != NULL && i < info->signalSemaphoreCount &&
                         i < timeline->signalSemaphoreValueCount && i < SIGNALS_MAX;
         i++)
        signals[own.signalSemaphoreInfoCount++] = (VkSemaphoreSubmitInfo){
            .semaphore = info->pSignalSemaphores[i], .value = timeline->pSignalSemaphoreValues[i]};
    return execute(&own) && goes_on;
}

/* The body of both commands. */
#define SUBMIT(execute, command_count)                                                             \
    bool goes_on = true, has_commands = false;                                                     \
    for (uint32_t i = 0; i < submitCount; i++)                                                     \
        has_commands |= pSubmits[i].command_count > 0;                                             \
    if (has_commands)                                                                              \
        fault_at_submit();                                                                         \
    if (device_is_lost())                                                                          \
        return VK_ERROR_DEVICE_LOST;                                                               \
    for (uint32_t i = 0; i < submitCount && !device_is_lost(); i++)                                \
        goes_on = execute(&pSubmits[i]) && goes_on;                                                \
    return end(fence, goes_on);

COMMAND(QueueSubmit){SUBMIT(execute1, commandBufferCount)}

COMMAND(QueueSubmit2)
{
    SUBMIT(execute, commandBufferInfoCount)
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
