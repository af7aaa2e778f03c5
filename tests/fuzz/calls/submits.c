/* SPDX-License-Identifier: Apache-2.0 */
/* Submissions, and what waits for them; nothing waits for long, as nobody else would end it. */
#include "calls.h"

enum { SUBMITTED_MAX = 4 };

/* How many of them there are. */
static uint32_t take_command_buffers(struct calls *calls, VkCommandBuffer *commands)
{
    uint32_t wanted = 1u + take(calls) % 3, count = 0;
    for (uint32_t i = 0; i < wanted; i++) {
        commands[count] = pick_commands(calls);
        count += commands[count] != NULL;
    }
    return count;
}

void call_submit(struct calls *calls)
{
    static const VkPipelineStageFlags stage = VK_PIPELINE_STAGE_ALL_COMMANDS_BIT;
    VkCommandBuffer commands[SUBMITTED_MAX];
    const uint32_t count = take_command_buffers(calls, commands);
    const uint8_t byte = take(calls);
    const VkSemaphore wait = PICK(VkSemaphore, calls, SEMAPHORES);
    const VkSemaphore signal = PICK(VkSemaphore, calls, SEMAPHORES);
    const uint64_t wait_value = take(calls), signal_value = take(calls);
    const STRUCT(VkTimelineSemaphoreSubmitInfo, values, .waitSemaphoreValueCount = 1,
                 .pWaitSemaphoreValues = &wait_value, .signalSemaphoreValueCount = 1,
                 .pSignalSemaphoreValues = &signal_value);
    const STRUCT(VkSubmitInfo, info, .pNext = byte & 8 ? NULL : &values,
                 .waitSemaphoreCount = byte & 1, .pWaitSemaphores = &wait,
                 .pWaitDstStageMask = &stage, .commandBufferCount = count,
                 .pCommandBuffers = commands, .signalSemaphoreCount = byte >> 1 & 1,
                 .pSignalSemaphores = &signal);
    const VkSubmitInfo infos[] = {info, info};
    calls->status =
        calls->vk.QueueSubmit(calls->queues[(byte >> 4) % QUEUES], byte & 128 ? 2 : 1, infos,
                              byte & 4 ? PICK(VkFence, calls, FENCES) : VK_NULL_HANDLE);
}

void call_submit2(struct calls *calls)
{
    VkCommandBuffer commands[SUBMITTED_MAX];
    VkCommandBufferSubmitInfo infos[SUBMITTED_MAX];
    const uint32_t count = take_command_buffers(calls, commands);
    const uint8_t byte = take(calls);
    for (uint32_t i = 0; i < count; i++)
        infos[i] = MAKE(VkCommandBufferSubmitInfo, .commandBuffer = commands[i]);
    const struct slot *waited = pick(calls, SEMAPHORES), *signalled = pick(calls, SEMAPHORES);
    const STRUCT(VkSemaphoreSubmitInfo, wait, .semaphore = HANDLE_OF(VkSemaphore, waited),
                 .value = take(calls));
    const STRUCT(VkSemaphoreSubmitInfo, signal, .semaphore = HANDLE_OF(VkSemaphore, signalled),
                 .value = take(calls));
    const STRUCT(VkSubmitInfo2, info, .waitSemaphoreInfoCount = byte & 1,
                 .pWaitSemaphoreInfos = &wait, .commandBufferInfoCount = count,
                 .pCommandBufferInfos = infos, .signalSemaphoreInfoCount = byte >> 1 & 1,
                 .pSignalSemaphoreInfos = &signal);
    calls->status =
        calls->vk.QueueSubmit2(calls->queues[(byte >> 4) % QUEUES], 1, &info,
                               byte & 4 ? PICK(VkFence, calls, FENCES) : VK_NULL_HANDLE);
}

/* ---- waits */

void call_wait_idle(struct calls *calls)
{
    const uint8_t byte = take(calls);
    if (byte % 4 == 0)
        calls->status = calls->vk.DeviceWaitIdle(calls->device);
    else
        calls->status = calls->vk.QueueWaitIdle(calls->queues[byte % QUEUES]);
}

void call_wait_fence(struct calls *calls)
{
    const struct slot *a = pick(calls, FENCES), *b = pick(calls, FENCES);
    const VkFence fences[] = {HANDLE_OF(VkFence, a), HANDLE_OF(VkFence, b)};
    const uint8_t byte = take(calls);
    if (byte % 2)
        calls->vk.GetFenceStatus(calls->device, fences[0]);
    else
        calls->vk.WaitForFences(calls->device, byte & 2 ? 2 : 1, fences, byte & 4, 0);
}

void call_reset_fence(struct calls *calls)
{
    const VkFence fence = PICK(VkFence, calls, FENCES);
    calls->vk.ResetFences(calls->device, 1, &fence);
}

void call_use_semaphore(struct calls *calls)
{
    const VkSemaphore semaphore = PICK(VkSemaphore, calls, SEMAPHORES);
    uint64_t value = take(calls);
    const STRUCT(VkSemaphoreSignalInfo, signal, .semaphore = semaphore, .value = value);
    const STRUCT(VkSemaphoreWaitInfo, wait, .semaphoreCount = 1, .pSemaphores = &semaphore,
                 .pValues = &value);
    const uint8_t kind = take(calls);
    if (kind % 3 == 0)
        calls->vk.SignalSemaphore(calls->device, &signal);
    else if (kind % 3 == 1)
        calls->vk.WaitSemaphores(calls->device, &wait, 0);
    else
        calls->vk.GetSemaphoreCounterValue(calls->device, semaphore, &value);
}

/* ---- fences, semaphores, events */

static void create_semaphore(struct calls *calls)
{
    const uint32_t index = take(calls) % slot_counts[SEMAPHORES];
    const STRUCT(VkSemaphoreTypeCreateInfo, type, .semaphoreType = VK_SEMAPHORE_TYPE_TIMELINE);
    const STRUCT(VkSemaphoreCreateInfo, info, .pNext = index ? &type : NULL);
    CREATE(calls, &calls->slots[SEMAPHORES][index], 0, CreateSemaphore, &info);
}

void call_create_sync(struct calls *calls)
{
    const uint8_t kind = take(calls);
    const STRUCT(VkFenceCreateInfo, fence_info, .flags = kind >> 2 & 1);
    const STRUCT(VkEventCreateInfo, event_info);
    VkFence fence;
    VkEvent event;
    if (kind % 4 == 0)
        create_semaphore(calls);
    else if (kind % 4 == 1 &&
             calls->vk.CreateEvent(calls->device, &event_info, NULL, &event) == VK_SUCCESS)
        *pick(calls, EVENTS) = (struct slot){(uint64_t)(uintptr_t)event, true};
    else if (kind % 4 > 1 &&
             calls->vk.CreateFence(calls->device, &fence_info, NULL, &fence) == VK_SUCCESS)
        *pick(calls, FENCES) = (struct slot){(uint64_t)(uintptr_t)fence, true};
}

void call_destroy_sync(struct calls *calls)
{
    const uint8_t kind = take(calls);
    if (kind % 3 == 0)
        calls->vk.DestroySemaphore(calls->device, PICK(VkSemaphore, calls, SEMAPHORES), NULL);
    else if (kind % 3 == 1)
        calls->vk.DestroyEvent(calls->device, PICK(VkEvent, calls, EVENTS), NULL);
    else
        calls->vk.DestroyFence(calls->device, PICK(VkFence, calls, FENCES), NULL);
}
