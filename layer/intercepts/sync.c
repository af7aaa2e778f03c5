/* SPDX-License-Identifier: Apache-2.0 */
/* Observes semaphores, fences and events: creation, signals by the host, and completions that the
 * host observes. */
#include "layer/postmortem/postmortem.h"

#include "layer/execution/query_writes.h"
#include "layer/hazards/executed/checks.h"
#include "layer/intercepts/intercepts.h"
#include "layer/snapshots/snapshots.h"
#include "observers.h"
#include "src/base/chain.h"
#include "src/check/replay/replay.h"
#include "src/state/commands/events.h"

/* Called when the host may have observed a completion, and by each observer here as its last step.
 * Backend cpu writes results when it plays a batch, which another thread may be about to do. */
static void end_observation(const struct layer_device *device)
{
    if (device->cpu)
        execution_order_await_observed(device->order);
    execution_order_deliver(device->order);
}

/* ---- semaphores */

void note_semaphore(struct layer_device *device, VkSemaphore semaphore,
                    const VkSemaphoreCreateInfo *info)
{
    const VkSemaphoreTypeCreateInfo *type =
        chain_find(info->pNext, VK_STRUCTURE_TYPE_SEMAPHORE_TYPE_CREATE_INFO);
    const VkExportSemaphoreCreateInfo *export =
        chain_find(info->pNext, VK_STRUCTURE_TYPE_EXPORT_SEMAPHORE_CREATE_INFO);
    execution_order_add_semaphore(device->order, semaphore,
                                  type ? type->semaphoreType : VK_SEMAPHORE_TYPE_BINARY,
                                  type ? type->initialValue : 0, export && export->handleTypes);
}

void forget_semaphore(struct layer_device *device, VkSemaphore semaphore)
{
    if (semaphore)
        execution_order_remove_semaphore(device->order, semaphore);
}

/* From now on others may signal the semaphore, too: those with whom it is shared, or the driver. */
void share_semaphore(struct layer_device *device, VkSemaphore semaphore)
{
    execution_order_set_semaphore_foreign(device->order, semaphore);
}

struct submission *begin_host_signal(struct layer_device *device, const VkSemaphoreSignalInfo *info)
{
    struct submission *submission =
        submission_begin(device->order, SUBMIT_HOST_SIGNAL, VK_NULL_HANDLE);
    submission_add_batch(submission);
    submission_add_signal(submission, info->semaphore, info->value, SCOPE_ALL);
    submission_prepare(submission);
    return submission;
}

void end_host_signal(struct submission *submission, VkResult result)
{
    submission_finish(submission, result);
}

/* An application that passes timeout 0 does not wait. */
static void note_timeout(struct layer_device *device, uint64_t timeout, VkResult result)
{
    if (result == VK_TIMEOUT && timeout)
        execution_order_note_timeout(device->order, timeout);
}

/* A wait for any of several semaphores does not show which one has reached its value. */
void observe_semaphores(struct layer_device *device, const VkSemaphoreWaitInfo *info,
                        uint64_t timeout, VkResult result)
{
    note_timeout(device, timeout, result);
    bool any = (info->flags & VK_SEMAPHORE_WAIT_ANY_BIT) && info->semaphoreCount > 1;
    for (uint32_t i = 0; result == VK_SUCCESS && !any && i < info->semaphoreCount; i++)
        execution_order_observe_semaphore(device->order, info->pSemaphores[i], info->pValues[i],
                                          false);
    if (result == VK_SUCCESS && any)
        execution_order_observe_any_semaphore(device->order, info);
    end_observation(device);
}

void observe_value(struct layer_device *device, VkSemaphore semaphore, uint64_t *value,
                   VkResult result)
{
    if (result == VK_SUCCESS)
        execution_order_observe_semaphore(device->order, semaphore, *value, true);
    end_observation(device);
}

/* ---- fences */

void note_fence(struct layer_device *device, VkFence fence, const VkFenceCreateInfo *info)
{
    const VkExportFenceCreateInfo *export =
        chain_find(info->pNext, VK_STRUCTURE_TYPE_EXPORT_FENCE_CREATE_INFO);
    execution_order_add_fence(device->order, fence, export && export->handleTypes,
                              info->flags & VK_FENCE_CREATE_SIGNALED_BIT);
}

void forget_fence(struct layer_device *device, VkFence fence)
{
    if (fence)
        execution_order_remove_fence(device->order, fence);
}

/* As share_semaphore(). */
void share_fence(struct layer_device *device, VkFence fence)
{
    execution_order_set_fence_foreign(device->order, fence);
}

void note_fence_resets(struct layer_device *device, uint32_t count, const VkFence *fences)
{
    for (uint32_t i = 0; i < count; i++)
        execution_order_reset_fence(device->order, fences[i]);
}

void observe_fence(struct layer_device *device, VkFence fence, VkResult result)
{
    if (result == VK_SUCCESS)
        execution_order_observe_fence(device->order, fence);
    end_observation(device);
}

void observe_fences(struct layer_device *device, uint32_t count, const VkFence *fences,
                    VkBool32 all, uint64_t timeout, VkResult result)
{
    note_timeout(device, timeout, result);
    bool all_are_known = all || count == 1;
    for (uint32_t i = 0; result == VK_SUCCESS && all_are_known && i < count; i++)
        execution_order_observe_fence(device->order, fences[i]);
    if (result == VK_SUCCESS && !all_are_known)
        execution_order_observe_any_fence(device->order, count, fences);
    end_observation(device);
}

/* ---- waiting for idle */

static struct idle_wait begin_wait(struct layer_device *device, VkQueue queue)
{
    struct idle_wait wait;
    execution_order_start_idle(device->order, queue, &wait);
    hang_wait_before_idle(device, queue);
    return wait;
}

struct idle_wait begin_queue_wait(struct layer_device *device, VkQueue queue)
{
    return begin_wait(device, queue);
}

struct idle_wait begin_device_wait(struct layer_device *device)
{
    return begin_wait(device, VK_NULL_HANDLE);
}

void observe_idle(struct layer_device *device, struct idle_wait *wait, VkResult result)
{
    if (result == VK_SUCCESS)
        execution_order_observe_idle(device->order, wait);
    end_observation(device);
}

/* ---- Events. The host sets and resets them directly; commands that set, reset and wait for them
 * are recorded in journals. */

void note_event(struct layer_device *device, VkEvent event, const VkEventCreateInfo *info)
{
    if (device->order)
        events_add(device->events, event, info->flags & VK_EVENT_CREATE_DEVICE_ONLY_BIT);
}

void forget_event(struct layer_device *device, VkEvent event)
{
    events_remove(device->events, event);
    query_writes_forget_event(device->query_writes, event);
    hazard_checks_forget(device->hazard_checks, EVENT_DESTROYED, handle_number(event));
}

void set_event(struct layer_device *device, VkEvent event)
{
    events_set(device->events, event);
}

void reset_event(struct layer_device *device, VkEvent event)
{
    events_reset(device->events, event);
}

/* The batch that has set the event may have executed. */
void observe_event(struct layer_device *device, VkEvent event, VkResult result)
{
    struct execution_clock clock = {0};
    if (result != VK_EVENT_SET)
        return;
    const bool is_known = events_is_set_by_host(device->events, event) ||
                          query_writes_find_event(device->query_writes, event, &clock);
    execution_order_observe_unknown(device->order, is_known ? &clock : NULL);
}

void note_event_command(struct layer_device *device, VkCommandBuffer command_buffer,
                        enum journal_event_use use, VkEvent event)
{
    struct command_buffer *recording = layer_find_recording(device, command_buffer);
    if (!recording)
        return;
    journal_begin_call(recording->journal);
    journal_add_use_event(recording->journal,
                          (struct journal_entry){.info = use, .dst = handle_number(event)});
    replay_keep(recording);
}

void note_event_waits(struct layer_device *device, VkCommandBuffer command_buffer, uint32_t count,
                      const VkEvent *events)
{
    const struct command_buffer *recording = layer_find_recording(device, command_buffer);
    for (uint32_t i = 0; recording && i < count; i++)
        if (events_may_be_open(device->events, events[i], recording->journal))
            note_event_command(device, command_buffer, EVENT_WAIT, events[i]);
}
