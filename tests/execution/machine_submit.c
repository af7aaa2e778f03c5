/* SPDX-License-Identifier: Apache-2.0 */
/* The machine's submissions, and what the host waits for. */
#include <stdlib.h>

#include "machine.h"

static void add_semaphore(struct machine *machine, const struct step *step)
{
    struct batch *batch = &machine->batches[machine->batch_count - 1];
    const bool is_timeline = step->action == ACTION_WAIT_FOR || step->action == ACTION_SIGNAL_TO;
    const bool is_wait = step->action == ACTION_WAIT_FOR || step->action == ACTION_WAIT;
    STRUCT(VkSemaphoreSubmitInfo, info, .stageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT,
           .semaphore = (is_timeline ? machine->timelines : machine->binaries)[step->object]);
    if (is_timeline)
        info.value = step->value;
    else if (step->value != 0)
        info.stageMask = step->value;
    if (is_wait)
        batch->waits[batch->wait_count++] = info;
    else
        batch->signals[batch->signal_count++] = info;
}

static void submit(struct machine *machine, const struct step *step, VkFence fence)
{
    machine->result = batches_submit(machine->vk, machine->queues[step->object],
                                     machine->batch_count, machine->batches, fence);
    machine->batch_count = 0;
}

static void submit_2(struct machine *machine, const struct step *step)
{
    const VkuDeviceDispatchTable *vk = machine->vk;
    machine->result = batches_submit_2(step->value != 0 ? vk->QueueSubmit2KHR : vk->QueueSubmit2,
                                       machine->queues[step->object], machine->batch_count,
                                       machine->batches, VK_NULL_HANDLE);
    machine->batch_count = 0;
}

static void bind(struct machine *machine, const struct step *step)
{
    static const struct batch empty;
    const VkSparseMemoryBind bind = {
        .size = MACHINE_ACCEL_SIZE,
        .memory = step->value != 0 ? machine->pages.handle : VK_NULL_HANDLE,
        .memoryOffset = step->value != 0 ? (step->value - 1) * MACHINE_ACCEL_SIZE : 0,
    };
    const VkSparseBufferMemoryBindInfo buffer_bind = {
        .buffer = machine->structures[step->dst].buffer.handle, .bindCount = 1, .pBinds = &bind};
    machine->result = batch_bind(machine->vk, machine->queues[step->object],
                                 machine->batch_count != 0 ? machine->batches : &empty,
                                 &buffer_bind, step->detail != 0 ? machine->fence : VK_NULL_HANDLE);
}

/* ---- the host */

static void signal_from_host(struct machine *machine, const struct step *step)
{
    const STRUCT(VkSemaphoreSignalInfo, info, .semaphore = machine->timelines[step->object],
                 .value = step->value);
    machine->result = machine->vk->SignalSemaphore(machine->device, &info);
}

static void wait_on_host(struct machine *machine, const struct step *step)
{
    const STRUCT(VkSemaphoreWaitInfo, info, .semaphoreCount = 1,
                 .pSemaphores = &machine->timelines[step->object], .pValues = &step->value);
    uint64_t value;
    switch (step->action) {
    case ACTION_QUEUE_IDLE:
        MACHINE_CALL(machine, QueueWaitIdle, machine->queues[step->object]);
        break;
    case ACTION_WAIT_FENCE:
        MACHINE_CALL(machine, WaitForFences, machine->device, 1, &machine->fence, VK_TRUE,
                     UINT64_MAX);
        break;
    case ACTION_POLL_FENCE:
        MACHINE_CALL(machine, GetFenceStatus, machine->device, machine->fence);
        break;
    case ACTION_HOST_WAIT:
        MACHINE_CALL(machine, WaitSemaphores, machine->device, &info, UINT64_MAX);
        break;
    case ACTION_HOST_READ:
        MACHINE_CALL(machine, GetSemaphoreCounterValue, machine->device,
                     machine->timelines[step->object], &value);
        break;
    default:
        MACHINE_CALL(machine, DeviceWaitIdle, machine->device);
    }
}

void machine_submit(struct machine *machine, const struct step *step)
{
    const struct fixture *fixture = machine->scene->fixture;
    switch (step->action) {
    case ACTION_BATCH:
        machine->batches[machine->batch_count++] = (struct batch){.command_count = 0};
        break;
    case ACTION_WITH:
        batch_add_commands(&machine->batches[machine->batch_count - 1],
                           machine->command_buffers[step->object]);
        break;
    case ACTION_SUBMIT:
    case ACTION_FAILED_SUBMIT:
        submit(machine, step, step->value != 0 ? machine->fence : VK_NULL_HANDLE);
        break;
    case ACTION_SUBMIT2:
        submit_2(machine, step);
        break;
    case ACTION_LOST_SUBMIT:
        fixture->platform->null_driver.set_device_lost(true);
        submit(machine, step, VK_NULL_HANDLE);
        fixture->platform->null_driver.set_device_lost(false);
        break;
    case ACTION_FAIL_SUBMIT:
        fixture->platform->null_driver.fail_next(step->value != 0 ? "vkQueueBindSparse"
                                                                  : "vkQueueSubmit",
                                                 VK_ERROR_OUT_OF_DEVICE_MEMORY);
        break;
    case ACTION_BIND:
    case ACTION_FAILED_BIND:
        bind(machine, step);
        machine->batch_count = 0;
        break;
    case ACTION_SIGNAL_FROM_HOST:
        signal_from_host(machine, step);
        break;
    case ACTION_HOST_SET_EVENT:
        MACHINE_CALL(machine, SetEvent, machine->device, machine->events[step->object]);
        break;
    case ACTION_HOST_RESET_EVENT:
        MACHINE_CALL(machine, ResetEvent, machine->device, machine->events[step->object]);
        break;
    case ACTION_IDLE:
    case ACTION_QUEUE_IDLE:
    case ACTION_WAIT_FENCE:
    case ACTION_POLL_FENCE:
    case ACTION_HOST_WAIT:
    case ACTION_HOST_READ:
        wait_on_host(machine, step);
        break;
    default:
        add_semaphore(machine, step);
    }
}
