/* SPDX-License-Identifier: Apache-2.0 */
/* Observes command pools, command buffers, and the commands that open and close scopes. */
#include "observers.h"
#include "src/base/recording_path.h"
#include "src/check/replay/replay.h"

static struct command_buffer *find_command_buffer(struct layer_device *device,
                                                  VkCommandBuffer handle)
{
    return command_buffers_find(device->command_buffers, handle);
}

/* ---- pools and buffers */

static VkQueueFlags queue_flags_of(const struct layer_device *device, uint32_t family)
{
    return family < device->queue_family_count ? device->queue_families[family].queueFlags : 0;
}

void note_command_pool(struct layer_device *device, VkCommandPool pool,
                       const VkCommandPoolCreateInfo *info)
{
    command_buffers_add_pool(device->command_buffers, pool, info->queueFamilyIndex,
                             queue_flags_of(device, info->queueFamilyIndex),
                             info->flags & VK_COMMAND_POOL_CREATE_PROTECTED_BIT);
}

static void forget_command_buffer(void *user, VkCommandBuffer handle)
{
    layer_forget_command_buffer(handle);
    object_names_end(user, VK_OBJECT_TYPE_COMMAND_BUFFER, handle_number(handle), 0);
}

void forget_command_pool(struct layer_device *device, VkCommandPool pool)
{
    command_buffers_remove_pool(device->command_buffers, pool, forget_command_buffer,
                                device->names);
    object_names_end(device->names, VK_OBJECT_TYPE_COMMAND_POOL, handle_number(pool), 0);
}

void note_pool_reset(struct layer_device *device, VkCommandPool pool, VkCommandPoolResetFlags flags)
{
    command_buffers_reset_pool(device->command_buffers, pool,
                               flags & VK_COMMAND_POOL_RESET_RELEASE_RESOURCES_BIT);
}

void note_command_buffers(struct layer_device *device, const VkCommandBufferAllocateInfo *info,
                          VkCommandBuffer *handles)
{
    for (uint32_t i = 0; i < info->commandBufferCount; i++)
        layer_forget_command_buffer(handles[i]);
    command_buffers_add(device->command_buffers, info->commandPool, info->level,
                        info->commandBufferCount, handles);
}

void forget_command_buffers(struct layer_device *device, uint32_t count,
                            const VkCommandBuffer *handles)
{
    command_buffers_remove(device->command_buffers, count, handles);
    for (uint32_t i = 0; i < count; i++)
        forget_command_buffer(device->names, handles[i]);
}

ON_RECORDING_PATH void note_begin(struct layer_device *device, VkCommandBuffer handle,
                                  const VkCommandBufferBeginInfo *info, VkResult result)
{
    command_buffer_begin(find_command_buffer(device, handle), info,
                         resources_destroy_count(device->resources), result);
}

ON_RECORDING_PATH void note_end(struct layer_device *device, VkCommandBuffer handle,
                                VkResult result)
{
    command_buffer_end(find_command_buffer(device, handle), result);
}

ON_RECORDING_PATH void note_reset(struct layer_device *device, VkCommandBuffer handle,
                                  VkCommandBufferResetFlags flags, VkResult result)
{
    command_buffer_reset(find_command_buffer(device, handle),
                         flags & VK_COMMAND_BUFFER_RESET_RELEASE_RESOURCES_BIT, result);
}

void note_secondaries(struct layer_device *device, VkCommandBuffer handle, uint32_t count,
                      const VkCommandBuffer *secondaries)
{
    struct command_buffer *primary = find_command_buffer(device, handle);
    for (uint32_t i = 0; primary && i < count; i++) {
        if (primary->journal)
            journal_begin_call(primary->journal);
        command_buffer_execute(primary, find_command_buffer(device, secondaries[i]));
        if (primary->journal)
            replay_keep(primary);
    }
}

/* ---- render passes, rendering and video */

void open_render_pass(struct layer_device *device, VkCommandBuffer handle)
{
    command_buffer_begin_rendering(find_command_buffer(device, handle), 0);
}

void open_rendering(struct layer_device *device, VkCommandBuffer handle,
                    const VkRenderingInfo *info)
{
    command_buffer_begin_rendering(find_command_buffer(device, handle), info->flags);
}

void close_rendering(struct layer_device *device, VkCommandBuffer handle)
{
    command_buffer_end_rendering(find_command_buffer(device, handle));
}

void set_video_coding(struct layer_device *device, VkCommandBuffer handle, bool is_open)
{
    command_buffer_set_video_coding(find_command_buffer(device, handle), is_open);
}
