/* SPDX-License-Identifier: Apache-2.0 */
/* Observes events. The host sets and resets them directly; commands that set, reset and wait
 * for them are recorded in journals. */
#include "src/state/commands/events.h"

#include "layer/execution/hazards/checks.h"
#include "layer/intercepts/journal_access.h"
#include "observers.h"
#include "src/check/replay/replay.h"

/* ---- the host */

void note_event(struct layer_device *device, VkEvent event, const VkEventCreateInfo *info)
{
    if (device->order)
        events_add(device->events, event, info->flags & VK_EVENT_CREATE_DEVICE_ONLY_BIT);
}

void forget_event(struct layer_device *device, VkEvent event)
{
    events_remove(device->events, event);
    hazard_checks_forget(device->hazard_checks, EVENT_DESTROYED, (uint64_t)(uintptr_t)event);
}

void set_event(struct layer_device *device, VkEvent event)
{
    events_set(device->events, event);
}

void reset_event(struct layer_device *device, VkEvent event)
{
    events_reset(device->events, event);
}

/* The commands in front of one that has set the event may have executed. */
void observe_event(struct layer_device *device, VkResult result)
{
    if (result == VK_EVENT_SET)
        execution_order_observe_unknown(device->order);
}

/* ---- command buffers */

void note_event_command(struct layer_device *device, VkCommandBuffer command_buffer,
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

void note_event_waits(struct layer_device *device, VkCommandBuffer command_buffer, uint32_t count,
                      const VkEvent *events)
{
    const struct command_buffer *recording = layer_find_recording(device, command_buffer);
    for (uint32_t i = 0; recording && i < count; i++)
        if (events_may_be_open(device->events, events[i], recording->journal))
            note_event_command(device, command_buffer, JOURNAL_WAIT_EVENT, events[i]);
}
