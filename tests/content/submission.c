/* SPDX-License-Identifier: Apache-2.0 */
/* Submissions of a scene's call. */
#include "variant.h"

SCENE_CREATES(create_fence, Fence, VkFence, VkFenceCreateInfo)
SCENE_CREATES(create_semaphore, Semaphore, VkSemaphore, VkSemaphoreCreateInfo)

static void create_fence_and_timeline(struct scene *scene)
{
    const STRUCT(VkFenceCreateInfo, fence_info);
    const STRUCT(VkSemaphoreTypeCreateInfo, type, .semaphoreType = VK_SEMAPHORE_TYPE_TIMELINE);
    const STRUCT(VkSemaphoreCreateInfo, create_info, .pNext = &type);
    scene->fence = create_fence(scene, &fence_info);
    scene->timeline = create_semaphore(scene, &create_info);
}

static VkQueue queue_of(const struct scene *scene)
{
    VkQueue queue;
    scene->vk->GetDeviceQueue(scene->fixture->device,
                              fixture_find_family(scene->fixture, VK_QUEUE_COMPUTE_BIT, 0), 0,
                              &queue);
    return queue;
}

void submission_prepare(struct scene *scene)
{
    const VkCommandBuffer recorded = scene->command_buffer;
    scene_end(scene, recorded);
    if (scene->fixture->records_secondary) {
        scene->command_buffer = scene_command_buffer(
            scene, fixture_find_family(scene->fixture, VK_QUEUE_COMPUTE_BIT, 0));
        scene_begin(scene, scene->command_buffer, 0);
        scene->vk->CmdExecuteCommands(scene->command_buffer, 1, &recorded);
        scene_end(scene, scene->command_buffer);
    }
    if (scene->fence == VK_NULL_HANDLE)
        create_fence_and_timeline(scene);
}

void submission_begin(struct scene *scene)
{
    static const VkPipelineStageFlags stages[SCENE_SEMAPHORES_MAX] = {
        [0 ... SCENE_SEMAPHORES_MAX - 1] = VK_PIPELINE_STAGE_ALL_COMMANDS_BIT};
    const uint64_t value = ++scene->timeline_value;
    const uint64_t no_values[SCENE_SEMAPHORES_MAX] = {0};
    const STRUCT(VkTimelineSemaphoreSubmitInfo, values,
                 .waitSemaphoreValueCount = scene->inputs.semaphore_count,
                 .pWaitSemaphoreValues = no_values, .signalSemaphoreValueCount = 1,
                 .pSignalSemaphoreValues = &value);
    const STRUCT(VkSubmitInfo, submit_info, .pNext = &values, .signalSemaphoreCount = 1,
                 .pSignalSemaphores = &scene->timeline,
                 .waitSemaphoreCount = scene->inputs.semaphore_count,
                 .pWaitSemaphores = scene->inputs.semaphores, .pWaitDstStageMask = stages,
                 .commandBufferCount = 1, .pCommandBuffers = &scene->command_buffer);

    expect_success(scene->vk->ResetFences(scene->fixture->device, 1, &scene->fence),
                   "vkResetFences");
    expect_success(scene->vk->QueueSubmit(queue_of(scene), 1, &submit_info, scene->fence),
                   "vkQueueSubmit");
    scene->inputs.semaphore_count = 0;
}

static void poll(const struct scene *scene)
{
    VkResult result;
    do
        result = scene->vk->GetFenceStatus(scene->fixture->device, scene->fence);
    while (result == VK_NOT_READY);
    expect_success(result, "vkGetFenceStatus");
}

static void wait_for_timeline(const struct scene *scene)
{
    const STRUCT(VkSemaphoreWaitInfo, info, .semaphoreCount = 1, .pSemaphores = &scene->timeline,
                 .pValues = &scene->timeline_value);
    expect_success(scene->vk->WaitSemaphores(scene->fixture->device, &info, UINT64_MAX),
                   "vkWaitSemaphores");
}

void submission_wait(struct scene *scene, enum waiting waiting)
{
    const VkDevice device = scene->fixture->device;

    switch (waiting) {
    case WAIT_FENCE:
        expect_success(scene->vk->WaitForFences(device, 1, &scene->fence, VK_TRUE, UINT64_MAX),
                       "vkWaitForFences");
        break;
    case WAIT_FENCE_STATUS:
        poll(scene);
        break;
    case WAIT_TIMELINE:
        wait_for_timeline(scene);
        break;
    case WAIT_SUBMISSION:
        expect_success(scene->vk->QueueSubmit(queue_of(scene), 0, NULL, VK_NULL_HANDLE),
                       "vkQueueSubmit");
        break;
    case WAIT_QUEUE:
        expect_success(scene->vk->QueueWaitIdle(queue_of(scene)), "vkQueueWaitIdle");
        break;
    case WAIT_DEVICE:
        expect_success(scene->vk->DeviceWaitIdle(device), "vkDeviceWaitIdle");
        break;
    }
}

void submission_finish(struct scene *scene)
{
    expect_success(scene->vk->QueueWaitIdle(queue_of(scene)), "vkQueueWaitIdle");
}
