/* SPDX-License-Identifier: Apache-2.0 */
/* Intercepts of micromaps of VK_EXT_opacity_micromap. A command that writes a micromap is recorded
 * in the command buffer's journal, in its order among the builds that use micromaps, or as work of
 * the host. */
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
        resources_add_micromap(state->resources, *pMicromap, pCreateInfo);
    return result;
}

VKAPI_ATTR void VKAPI_CALL assay_DestroyMicromapEXT(VkDevice device, VkMicromapEXT micromap,
                                                    const VkAllocationCallbacks *pAllocator)
{
    struct layer_device *state = layer_find_device(device);
    structures_note_destroyed(state->structures,
                              resources_remove_micromap(state->resources, micromap), 1);
    object_names_set(state->names, VK_OBJECT_TYPE_MICROMAP_EXT, (uint64_t)(uintptr_t)micromap,
                     NULL);
    state->vk.DestroyMicromapEXT(device, micromap, pAllocator);
}

static uint64_t id_of(const struct layer_device *device, VkMicromapEXT micromap)
{
    return resources_find_id(device->resources, RESOURCE_MICROMAP, (uint64_t)(uintptr_t)micromap);
}

/* The journal needs to know that the micromap is written, but not its contents. */
static struct journal_entry write_entry(const struct layer_device *device, enum journal_fill fill,
                                        VkMicromapEXT micromap, VkMicromapEXT src)
{
    return (struct journal_entry){.kind = JOURNAL_FILL,
                                  .info = fill,
                                  .dst = (uint64_t)(uintptr_t)micromap,
                                  .src = (uint64_t)(uintptr_t)src,
                                  .dst_id = id_of(device, micromap)};
}

static struct journal_entry build_entry(const struct layer_device *device,
                                        const VkMicromapBuildInfoEXT *info)
{
    return write_entry(device, FILL_BUILDS_MICROMAP, info->dstMicromap, VK_NULL_HANDLE);
}

static struct journal_entry copy_entry(const struct layer_device *device,
                                       const VkCopyMicromapInfoEXT *info)
{
    bool compacts = info->mode == VK_COPY_MICROMAP_MODE_COMPACT_EXT;
    return write_entry(device, compacts ? FILL_COMPACTS_MICROMAP : FILL_CLONES_MICROMAP, info->dst,
                       info->src);
}

static struct journal_entry read_entry(const struct layer_device *device,
                                       const VkCopyMemoryToMicromapInfoEXT *info)
{
    return write_entry(device, FILL_READS_MICROMAP, info->dst, VK_NULL_HANDLE);
}

/* ---- in command buffers */

static void note_write(const struct layer_device *device, VkCommandBuffer handle,
                       struct journal_entry entry)
{
    struct command_buffer *command_buffer = command_buffers_find(device->command_buffers, handle);
    if (!command_buffer || !command_buffer->journal)
        return;
    journal_begin_call(command_buffer->journal);
    if (!entry.dst_id || device->level < LEVEL_EXECUTION)
        return;
    journal_add(command_buffer->journal, &entry);
    replay_keep(command_buffer);
}

VKAPI_ATTR void VKAPI_CALL assay_CmdBuildMicromapsEXT(VkCommandBuffer commandBuffer,
                                                      uint32_t infoCount,
                                                      const VkMicromapBuildInfoEXT *pInfos)
{
    struct layer_device *device = layer_find_recording_device(commandBuffer);
    if (!device)
        return;
    for (uint32_t i = 0; i < infoCount; i++)
        note_write(device, commandBuffer, build_entry(device, &pInfos[i]));
    device->vk.CmdBuildMicromapsEXT(commandBuffer, infoCount, pInfos);
}

VKAPI_ATTR void VKAPI_CALL assay_CmdCopyMicromapEXT(VkCommandBuffer commandBuffer,
                                                    const VkCopyMicromapInfoEXT *pInfo)
{
    struct layer_device *device = layer_find_recording_device(commandBuffer);
    if (!device)
        return;
    note_write(device, commandBuffer, copy_entry(device, pInfo));
    device->vk.CmdCopyMicromapEXT(commandBuffer, pInfo);
}

VKAPI_ATTR void VKAPI_CALL assay_CmdCopyMemoryToMicromapEXT(
    VkCommandBuffer commandBuffer, const VkCopyMemoryToMicromapInfoEXT *pInfo)
{
    struct layer_device *device = layer_find_recording_device(commandBuffer);
    if (!device)
        return;
    note_write(device, commandBuffer, read_entry(device, pInfo));
    device->vk.CmdCopyMemoryToMicromapEXT(commandBuffer, pInfo);
}

/* ---- on the host */

static void add_write(const struct host_work *work, struct journal_entry entry)
{
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
        add_write(&work, build_entry(state, &pInfos[i]));
    if (host_work_prepare(&work, false))
        return VK_ERROR_VALIDATION_FAILED_EXT;
    VkResult result = state->vk.BuildMicromapsEXT(device, deferredOperation, infoCount, pInfos);
    return host_work_finish(&work, deferredOperation, result);
}

VKAPI_ATTR VkResult VKAPI_CALL assay_CopyMicromapEXT(VkDevice device,
                                                     VkDeferredOperationKHR deferredOperation,
                                                     const VkCopyMicromapInfoEXT *pInfo)
{
    struct layer_device *state = layer_find_device(device);
    struct host_work work = host_work_begin(state);
    add_write(&work, copy_entry(state, pInfo));
    if (host_work_prepare(&work, false))
        return VK_ERROR_VALIDATION_FAILED_EXT;
    VkResult result = state->vk.CopyMicromapEXT(device, deferredOperation, pInfo);
    return host_work_finish(&work, deferredOperation, result);
}

VKAPI_ATTR VkResult VKAPI_CALL
assay_CopyMemoryToMicromapEXT(VkDevice device, VkDeferredOperationKHR deferredOperation,
                              const VkCopyMemoryToMicromapInfoEXT *pInfo)
{
    struct layer_device *state = layer_find_device(device);
    struct host_work work = host_work_begin(state);
    add_write(&work, read_entry(state, pInfo));
    if (host_work_prepare(&work, false))
        return VK_ERROR_VALIDATION_FAILED_EXT;
    VkResult result = state->vk.CopyMemoryToMicromapEXT(device, deferredOperation, pInfo);
    return host_work_finish(&work, deferredOperation, result);
}
