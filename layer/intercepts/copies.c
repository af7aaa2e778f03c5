/* SPDX-License-Identifier: Apache-2.0 */
/* Intercepts of copies between acceleration structures, and from memory into them. A copy in a
 * command buffer is recorded in the journal, in its order among the builds; a copy on the host
 * becomes work of the host. */
#include "layer/compare/comparer.h"
#include "layer/intercepts/host_work.h"
#include "layer/intercepts/intercepts.h"
#include "layer/intercepts/journal_access.h"
#include "src/check/replay/replay.h"

static void note(const struct layer_device *device, VkCommandBuffer handle,
                 const struct journal_entry *entry)
{
    struct command_buffer *command_buffer = command_buffers_find(device->command_buffers, handle);
    if (!command_buffer || !command_buffer->journal)
        return;
    journal_begin_call(command_buffer->journal);
    if (!entry->dst_id || device->level < LEVEL_EXECUTION)
        return;
    journal_add(command_buffer->journal, entry);
    replay_keep(command_buffer);
}

static struct journal_entry copy_entry(const struct layer_device *device,
                                       const VkCopyAccelerationStructureInfoKHR *info)
{
    return (struct journal_entry){
        .kind = info->mode == VK_COPY_ACCELERATION_STRUCTURE_MODE_COMPACT_KHR ? JOURNAL_COMPACT
                                                                              : JOURNAL_COPY,
        .dst = (uint64_t)(uintptr_t)info->dst,
        .src = (uint64_t)(uintptr_t)info->src,
        .dst_id = layer_accel_id(device, info->dst),
        .src_id = layer_accel_id(device, info->src),
    };
}

static struct journal_entry fill_entry(const struct layer_device *device,
                                       VkAccelerationStructureKHR dst)
{
    return (struct journal_entry){.kind = JOURNAL_FILL,
                                  .dst = (uint64_t)(uintptr_t)dst,
                                  .dst_id = layer_accel_id(device, dst)};
}

VKAPI_ATTR void VKAPI_CALL assay_CmdCopyAccelerationStructureKHR(
    VkCommandBuffer commandBuffer, const VkCopyAccelerationStructureInfoKHR *pInfo)
{
    struct layer_device *device = layer_find_recording_device(commandBuffer);
    if (!device)
        return;
    struct journal_entry entry = copy_entry(device, pInfo);
    note(device, commandBuffer, &entry);
    device->vk.CmdCopyAccelerationStructureKHR(commandBuffer, pInfo);
}

VKAPI_ATTR void VKAPI_CALL assay_CmdCopyAccelerationStructureNV(
    VkCommandBuffer commandBuffer, VkAccelerationStructureNV dst, VkAccelerationStructureNV src,
    VkCopyAccelerationStructureModeKHR mode)
{
    struct layer_device *device = layer_find_recording_device(commandBuffer);
    if (!device)
        return;
    uint64_t dst_handle = (uint64_t)(uintptr_t)dst, src_handle = (uint64_t)(uintptr_t)src;
    struct journal_entry entry = {
        .kind = mode == VK_COPY_ACCELERATION_STRUCTURE_MODE_COMPACT_KHR ? JOURNAL_COMPACT
                                                                        : JOURNAL_COPY,
        .command = COMMAND_NV,
        .dst = dst_handle,
        .src = src_handle,
        .dst_id = resources_find_id(device->resources, RESOURCE_ACCEL_NV, dst_handle),
        .src_id = resources_find_id(device->resources, RESOURCE_ACCEL_NV, src_handle),
    };
    note(device, commandBuffer, &entry);
    device->vk.CmdCopyAccelerationStructureNV(commandBuffer, dst, src, mode);
}

VKAPI_ATTR void VKAPI_CALL assay_CmdCopyMemoryToAccelerationStructureKHR(
    VkCommandBuffer commandBuffer, const VkCopyMemoryToAccelerationStructureInfoKHR *pInfo)
{
    struct layer_device *device = layer_find_recording_device(commandBuffer);
    if (!device)
        return;
    struct journal_entry entry = fill_entry(device, pInfo->dst);
    note(device, commandBuffer, &entry);
    device->vk.CmdCopyMemoryToAccelerationStructureKHR(commandBuffer, pInfo);
}

/* ---- on the host */

/* Returns whether to skip the call. */
static bool begin_copy(struct layer_device *device, const struct journal_entry *entry,
                       struct host_work *work)
{
    *work = host_work_begin(device);
    if (work->journal && entry->dst_id)
        journal_add(work->journal, entry);
    return host_work_prepare(work, false);
}

VKAPI_ATTR VkResult VKAPI_CALL
assay_CopyAccelerationStructureKHR(VkDevice device, VkDeferredOperationKHR deferredOperation,
                                   const VkCopyAccelerationStructureInfoKHR *pInfo)
{
    struct layer_device *state = layer_find_device(device);
    struct journal_entry entry = copy_entry(state, pInfo);
    struct host_work work;
    if (begin_copy(state, &entry, &work))
        return VK_ERROR_VALIDATION_FAILED_EXT;
    VkResult result = state->vk.CopyAccelerationStructureKHR(device, deferredOperation, pInfo);
    return host_work_finish(&work, deferredOperation, result);
}

VKAPI_ATTR VkResult VKAPI_CALL assay_CopyMemoryToAccelerationStructureKHR(
    VkDevice device, VkDeferredOperationKHR deferredOperation,
    const VkCopyMemoryToAccelerationStructureInfoKHR *pInfo)
{
    struct layer_device *state = layer_find_device(device);
    struct journal_entry entry = fill_entry(state, pInfo->dst);
    struct host_work work;
    if (begin_copy(state, &entry, &work))
        return VK_ERROR_VALIDATION_FAILED_EXT;
    VkResult result =
        state->vk.CopyMemoryToAccelerationStructureKHR(device, deferredOperation, pInfo);
    return host_work_finish(&work, deferredOperation, result);
}
