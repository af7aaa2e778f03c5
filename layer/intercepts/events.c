/* SPDX-License-Identifier: Apache-2.0 */
/* Intercepts of events. The host sets and resets them directly; commands that set, reset and wait
 * for them are recorded in journals. */
#include "src/state/commands/events.h"

#include "layer/execution/hazards/checks.h"
#include "layer/intercepts/intercepts.h"
#include "layer/intercepts/journal_access.h"
#include "layer/postmortem/loss.h"
#include "src/check/replay/replay.h"

/* ---- the host */

VKAPI_ATTR VkResult VKAPI_CALL assay_CreateEvent(VkDevice device,
                                                 const VkEventCreateInfo *pCreateInfo,
                                                 const VkAllocationCallbacks *pAllocator,
                                                 VkEvent *pEvent)
{
    struct layer_device *state = layer_find_device(device);
    VkResult result = state->vk.CreateEvent(device, pCreateInfo, pAllocator, pEvent);
    if (result == VK_SUCCESS && state->order)
        events_add(state->events, *pEvent, pCreateInfo->flags & VK_EVENT_CREATE_DEVICE_ONLY_BIT);
    return result;
}

VKAPI_ATTR void VKAPI_CALL assay_DestroyEvent(VkDevice device, VkEvent event,
                                              const VkAllocationCallbacks *pAllocator)
{
    struct layer_device *state = layer_find_device(device);
    events_remove(state->events, event);
    hazard_checks_forget(state->hazard_checks, EVENT_DESTROYED, (uint64_t)(uintptr_t)event);
    state->vk.DestroyEvent(device, event, pAllocator);
}

VKAPI_ATTR VkResult VKAPI_CALL assay_SetEvent(VkDevice device, VkEvent event)
{
    struct layer_device *state = layer_find_device(device);
    VkResult result = state->vk.SetEvent(device, event);
    if (result == VK_SUCCESS)
        events_set(state->events, event);
    return result;
}

VKAPI_ATTR VkResult VKAPI_CALL assay_ResetEvent(VkDevice device, VkEvent event)
{
    struct layer_device *state = layer_find_device(device);
    events_reset(state->events, event);
    return state->vk.ResetEvent(device, event);
}

/* The commands in front of one that has set the event may have executed. */
VKAPI_ATTR VkResult VKAPI_CALL assay_GetEventStatus(VkDevice device, VkEvent event)
{
    struct layer_device *state = layer_find_device(device);
    VkResult result = state->vk.GetEventStatus(device, event);
    if (result == VK_EVENT_SET)
        execution_order_observe_unknown(state->order);
    return postmortem_see(state, result);
}

/* ---- command buffers */

static void note(const struct layer_device *device, VkCommandBuffer command_buffer,
                 enum journal_kind kind, VkEvent event)
{
    struct command_buffer *recording = layer_find_recording(device, command_buffer);
    if (!recording)
        return;
    journal_begin_call(recording->journal);
    journal_add(recording->journal,
                &(struct journal_entry){.kind = kind, .dst = (uint64_t)(uintptr_t)event});
    recording->journal->has_events = true;
    replay_keep(recording);
}

static void note_waits(const struct layer_device *device, VkCommandBuffer command_buffer,
                       uint32_t count, const VkEvent *events)
{
    const struct command_buffer *recording = layer_find_recording(device, command_buffer);
    for (uint32_t i = 0; recording && i < count; i++)
        if (events_may_be_open(device->events, events[i], recording->journal))
            note(device, command_buffer, JOURNAL_WAIT_EVENT, events[i]);
}

VKAPI_ATTR void VKAPI_CALL assay_CmdSetEvent(VkCommandBuffer commandBuffer, VkEvent event,
                                             VkPipelineStageFlags stageMask)
{
    struct layer_device *device = layer_find_recording_device(commandBuffer);
    if (!device)
        return;
    note(device, commandBuffer, JOURNAL_SET_EVENT, event);
    device->vk.CmdSetEvent(commandBuffer, event, stageMask);
}

VKAPI_ATTR void VKAPI_CALL assay_CmdResetEvent(VkCommandBuffer commandBuffer, VkEvent event,
                                               VkPipelineStageFlags stageMask)
{
    struct layer_device *device = layer_find_recording_device(commandBuffer);
    if (!device)
        return;
    note(device, commandBuffer, JOURNAL_RESET_EVENT, event);
    device->vk.CmdResetEvent(commandBuffer, event, stageMask);
}

VKAPI_ATTR void VKAPI_CALL assay_CmdWaitEvents(
    VkCommandBuffer commandBuffer, uint32_t eventCount, const VkEvent *pEvents,
    VkPipelineStageFlags srcStageMask, VkPipelineStageFlags dstStageMask,
    uint32_t memoryBarrierCount, const VkMemoryBarrier *pMemoryBarriers,
    uint32_t bufferMemoryBarrierCount, const VkBufferMemoryBarrier *pBufferMemoryBarriers,
    uint32_t imageMemoryBarrierCount, const VkImageMemoryBarrier *pImageMemoryBarriers)
{
    struct layer_device *device = layer_find_recording_device(commandBuffer);
    if (!device)
        return;
    note_waits(device, commandBuffer, eventCount, pEvents);
    device->vk.CmdWaitEvents(commandBuffer, eventCount, pEvents, srcStageMask, dstStageMask,
                             memoryBarrierCount, pMemoryBarriers, bufferMemoryBarrierCount,
                             pBufferMemoryBarriers, imageMemoryBarrierCount, pImageMemoryBarriers);
}

/* A command and its alias differ only in which command of the next layer they call. */
#define DEFINE_SET_EVENT_2(name)                                                                   \
    VKAPI_ATTR void VKAPI_CALL assay_##name(VkCommandBuffer commandBuffer, VkEvent event,          \
                                            const VkDependencyInfo *pDependencyInfo)               \
    {                                                                                              \
        struct layer_device *device = layer_find_recording_device(commandBuffer);                  \
        if (!device)                                                                               \
            return;                                                                                \
        note(device, commandBuffer, JOURNAL_SET_EVENT, event);                                     \
        device->vk.name(commandBuffer, event, pDependencyInfo);                                    \
    }

#define DEFINE_RESET_EVENT_2(name)                                                                 \
    VKAPI_ATTR void VKAPI_CALL assay_##name(VkCommandBuffer commandBuffer, VkEvent event,          \
                                            VkPipelineStageFlags2 stageMask)                       \
    {                                                                                              \
        struct layer_device *device = layer_find_recording_device(commandBuffer);                  \
        if (!device)                                                                               \
            return;                                                                                \
        note(device, commandBuffer, JOURNAL_RESET_EVENT, event);                                   \
        device->vk.name(commandBuffer, event, stageMask);                                          \
    }

#define DEFINE_WAIT_EVENTS_2(name)                                                                 \
    VKAPI_ATTR void VKAPI_CALL assay_##name(VkCommandBuffer commandBuffer, uint32_t eventCount,    \
                                            const VkEvent *pEvents,                                \
                                            const VkDependencyInfo *pDependencyInfos)              \
    {                                                                                              \
        struct layer_device *device = layer_find_recording_device(commandBuffer);                  \
        if (!device)                                                                               \
            return;                                                                                \
        note_waits(device, commandBuffer, eventCount, pEvents);                                    \
        device->vk.name(commandBuffer, eventCount, pEvents, pDependencyInfos);                     \
    }

DEFINE_SET_EVENT_2(CmdSetEvent2)
DEFINE_SET_EVENT_2(CmdSetEvent2KHR)
DEFINE_RESET_EVENT_2(CmdResetEvent2)
DEFINE_RESET_EVENT_2(CmdResetEvent2KHR)
DEFINE_WAIT_EVENTS_2(CmdWaitEvents2)
DEFINE_WAIT_EVENTS_2(CmdWaitEvents2KHR)
