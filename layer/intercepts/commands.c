/* SPDX-License-Identifier: Apache-2.0 */
/* Intercepts of command pools, command buffers, and the commands that open and close scopes. */
#include "layer/intercepts/intercepts.h"
#include "layer/layer.h"
#include "src/base/recording_path.h"
#include "src/check/replay/replay.h"

static struct command_buffer *find(struct layer_device *device, VkCommandBuffer handle)
{
    return command_buffers_find(device->command_buffers, handle);
}

/* ---- pools and buffers */

static VkQueueFlags queue_flags_of(const struct layer_device *device, uint32_t family)
{
    return family < device->queue_family_count ? device->queue_families[family].queueFlags : 0;
}

VKAPI_ATTR VkResult VKAPI_CALL assay_CreateCommandPool(VkDevice device,
                                                       const VkCommandPoolCreateInfo *pCreateInfo,
                                                       const VkAllocationCallbacks *pAllocator,
                                                       VkCommandPool *pCommandPool)
{
    struct layer_device *state = layer_find_device(device);
    VkResult result = state->vk.CreateCommandPool(device, pCreateInfo, pAllocator, pCommandPool);
    if (result == VK_SUCCESS)
        command_buffers_add_pool(state->command_buffers, *pCommandPool,
                                 pCreateInfo->queueFamilyIndex,
                                 queue_flags_of(state, pCreateInfo->queueFamilyIndex),
                                 pCreateInfo->flags & VK_COMMAND_POOL_CREATE_PROTECTED_BIT);
    return result;
}

static void forget(void *user, VkCommandBuffer handle)
{
    layer_forget_command_buffer(handle);
    object_names_set(user, VK_OBJECT_TYPE_COMMAND_BUFFER, (uint64_t)(uintptr_t)handle, NULL);
}

VKAPI_ATTR void VKAPI_CALL assay_DestroyCommandPool(VkDevice device, VkCommandPool commandPool,
                                                    const VkAllocationCallbacks *pAllocator)
{
    struct layer_device *state = layer_find_device(device);
    command_buffers_remove_pool(state->command_buffers, commandPool, forget, state->names);
    object_names_set(state->names, VK_OBJECT_TYPE_COMMAND_POOL, (uint64_t)(uintptr_t)commandPool,
                     NULL);
    state->vk.DestroyCommandPool(device, commandPool, pAllocator);
}

VKAPI_ATTR VkResult VKAPI_CALL assay_ResetCommandPool(VkDevice device, VkCommandPool commandPool,
                                                      VkCommandPoolResetFlags flags)
{
    struct layer_device *state = layer_find_device(device);
    VkResult result = state->vk.ResetCommandPool(device, commandPool, flags);
    if (result == VK_SUCCESS)
        command_buffers_reset_pool(state->command_buffers, commandPool,
                                   flags & VK_COMMAND_POOL_RESET_RELEASE_RESOURCES_BIT);
    return result;
}

VKAPI_ATTR VkResult VKAPI_CALL
assay_AllocateCommandBuffers(VkDevice device, const VkCommandBufferAllocateInfo *pAllocateInfo,
                             VkCommandBuffer *pCommandBuffers)
{
    struct layer_device *state = layer_find_device(device);
    VkResult result = state->vk.AllocateCommandBuffers(device, pAllocateInfo, pCommandBuffers);
    if (result != VK_SUCCESS)
        return result;
    for (uint32_t i = 0; i < pAllocateInfo->commandBufferCount; i++)
        layer_forget_command_buffer(pCommandBuffers[i]);
    command_buffers_add(state->command_buffers, pAllocateInfo->commandPool, pAllocateInfo->level,
                        pAllocateInfo->commandBufferCount, pCommandBuffers);
    return result;
}

VKAPI_ATTR void VKAPI_CALL assay_FreeCommandBuffers(VkDevice device, VkCommandPool commandPool,
                                                    uint32_t commandBufferCount,
                                                    const VkCommandBuffer *pCommandBuffers)
{
    struct layer_device *state = layer_find_device(device);
    command_buffers_remove(state->command_buffers, commandBufferCount, pCommandBuffers);
    for (uint32_t i = 0; i < commandBufferCount; i++)
        forget(state->names, pCommandBuffers[i]);
    state->vk.FreeCommandBuffers(device, commandPool, commandBufferCount, pCommandBuffers);
}

ON_RECORDING_PATH VKAPI_ATTR VkResult VKAPI_CALL
assay_BeginCommandBuffer(VkCommandBuffer commandBuffer, const VkCommandBufferBeginInfo *pBeginInfo)
{
    struct layer_device *state = layer_find_recording_device(commandBuffer);
    if (!state)
        return VK_ERROR_VALIDATION_FAILED_EXT;
    VkResult result = state->vk.BeginCommandBuffer(commandBuffer, pBeginInfo);
    command_buffer_begin(find(state, commandBuffer), pBeginInfo,
                         resources_destroy_count(state->resources), result);
    return result;
}

ON_RECORDING_PATH VKAPI_ATTR VkResult VKAPI_CALL
assay_EndCommandBuffer(VkCommandBuffer commandBuffer)
{
    struct layer_device *state = layer_find_recording_device(commandBuffer);
    if (!state)
        return VK_ERROR_VALIDATION_FAILED_EXT;
    VkResult result = state->vk.EndCommandBuffer(commandBuffer);
    command_buffer_end(find(state, commandBuffer), result);
    return result;
}

ON_RECORDING_PATH VKAPI_ATTR VkResult VKAPI_CALL
assay_ResetCommandBuffer(VkCommandBuffer commandBuffer, VkCommandBufferResetFlags flags)
{
    struct layer_device *state = layer_find_recording_device(commandBuffer);
    if (!state)
        return VK_ERROR_VALIDATION_FAILED_EXT;
    VkResult result = state->vk.ResetCommandBuffer(commandBuffer, flags);
    command_buffer_reset(find(state, commandBuffer),
                         flags & VK_COMMAND_BUFFER_RESET_RELEASE_RESOURCES_BIT, result);
    return result;
}

VKAPI_ATTR void VKAPI_CALL assay_CmdExecuteCommands(VkCommandBuffer commandBuffer,
                                                    uint32_t commandBufferCount,
                                                    const VkCommandBuffer *pCommandBuffers)
{
    struct layer_device *state = layer_find_recording_device(commandBuffer);
    if (!state)
        return;
    struct command_buffer *primary = find(state, commandBuffer);
    for (uint32_t i = 0; primary && i < commandBufferCount; i++) {
        if (primary->journal)
            journal_begin_call(primary->journal);
        command_buffer_execute(primary, find(state, pCommandBuffers[i]));
        if (primary->journal)
            replay_keep(primary);
    }
    state->vk.CmdExecuteCommands(commandBuffer, commandBufferCount, pCommandBuffers);
}

/* ---- render passes and rendering */

VKAPI_ATTR void VKAPI_CALL assay_CmdBeginRenderPass(VkCommandBuffer commandBuffer,
                                                    const VkRenderPassBeginInfo *pRenderPassBegin,
                                                    VkSubpassContents contents)
{
    struct layer_device *state = layer_find_recording_device(commandBuffer);
    if (!state)
        return;
    command_buffer_begin_rendering(find(state, commandBuffer), 0);
    state->vk.CmdBeginRenderPass(commandBuffer, pRenderPassBegin, contents);
}

VKAPI_ATTR void VKAPI_CALL assay_CmdEndRenderPass(VkCommandBuffer commandBuffer)
{
    struct layer_device *state = layer_find_recording_device(commandBuffer);
    if (!state)
        return;
    command_buffer_end_rendering(find(state, commandBuffer));
    state->vk.CmdEndRenderPass(commandBuffer);
}

/* Aliases of a command differ only in which command of the next layer they call. */
#define DEFINE_BEGIN_RENDER_PASS_2(name)                                                           \
    VKAPI_ATTR void VKAPI_CALL assay_##name(VkCommandBuffer commandBuffer,                         \
                                            const VkRenderPassBeginInfo *pRenderPassBegin,         \
                                            const VkSubpassBeginInfo *pSubpassBeginInfo)           \
    {                                                                                              \
        struct layer_device *state = layer_find_recording_device(commandBuffer);                   \
        if (!state)                                                                                \
            return;                                                                                \
        command_buffer_begin_rendering(find(state, commandBuffer), 0);                             \
        state->vk.name(commandBuffer, pRenderPassBegin, pSubpassBeginInfo);                        \
    }

#define DEFINE_END_RENDER_PASS_2(name)                                                             \
    VKAPI_ATTR void VKAPI_CALL assay_##name(VkCommandBuffer commandBuffer,                         \
                                            const VkSubpassEndInfo *pSubpassEndInfo)               \
    {                                                                                              \
        struct layer_device *state = layer_find_recording_device(commandBuffer);                   \
        if (!state)                                                                                \
            return;                                                                                \
        command_buffer_end_rendering(find(state, commandBuffer));                                  \
        state->vk.name(commandBuffer, pSubpassEndInfo);                                            \
    }

#define DEFINE_BEGIN_RENDERING(name)                                                               \
    VKAPI_ATTR void VKAPI_CALL assay_##name(VkCommandBuffer commandBuffer,                         \
                                            const VkRenderingInfo *pRenderingInfo)                 \
    {                                                                                              \
        struct layer_device *state = layer_find_recording_device(commandBuffer);                   \
        if (!state)                                                                                \
            return;                                                                                \
        command_buffer_begin_rendering(find(state, commandBuffer), pRenderingInfo->flags);         \
        state->vk.name(commandBuffer, pRenderingInfo);                                             \
    }

#define DEFINE_END_RENDERING(name)                                                                 \
    VKAPI_ATTR void VKAPI_CALL assay_##name(VkCommandBuffer commandBuffer)                         \
    {                                                                                              \
        struct layer_device *state = layer_find_recording_device(commandBuffer);                   \
        if (!state)                                                                                \
            return;                                                                                \
        command_buffer_end_rendering(find(state, commandBuffer));                                  \
        state->vk.name(commandBuffer);                                                             \
    }

#define DEFINE_END_RENDERING_2(name)                                                               \
    VKAPI_ATTR void VKAPI_CALL assay_##name(VkCommandBuffer commandBuffer,                         \
                                            const VkRenderingEndInfoKHR *pRenderingEndInfo)        \
    {                                                                                              \
        struct layer_device *state = layer_find_recording_device(commandBuffer);                   \
        if (!state)                                                                                \
            return;                                                                                \
        command_buffer_end_rendering(find(state, commandBuffer));                                  \
        state->vk.name(commandBuffer, pRenderingEndInfo);                                          \
    }

DEFINE_BEGIN_RENDER_PASS_2(CmdBeginRenderPass2)
DEFINE_BEGIN_RENDER_PASS_2(CmdBeginRenderPass2KHR)
DEFINE_END_RENDER_PASS_2(CmdEndRenderPass2)
DEFINE_END_RENDER_PASS_2(CmdEndRenderPass2KHR)
DEFINE_BEGIN_RENDERING(CmdBeginRendering)
DEFINE_BEGIN_RENDERING(CmdBeginRenderingKHR)
DEFINE_END_RENDERING(CmdEndRendering)
DEFINE_END_RENDERING(CmdEndRenderingKHR)
DEFINE_END_RENDERING_2(CmdEndRendering2KHR)
DEFINE_END_RENDERING_2(CmdEndRendering2EXT)

/* ---- video */

VKAPI_ATTR void VKAPI_CALL assay_CmdBeginVideoCodingKHR(VkCommandBuffer commandBuffer,
                                                        const VkVideoBeginCodingInfoKHR *pBeginInfo)
{
    struct layer_device *state = layer_find_recording_device(commandBuffer);
    if (!state)
        return;
    command_buffer_set_video_coding(find(state, commandBuffer), true);
    state->vk.CmdBeginVideoCodingKHR(commandBuffer, pBeginInfo);
}

VKAPI_ATTR void VKAPI_CALL assay_CmdEndVideoCodingKHR(VkCommandBuffer commandBuffer,
                                                      const VkVideoEndCodingInfoKHR *pEndCodingInfo)
{
    struct layer_device *state = layer_find_recording_device(commandBuffer);
    if (!state)
        return;
    command_buffer_set_video_coding(find(state, commandBuffer), false);
    state->vk.CmdEndVideoCodingKHR(commandBuffer, pEndCodingInfo);
}
