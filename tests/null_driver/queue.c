/* SPDX-License-Identifier: Apache-2.0 */
/* Submissions: execute and complete at once, and signal what they are to signal. */
#include "internal.h"

/* The value that a signal gives a semaphore; 0 of binary ones. */
static uint64_t signal_value(const void *pNext, uint32_t i)
{
    const VkTimelineSemaphoreSubmitInfo *timeline =
        chain_find(pNext, VK_STRUCTURE_TYPE_TIMELINE_SEMAPHORE_SUBMIT_INFO);
    const bool has_value = timeline != NULL && timeline->pSignalSemaphoreValues != NULL &&
                           i < timeline->signalSemaphoreValueCount;
    return has_value ? timeline->pSignalSemaphoreValues[i] : 0;
}

static VkResult finish(VkFence fence)
{
    sync_signal(RAW(fence), VK_OBJECT_TYPE_FENCE, 1);
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
        sync_signal(RAW(signal->semaphore), VK_OBJECT_TYPE_SEMAPHORE, signal->value);
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
    for (uint32_t i = 0;
         info->pSignalSemaphores != NULL && i < info->signalSemaphoreCount && i < SIGNALS_MAX; i++)
        signals[own.signalSemaphoreInfoCount++] = (VkSemaphoreSubmitInfo){
            .semaphore = info->pSignalSemaphores[i], .value = signal_value(info->pNext, i)};
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
        for (uint32_t j = 0;
             pBindInfo[i].pSignalSemaphores != NULL && j < pBindInfo[i].signalSemaphoreCount; j++)
            sync_signal(RAW(pBindInfo[i].pSignalSemaphores[j]), VK_OBJECT_TYPE_SEMAPHORE,
                        signal_value(pBindInfo[i].pNext, j));
    }
    return finish(fence);
}
