/* SPDX-License-Identifier: Apache-2.0 */
/* The fake commands, and the calls. */
#include "layer/postmortem/hang.h"
#include "layer/postmortem/loss.h"
#include "layer/snapshots/guard/execution.h"
#include "layer/snapshots/snapshots.h"

#include "fake_device.h"

#include <string.h>

struct layer_device device;
VkResult next_result;
uint32_t calls;
uint64_t counter;
const char *reached;

/* Devices here are of backend driver. */
void guard_begin_submission(void) {}

void postmortem_report_loss(struct layer_device *of_device)
{
    execution_order_set_unknown(of_device->order, ORDER_UNKNOWN_DEVICE_LOST);
}

void hang_wait_before_idle(struct layer_device *of_device, VkQueue queue) {}

VkResult hang_wait_for_fences(struct layer_device *of_device, uint32_t count, const VkFence *fences,
                              VkBool32 all, uint64_t timeout)
{
    return of_device->vk.WaitForFences(of_device->handle, count, fences, all, timeout);
}

VkResult hang_wait_semaphores(struct layer_device *of_device, PFN_vkWaitSemaphores wait,
                              const VkSemaphoreWaitInfo *info, uint64_t timeout)
{
    return wait(of_device->handle, info, timeout);
}

struct layer_device *layer_find_device(const void *dispatchable)
{
    return &device;
}

/* ---- the fake driver */

static VkResult answer(const char *name)
{
    VkResult result = next_result;
    next_result = VK_SUCCESS;
    reached = name;
    calls++;
    return result;
}

static VkuDeviceDispatchTable fake_commands;

/* Before main. */
#define ENTER(name)                                                                                \
    __attribute__((constructor)) static void enter_##name(void)                                    \
    {                                                                                              \
        fake_commands.name = fake_##name;                                                          \
    }

/* A command that does something before it answers; then its name and parameters. */
#define FAKE_THAT(action, name, ...)                                                               \
    static VKAPI_ATTR VkResult VKAPI_CALL fake_##name(__VA_ARGS__)                                 \
    {                                                                                              \
        action;                                                                                    \
        return answer(#name);                                                                      \
    }                                                                                              \
    ENTER(name)
#define FAKE(name, ...) FAKE_THAT((void)0, name, __VA_ARGS__)
#define FAKE_DESTROY(name, ...)                                                                    \
    static VKAPI_ATTR void VKAPI_CALL fake_##name(__VA_ARGS__)                                     \
    {                                                                                              \
        answer(#name);                                                                             \
    }                                                                                              \
    ENTER(name)

#pragma GCC diagnostic ignored "-Wunused-parameter"
FAKE(QueueSubmit, VkQueue queue, uint32_t count, const VkSubmitInfo *submits, VkFence fence)
FAKE(QueueSubmit2, VkQueue queue, uint32_t count, const VkSubmitInfo2 *submits, VkFence fence)
FAKE(QueueSubmit2KHR, VkQueue queue, uint32_t count, const VkSubmitInfo2 *submits, VkFence fence)
FAKE(QueueBindSparse, VkQueue queue, uint32_t count, const VkBindSparseInfo *info, VkFence fence)
FAKE(QueuePresentKHR, VkQueue queue, const VkPresentInfoKHR *info)
FAKE(QueueWaitIdle, VkQueue queue)
FAKE(DeviceWaitIdle, VkDevice handle)
FAKE(AcquireNextImageKHR, VkDevice handle, VkSwapchainKHR swapchain, uint64_t timeout,
     VkSemaphore semaphore, VkFence fence, uint32_t *image)
FAKE(AcquireNextImage2KHR, VkDevice handle, const VkAcquireNextImageInfoKHR *info, uint32_t *image)
FAKE(SignalSemaphore, VkDevice handle, const VkSemaphoreSignalInfo *info)
FAKE(SignalSemaphoreKHR, VkDevice handle, const VkSemaphoreSignalInfo *info)
FAKE(WaitSemaphores, VkDevice handle, const VkSemaphoreWaitInfo *info, uint64_t timeout)
FAKE(WaitSemaphoresKHR, VkDevice handle, const VkSemaphoreWaitInfo *info, uint64_t timeout)
FAKE(LatencySleepNV, VkDevice handle, VkSwapchainKHR swapchain, const VkLatencySleepInfoNV *info)
FAKE(ImportSemaphoreFdKHR, VkDevice handle, const VkImportSemaphoreFdInfoKHR *info)
FAKE(ImportFenceFdKHR, VkDevice handle, const VkImportFenceFdInfoKHR *info)
FAKE(ResetFences, VkDevice handle, uint32_t count, const VkFence *fences)
FAKE(GetFenceStatus, VkDevice handle, VkFence fence)
FAKE(WaitForFences, VkDevice handle, uint32_t count, const VkFence *fences, VkBool32 all,
     uint64_t timeout)
FAKE_THAT(*value = counter, GetSemaphoreCounterValue, VkDevice handle, VkSemaphore semaphore,
          uint64_t *value)
FAKE_THAT(*value = counter, GetSemaphoreCounterValueKHR, VkDevice handle, VkSemaphore semaphore,
          uint64_t *value)
FAKE_THAT(*semaphore = SEMAPHORE(counter), CreateSemaphore, VkDevice handle,
          const VkSemaphoreCreateInfo *info, const VkAllocationCallbacks *allocator,
          VkSemaphore *semaphore)
FAKE_THAT(*fence = FENCE(counter), CreateFence, VkDevice handle, const VkFenceCreateInfo *info,
          const VkAllocationCallbacks *allocator, VkFence *fence)
FAKE_DESTROY(DestroySemaphore, VkDevice handle, VkSemaphore semaphore,
             const VkAllocationCallbacks *allocator)
FAKE_DESTROY(DestroyFence, VkDevice handle, VkFence fence, const VkAllocationCallbacks *allocator)
#pragma GCC diagnostic warning "-Wunused-parameter"

void fake_device_start(struct program *program)
{
    static struct events *events; /* one for all devices */
    static struct queue_labels *queue_labels;
    static struct resources *resources;
    program_start(program);
    memset(&device, 0, sizeof(device));
    if (events == NULL)
        assert_int_equal(events_create(&events), VK_SUCCESS);
    if (queue_labels == NULL)
        assert_int_equal(queue_labels_create(&queue_labels), VK_SUCCESS);
    if (resources == NULL)
        assert_int_equal(resources_create(&resources), VK_SUCCESS);
    device.events = events;
    device.resources = resources;
    device.queue_labels = queue_labels;
    device.physical_device_count = 1;
    device.order = program->order;
    device.vk = fake_commands;
    next_result = VK_SUCCESS;
    calls = 0;
}

struct program *fake_device_open(void)
{
    static struct program program;
    fake_device_start(&program);
    return &program;
}

/* ---- calls of the application */

void create_semaphore(uint32_t handle, VkSemaphoreType type, const void *chain)
{
    const STRUCT(VkSemaphoreTypeCreateInfo, types, .pNext = chain, .semaphoreType = type);
    const STRUCT(VkSemaphoreCreateInfo, info, .pNext = &types);
    VkSemaphore created;
    counter = handle;
    assert_int_equal(entry_CreateSemaphore(NULL, &info, NULL, &created), VK_SUCCESS);
}

void create_fence(uint32_t handle, const void *chain)
{
    const STRUCT(VkFenceCreateInfo, info, .pNext = chain);
    VkFence created;
    counter = handle;
    assert_int_equal(entry_CreateFence(NULL, &info, NULL, &created), VK_SUCCESS);
}

VkResult submit_plain(const struct batch *batch)
{
    VkCommandBuffer command_buffer = COMMAND_BUFFER(batch->name);
    VkSemaphore wait = SEMAPHORE(batch->wait), signal = SEMAPHORE(batch->signal);
    VkPipelineStageFlags stages = batch->wait_stages ? (VkPipelineStageFlags)batch->wait_stages
                                                     : VK_PIPELINE_STAGE_ALL_COMMANDS_BIT;
    const STRUCT(VkTimelineSemaphoreSubmitInfo, values, .pNext = batch->group,
                 .waitSemaphoreValueCount = batch->wait_value ? 1 : 0,
                 .pWaitSemaphoreValues = batch->wait_value ? &batch->wait_value : NULL,
                 .signalSemaphoreValueCount = 1, .pSignalSemaphoreValues = &batch->signal_value);
    const STRUCT(VkSubmitInfo, info, .pNext = &values, .waitSemaphoreCount = batch->wait ? 1 : 0,
                 .pWaitSemaphores = &wait, .pWaitDstStageMask = &stages, .commandBufferCount = 1,
                 .pCommandBuffers = &command_buffer, .signalSemaphoreCount = batch->signal ? 1 : 0,
                 .pSignalSemaphores = &signal);
    return entry_QueueSubmit(QUEUE(batch->queue), 1, &info, FENCE(batch->fence));
}

VkResult submit_second(const struct batch *batch, PFN_vkQueueSubmit2 call)
{
    const STRUCT(VkCommandBufferSubmitInfo, commands, .commandBuffer = COMMAND_BUFFER(batch->name),
                 .deviceMask = batch->device_mask);
    const STRUCT(VkSemaphoreSubmitInfo, wait, .semaphore = SEMAPHORE(batch->wait),
                 .value = batch->wait_value, .stageMask = batch->wait_stages);
    const STRUCT(VkSemaphoreSubmitInfo, signal, .semaphore = SEMAPHORE(batch->signal),
                 .value = batch->signal_value, .stageMask = batch->signal_stages);
    const STRUCT(
        VkSubmitInfo2, info, .waitSemaphoreInfoCount = batch->wait ? 1 : 0,
        .pWaitSemaphoreInfos = &wait, .commandBufferInfoCount = 1, .pCommandBufferInfos = &commands,
        .signalSemaphoreInfoCount = batch->signal ? 1 : 0, .pSignalSemaphoreInfos = &signal);
    return call(QUEUE(batch->queue), 1, &info, FENCE(batch->fence));
}
