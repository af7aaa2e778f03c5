/* SPDX-License-Identifier: Apache-2.0 */
/* The machine's submissions, in the form of vkQueueSubmit or of vkQueueSubmit2. */
#include <stdlib.h>

#include "machine.h"

static uint64_t stages_of(uint64_t given)
{
    return given != 0 ? given : VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT;
}

/* ---- putting it together */

static void add_semaphore(struct machine *machine, const struct step *step)
{
    struct machine_batch *batch = &machine->batches[machine->batch_count - 1];
    const bool is_timeline = step->action == ACTION_WAIT_FOR || step->action == ACTION_SIGNAL_TO;
    const bool is_wait = step->action == ACTION_WAIT_FOR || step->action == ACTION_WAIT;
    struct machine_semaphore *added =
        is_wait ? &batch->waits[batch->wait_count++] : &batch->signals[batch->signal_count++];
    added->handle =
        is_timeline ? machine->timelines[step->object] : machine->binaries[step->object];
    added->stages = is_timeline ? 0 : step->value;
    added->value = step->value;
}

static void add_commands(struct machine *machine, uint32_t command_buffer)
{
    struct machine_batch *batch = &machine->batches[machine->batch_count - 1];
    batch->commands[batch->command_count++] = command_buffer;
}

/* ---- the two forms */

void machine_fill_semaphores(struct machine_semaphores *semaphores,
                             const struct machine_batch *batch)
{
    for (uint32_t i = 0; i < MACHINE_MEMBERS; i++) {
        semaphores->waits[i] = batch->waits[i].handle;
        semaphores->stages[i] = (VkPipelineStageFlags)stages_of(batch->waits[i].stages);
        semaphores->wait_values[i] = batch->waits[i].value;
        semaphores->signals[i] = batch->signals[i].handle;
        semaphores->signal_values[i] = batch->signals[i].value;
    }
    semaphores->values =
        MAKE(VkTimelineSemaphoreSubmitInfo, .waitSemaphoreValueCount = batch->wait_count,
             .pWaitSemaphoreValues = semaphores->wait_values,
             .signalSemaphoreValueCount = batch->signal_count,
             .pSignalSemaphoreValues = semaphores->signal_values);
}

static VkResult submit(struct machine *machine, VkQueue queue, VkFence fence)
{
    VkCommandBuffer commands[MACHINE_BATCHES][MACHINE_MEMBERS];
    struct machine_semaphores semaphores[MACHINE_BATCHES];
    VkSubmitInfo infos[MACHINE_BATCHES];

    for (uint32_t i = 0; i < machine->batch_count; i++) {
        const struct machine_batch *batch = &machine->batches[i];
        for (uint32_t j = 0; j < MACHINE_MEMBERS; j++)
            commands[i][j] = machine->command_buffers[batch->commands[j]];
        machine_fill_semaphores(&semaphores[i], batch);
        infos[i] = MAKE(
            VkSubmitInfo, .pNext = &semaphores[i].values, .waitSemaphoreCount = batch->wait_count,
            .pWaitSemaphores = semaphores[i].waits, .pWaitDstStageMask = semaphores[i].stages,
            .commandBufferCount = batch->command_count, .pCommandBuffers = commands[i],
            .signalSemaphoreCount = batch->signal_count,
            .pSignalSemaphores = semaphores[i].signals);
    }
    return machine->vk->QueueSubmit(queue, machine->batch_count, infos, fence);
}

static VkSemaphoreSubmitInfo semaphore_info(const struct machine_semaphore *semaphore)
{
    return MAKE(VkSemaphoreSubmitInfo, .semaphore = semaphore->handle, .value = semaphore->value,
                .stageMask = stages_of(semaphore->stages));
}

static VkResult submit2(struct machine *machine, VkQueue queue, bool by_older_name)
{
    VkCommandBufferSubmitInfo commands[MACHINE_BATCHES][MACHINE_MEMBERS];
    VkSemaphoreSubmitInfo waits[MACHINE_BATCHES][MACHINE_MEMBERS],
        signals[MACHINE_BATCHES][MACHINE_MEMBERS];
    VkSubmitInfo2 infos[MACHINE_BATCHES];

    for (uint32_t i = 0; i < machine->batch_count; i++) {
        const struct machine_batch *batch = &machine->batches[i];
        for (uint32_t j = 0; j < MACHINE_MEMBERS; j++) {
            commands[i][j] = MAKE(VkCommandBufferSubmitInfo,
                                  .commandBuffer = machine->command_buffers[batch->commands[j]]);
            waits[i][j] = semaphore_info(&batch->waits[j]);
            signals[i][j] = semaphore_info(&batch->signals[j]);
        }
        infos[i] = MAKE(
            VkSubmitInfo2, .waitSemaphoreInfoCount = batch->wait_count,
            .pWaitSemaphoreInfos = waits[i], .commandBufferInfoCount = batch->command_count,
            .pCommandBufferInfos = commands[i], .signalSemaphoreInfoCount = batch->signal_count,
            .pSignalSemaphoreInfos = signals[i]);
    }
    return by_older_name
               ? machine->vk->QueueSubmit2KHR(queue, machine->batch_count, infos, VK_NULL_HANDLE)
               : machine->vk->QueueSubmit2(queue, machine->batch_count, infos, VK_NULL_HANDLE);
}

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
        machine->batches[machine->batch_count++] = (struct machine_batch){0};
        break;
    case ACTION_WITH:
        add_commands(machine, step->object);
        break;
    case ACTION_SUBMIT:
    case ACTION_FAILED_SUBMIT:
        machine->result = submit(machine, machine->queues[step->object],
                                 step->value != 0 ? machine->fence : VK_NULL_HANDLE);
        machine->batch_count = 0;
        break;
    case ACTION_SUBMIT2:
        machine->result = submit2(machine, machine->queues[step->object], step->value != 0);
        machine->batch_count = 0;
        break;
    case ACTION_LOST_SUBMIT:
        fixture->platform->null_driver.set_device_lost(true);
        machine->result = submit(machine, machine->queues[step->object], VK_NULL_HANDLE);
        fixture->platform->null_driver.set_device_lost(false);
        machine->batch_count = 0;
        break;
    case ACTION_FAIL_SUBMIT:
        fixture->platform->null_driver.fail_next(step->value != 0 ? "vkQueueBindSparse"
                                                                  : "vkQueueSubmit",
                                                 VK_ERROR_OUT_OF_DEVICE_MEMORY);
        break;
    case ACTION_BIND:
    case ACTION_FAILED_BIND:
        machine_bind(machine, step);
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
