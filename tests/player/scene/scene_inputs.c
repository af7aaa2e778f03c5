/* SPDX-License-Identifier: Apache-2.0 */
/* Inputs of scenes, and builds that come before the call. */
#include "tests/player/scene/scene.h"

#include <stdlib.h>

static bool copies_inputs(const struct scene *scene)
{
    return scene->fixture->copies_inputs && !command_is_on_host(scene->command);
}

static struct device_buffer device_local_buffer(struct scene *scene, VkDeviceSize size,
                                                VkBufferUsageFlags usage)
{
    struct device_buffer buffer =
        scene_create_buffer(scene, size, usage | VK_BUFFER_USAGE_TRANSFER_DST_BIT);
    const struct test_memory memory = scene_allocate_with(
        scene, scene_buffer_memory_size(scene, &buffer), VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT, NULL);
    scene_bind(scene, &buffer, &memory, 0);
    return buffer;
}

struct device_buffer scene_input(struct scene *scene, VkDeviceSize size, VkBufferUsageFlags usage)
{
    if (!copies_inputs(scene))
        return scene_buffer(scene, size, usage);
    struct device_buffer buffer = device_local_buffer(scene, size, usage);
    const struct device_buffer source = scene_buffer(scene, size, VK_BUFFER_USAGE_TRANSFER_SRC_BIT);
    if (scene->input_count == SCENE_INPUTS_MAX)
        abort();
    scene->inputs[scene->input_count++] =
        (struct scene_input_copy){source.handle, buffer.handle, size};
    buffer.bytes = source.bytes;
    return buffer;
}

void scene_barrier(struct scene *scene, VkCommandBuffer command_buffer)
{
    commands_barrier(scene->vk, command_buffer);
}

void scene_inputs_copy(struct scene *scene, VkCommandBuffer command_buffer)
{
    if (!copies_inputs(scene))
        return;
    scene_barrier(scene, command_buffer);
    for (uint32_t i = 0; i < scene->input_count; i++) {
        const struct scene_input_copy *copy = &scene->inputs[i];
        const VkBufferCopy region = {0, 0, copy->size};
        scene->vk->CmdCopyBuffer(command_buffer, copy->source, copy->buffer, 1, &region);
    }
    scene_barrier(scene, command_buffer);
}

VkCommandBuffer scene_begin_before(struct scene *scene)
{
    const VkCommandBuffer command_buffer =
        copies_inputs(scene) ? scene_begin_own(scene) : scene->command_buffer;
    scene_inputs_copy(scene, command_buffer);
    return command_buffer;
}

void scene_end_before(struct scene *scene, VkCommandBuffer command_buffer)
{
    scene_barrier(scene, command_buffer);
    if (command_buffer != scene->command_buffer)
        scene_run(scene, command_buffer);
}
