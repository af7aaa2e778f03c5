/* SPDX-License-Identifier: Apache-2.0 */
/* Intercepts of micromaps of VK_EXT_opacity_micromap. A command that writes a micromap is recorded
 * in the command buffer's journal, in its order among the builds that use micromaps, or as work of
 * the host. */
#include "layer/execution/submissions.h"
#include "layer/intercepts/host_work.h"
#include "layer/intercepts/intercepts.h"
#include "layer/intercepts/journal_access.h"
#include "src/check/replay/replay.h"

VKAPI_ATTR VkResult VKAPI_CALL assay_CreateMicromapEXT(VkDevice device,
                                                       const VkMicromapCreateInfoEXT *pCreateInfo,
                                                       const VkAllocationCallbacks *pAllocator,
                                                       VkMicromapEXT *pMicromap)
{
    struct layer_device *state = layer_find_device(device);
    VkResult result = state->vk.CreateMicromapEXT(device, pCreateInfo, pAllocator, pMicromap);
    if (result == VK_SUCCESS)
        resources_add_micromap(state->resources, *pMicromap, pCreateInfo->type);
    return result;
}

VKAPI_ATTR void VKAPI_CALL assay_DestroyMicromapEXT(VkDevice device, VkMicromapEXT micromap,
                                                    const VkAllocationCallbacks *pAllocator)
{
    struct layer_device *state = layer_find_device(device);
    submissions_forget(state->submissions, resources_remove_micromap(state->resources, micromap),
                       1);
    object_names_set(state->names, VK_OBJECT_TYPE_MICROMAP_EXT, (uint64_t)(uintptr_t)micromap,
                     NULL);
    state->vk.DestroyMicromapEXT(device, micromap, pAllocator);
}

static uint64_t id_of(const struct layer_device *device, VkMicromapEXT micromap)
{
    return resources_find_id(device->resources, RESOURCE_MICROMAP, (uint64_t)(uintptr_t)micromap);
}

/* The journal needs to know that the micromap is written, but not its contents. */
static struct journal_entry write_entry(const struct layer_device *device, VkMicromapEXT micromap)
{
    return (struct journal_entry){.kind = JOURNAL_FILL,
                                  .dst = (uint64_t)(uintptr_t)micromap,
                                  .dst_id = id_of(device, micromap)};
}

/* ---- in command buffers */

static void note_write(const struct layer_device *device, VkCommandBuffer handle,
                       VkMicromapEXT micromap)
{
    struct command_buffer *command_buffer = layer_find_recording(device, handle);
    const struct journal_entry entry = write_entry(device, micromap);
    if (!command_buffer || !entry.dst_id)
        return;
    struct journal_mark mark = journal_mark(command_buffer->journal);
    journal_add(command_buffer->journal, &entry);
    replay_keep(command_buffer, &mark);
}

VKAPI_ATTR void VKAPI_CALL assay_CmdBuildMicromapsEXT(VkCommandBuffer commandBuffer,
                                                      uint32_t infoCount,
                                                      const VkMicromapBuildInfoEXT *pInfos)
{
    struct layer_device *device = layer_find_recording_device(commandBuffer);
    if (!device)
        return;
    for (uint32_t i = 0; i < infoCount; i++)
        note_write(device, commandBuffer, pInfos[i].dstMicromap);
    device->vk.CmdBuildMicromapsEXT(commandBuffer, infoCount, pInfos);
}

VKAPI_ATTR void VKAPI_CALL assay_CmdCopyMicromapEXT(VkCommandBuffer commandBuffer,
                                                    const VkCopyMicromapInfoEXT *pInfo)
{
    struct layer_device *device = layer_find_recording_device(commandBuffer);
    if (!device)
        return;
    note_write(device, commandBuffer, pInfo->dst);
    device->vk.CmdCopyMicromapEXT(commandBuffer, pInfo);
}

VKAPI_ATTR void VKAPI_CALL assay_CmdCopyMemoryToMicromapEXT(
    VkCommandBuffer commandBuffer, const VkCopyMemoryToMicromapInfoEXT *pInfo)
{
    struct layer_device *device = layer_find_recording_device(commandBuffer);
    if (!device)
        return;
    note_write(device, commandBuffer, pInfo->dst);
    device->vk.CmdCopyMemoryToMicromapEXT(commandBuffer, pInfo);
}

/* ---- on the host */

static void add_write(struct host_work *work, VkMicromapEXT micromap)
{
    const struct journal_entry entry = write_entry(work->device, micromap);
    if (work->journal && entry.dst_id)
        journal_add(work->journal, &entry);
}

VKAPI_ATTR VkResult VKAPI_CALL assay_BuildMicromapsEXT(VkDevice device,
                                                       VkDeferredOperationKHR deferredOperation,
                                                       uint32_t infoCount,
                                                       const VkMicromapBuildInfoEXT *pInfos)
{
    struct layer_device *state = layer_find_device(device);
    struct host_work work = host_work_begin(state);
    for (uint32_t i = 0; i < infoCount; i++)
        add_write(&work, pInfos[i].dstMicromap);
    host_work_prepare(&work, false);
    VkResult result = state->vk.BuildMicromapsEXT(device, deferredOperation, infoCount, pInfos);
    return host_work_finish(&work, deferredOperation, result);
}

VKAPI_ATTR VkResult VKAPI_CALL assay_CopyMicromapEXT(VkDevice device,
                                                     VkDeferredOperationKHR deferredOperation,
                                                     const VkCopyMicromapInfoEXT *pInfo)
{
    struct layer_device *state = layer_find_device(device);
    struct host_work work = host_work_begin(state);
    add_write(&work, pInfo->dst);
    host_work_prepare(&work, false);
    VkResult result = state->vk.CopyMicromapEXT(device, deferredOperation, pInfo);
    return host_work_finish(&work, deferredOperation, result);
}

VKAPI_ATTR VkResult VKAPI_CALL
assay_CopyMemoryToMicromapEXT(VkDevice device, VkDeferredOperationKHR deferredOperation,
                              const VkCopyMemoryToMicromapInfoEXT *pInfo)
{
    struct layer_device *state = layer_find_device(device);
    struct host_work work = host_work_begin(state);
    add_write(&work, pInfo->dst);
    host_work_prepare(&work, false);
    VkResult result = state->vk.CopyMemoryToMicromapEXT(device, deferredOperation, pInfo);
    return host_work_finish(&work, deferredOperation, result);
}
