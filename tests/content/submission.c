/* SPDX-License-Identifier: Apache-2.0 */
/* Submissions of a scene's call. */
#include "submission.h"

static void destroy_fence(struct scene *scene, VkDevice device, uint64_t handle)
{
    scene->vk->DestroyFence(device, (VkFence)handle, NULL);
}

static VkQueue queue_of(const struct scene *scene)
{
    VkQueue queue;
    scene->vk->GetDeviceQueue(scene->world->device,
                              world_find_family(scene->world, VK_QUEUE_COMPUTE_BIT, 0), 0, &queue);
    return queue;
}

void submission_prepare(struct scene *scene)
{
    const VkCommandBuffer recorded = scene->command_buffer;
    scene_end(scene, recorded);
    if (scene->world->records_secondary) {
        scene->command_buffer =
            scene_command_buffer(scene, world_find_family(scene->world, VK_QUEUE_COMPUTE_BIT, 0));
        scene_begin(scene, scene->command_buffer, 0);
        scene->vk->CmdExecuteCommands(scene->command_buffer, 1, &recorded);
        scene_end(scene, scene->command_buffer);
    }
    if (scene->fence == VK_NULL_HANDLE) {
        const VkFenceCreateInfo create_info = {.sType = VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
        const VkDevice device = scene->world->device;
        expect_success(scene->vk->CreateFence(device, &create_info, NULL, &scene->fence),
                       "vkCreateFence");
        scene_defer(scene, device, (uint64_t)scene->fence, destroy_fence);
    }
}

void submission_begin(struct scene *scene)
{
    static const VkPipelineStageFlags stages[SCENE_SEMAPHORES_MAX] = {
        [0 ... SCENE_SEMAPHORES_MAX - 1] = VK_PIPELINE_STAGE_ALL_COMMANDS_BIT};
    const VkSubmitInfo submit_info = {.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO,
                                      .waitSemaphoreCount = scene->inputs.semaphore_count,
                                      .pWaitSemaphores = scene->inputs.semaphores,
                                      .pWaitDstStageMask = stages,
                                      .commandBufferCount = 1,
                                      .pCommandBuffers = &scene->command_buffer};

    expect_success(scene->vk->ResetFences(scene->world->device, 1, &scene->fence), "vkResetFences");
    expect_success(scene->vk->QueueSubmit(queue_of(scene), 1, &submit_info, scene->fence),
                   "vkQueueSubmit");
    scene->inputs.semaphore_count = 0;
}

static void poll(const struct scene *scene)
{
    VkResult result;
    do
        result = scene->vk->GetFenceStatus(scene->world->device, scene->fence);
    while (result == VK_NOT_READY);
    expect_success(result, "vkGetFenceStatus");
}

void submission_wait(struct scene *scene, enum waiting waiting)
{
    const VkDevice device = scene->world->device;

    switch (waiting) {
    case WAIT_FENCE:
        expect_success(scene->vk->WaitForFences(device, 1, &scene->fence, VK_TRUE, UINT64_MAX),
                       "vkWaitForFences");
        break;
    case WAIT_FENCE_STATUS:
        poll(scene);
        break;
    case WAIT_QUEUE:
        expect_success(scene->vk->QueueWaitIdle(queue_of(scene)), "vkQueueWaitIdle");
        break;
    case WAIT_DEVICE:
        expect_success(scene->vk->DeviceWaitIdle(device), "vkDeviceWaitIdle");
        break;
    }
}
