/* SPDX-License-Identifier: Apache-2.0 */
/* Inputs of scenes, staged where the world wants that. */
#include "tests/rules/scene/scene_inputs.h"

#include <stdlib.h>
#include <string.h>

#include "tests/rules/scene/scene.h"

static enum input_route route_of(const struct scene *scene)
{
    return command_is_on_host(scene->command) ? INPUTS_IN_PLACE : scene->fixture->inputs;
}

/* ---- buffers ---- */

static void free_bytes(struct scene *scene, VkDevice device, uint64_t handle)
{
    (void)scene;
    (void)device;
    free((void *)(uintptr_t)handle);
}

static uint8_t *allocate_bytes(struct scene *scene, VkDeviceSize size)
{
    uint8_t *bytes = calloc(size, 1);
    if (bytes == NULL)
        abort();
    scene_defer(scene, scene->fixture->device, (uint64_t)(uintptr_t)bytes, free_bytes);
    return bytes;
}

/* Queues of several families may use it. */
static struct device_buffer shared_buffer(struct scene *scene, VkDeviceSize size,
                                          VkBufferUsageFlags usage)
{
    static const uint32_t families[] = {0, 1};
    const bool is_shared = scene->fixture->uses_two_queues;
    const STRUCT(VkBufferCreateInfo, create_info, .size = size, .usage = usage,
                 .sharingMode = is_shared ? VK_SHARING_MODE_CONCURRENT : VK_SHARING_MODE_EXCLUSIVE,
                 .queueFamilyIndexCount = is_shared ? 2 : 0, .pQueueFamilyIndices = families);
    return scene_create_buffer_with(scene, &create_info);
}

static struct device_buffer device_local_buffer(struct scene *scene, VkDeviceSize size,
                                                VkBufferUsageFlags usage)
{
    struct device_buffer buffer =
        shared_buffer(scene, size, usage | VK_BUFFER_USAGE_TRANSFER_DST_BIT);
    const struct test_memory memory = scene_allocate_with(
        scene, scene_buffer_memory_size(scene, &buffer), VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT, NULL);
    scene_bind(scene, &buffer, &memory, 0);
    return buffer;
}

struct device_buffer scene_input(struct scene *scene, VkDeviceSize size, VkBufferUsageFlags usage,
                                 bool exchanged)
{
    const enum input_route route = route_of(scene);
    struct staged_input item = {.size = size};
    struct device_buffer buffer;

    if (route == INPUTS_IN_PLACE)
        return scene_buffer(scene, size, usage);
    if (route == INPUTS_VISIBLE) {
        buffer = scene_buffer(scene, size, usage);
    } else {
        buffer = device_local_buffer(scene, size, usage);
        if (route == INPUTS_INLINE) {
            buffer.bytes = allocate_bytes(scene, size);
        } else {
            const struct device_buffer source =
                scene_buffer(scene, size, VK_BUFFER_USAGE_TRANSFER_SRC_BIT);
            item.source = source.handle;
            buffer.bytes = source.bytes;
        }
    }
    item.buffer = buffer.handle;
    item.bytes = buffer.bytes;
    item.other = exchanged ? allocate_bytes(scene, size) : NULL;
    if (scene->inputs.count == SCENE_STAGED_MAX)
        abort();
    scene->inputs.items[scene->inputs.count++] = item;
    return buffer;
}

/* ---- commands ---- */

static void barrier(struct scene *scene, VkCommandBuffer command_buffer, bool is_for_builds)
{
    const VkPipelineStageFlags builds = VK_PIPELINE_STAGE_ACCELERATION_STRUCTURE_BUILD_BIT_KHR;
    const VkPipelineStageFlags transfers = VK_PIPELINE_STAGE_TRANSFER_BIT;
    const STRUCT(
        VkMemoryBarrier, memory, .srcAccessMask = is_for_builds ? VK_ACCESS_TRANSFER_WRITE_BIT : 0,
        .dstAccessMask = is_for_builds
                             ? VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_INDIRECT_COMMAND_READ_BIT |
                                   VK_ACCESS_TRANSFER_READ_BIT /* of deserializations */
                             : VK_ACCESS_TRANSFER_WRITE_BIT);
    scene->vk->CmdPipelineBarrier(command_buffer, is_for_builds ? transfers : builds,
                                  is_for_builds ? builds : transfers, 0, 1, &memory, 0, NULL, 0,
                                  NULL);
}

static void record_copies(struct scene *scene, VkCommandBuffer command_buffer)
{
    barrier(scene, command_buffer, false);
    for (uint32_t i = 0; i < scene->inputs.count; i++) {
        const struct staged_input *item = &scene->inputs.items[i];
        const VkBufferCopy region = {0, 0, item->size};
        if (item->source != VK_NULL_HANDLE)
            scene->vk->CmdCopyBuffer(command_buffer, item->source, item->buffer, 1, &region);
        else
            scene->vk->CmdUpdateBuffer(command_buffer, item->buffer, 0, item->size, item->bytes);
    }
    barrier(scene, command_buffer, true);
}

void scene_inputs_stage(struct scene *scene, VkCommandBuffer command_buffer)
{
    const enum input_route route = route_of(scene);
    if (route == INPUTS_INLINE || route == INPUTS_COPIED)
        record_copies(scene, command_buffer);
}

/* ---- submissions before the call ---- */

SCENE_CREATES(create, Semaphore, VkSemaphore, VkSemaphoreCreateInfo)

static VkSemaphore create_semaphore(struct scene *scene)
{
    const STRUCT(VkSemaphoreCreateInfo, create_info);
    struct scene_inputs *inputs = &scene->inputs;
    if (inputs->semaphore_count == SCENE_SEMAPHORES_MAX)
        abort();
    return inputs->semaphores[inputs->semaphore_count++] = create(scene, &create_info);
}

/* To the other queue, which only a semaphore orders; or to the same, and waits. */
static void submit_before(struct scene *scene, VkCommandBuffer command_buffer)
{
    scene_end(scene, command_buffer);
    if (!scene->fixture->uses_two_queues) {
        scene_submit(scene, scene_family(scene), command_buffer);
        return;
    }
    const VkSemaphore semaphore = create_semaphore(scene);
    const STRUCT(VkSubmitInfo, submit_info, .commandBufferCount = 1,
                 .pCommandBuffers = &command_buffer, .signalSemaphoreCount = 1,
                 .pSignalSemaphores = &semaphore);
    GET(scene->vk->QueueSubmit(scene_queue(scene, 1), 1, &submit_info, VK_NULL_HANDLE));
}

static VkCommandBuffer begin_own(struct scene *scene)
{
    const uint32_t family = scene->fixture->uses_two_queues ? 1 : scene_family(scene);
    const VkCommandBuffer command_buffer = scene_command_buffer(scene, family);
    scene_begin(scene, command_buffer, 0);
    return command_buffer;
}

void scene_inputs_upload(struct scene *scene)
{
    if (route_of(scene) != INPUTS_UPLOADED)
        return;
    const VkCommandBuffer command_buffer = begin_own(scene);
    record_copies(scene, command_buffer);
    submit_before(scene, command_buffer);
}

static bool is_in_the_calls_own(const struct scene *scene)
{
    const enum input_route route = route_of(scene);
    return !scene->fixture->uses_two_queues && (route == INPUTS_IN_PLACE || route == INPUTS_INLINE);
}

VkCommandBuffer scene_begin_before(struct scene *scene)
{
    const bool is_own = !is_in_the_calls_own(scene);
    if (is_own)
        scene_inputs_upload(scene);
    const VkCommandBuffer command_buffer = is_own ? begin_own(scene) : scene->command_buffer;
    scene_inputs_stage(scene, command_buffer);
    return command_buffer;
}

void scene_barrier(struct scene *scene, VkCommandBuffer command_buffer)
{
    commands_barrier(scene->vk, command_buffer);
}

void scene_end_before(struct scene *scene, VkCommandBuffer command_buffer)
{
    scene_barrier(scene, command_buffer);
    if (!is_in_the_calls_own(scene))
        submit_before(scene, command_buffer);
    scene_inputs_remember(scene);
}

/* ---- the same with other bytes ---- */

void scene_inputs_remember(struct scene *scene)
{
    for (uint32_t i = 0; i < scene->inputs.count; i++) {
        const struct staged_input *item = &scene->inputs.items[i];
        if (item->other != NULL)
            memcpy(item->other, item->bytes, item->size);
    }
}

bool scene_inputs_differ(const struct scene *scene)
{
    for (uint32_t i = 0; i < scene->inputs.count; i++) {
        const struct staged_input *item = &scene->inputs.items[i];
        if (item->other != NULL && memcmp(item->other, item->bytes, item->size) != 0)
            return true;
    }
    return false;
}

void scene_inputs_exchange(struct scene *scene)
{
    for (uint32_t i = 0; i < scene->inputs.count; i++) {
        const struct staged_input *item = &scene->inputs.items[i];
        for (VkDeviceSize j = 0; item->other != NULL && j < item->size; j++) {
            const uint8_t byte = item->bytes[j];
            item->bytes[j] = item->other[j];
            item->other[j] = byte;
        }
    }
}
