/* SPDX-License-Identifier: Apache-2.0 */
/* Intercepts of copies between acceleration structures, and from memory into them: what they write
 * is noted in the command buffer's journal, in its place among the builds. Of what the host's forms
 * write nothing is said. */
#include "check/replay.h"
#include "intercepts.h"
#include "recording.h"
#include "submissions.h"

static void note(const struct layer_device *device, VkCommandBuffer handle,
                 const struct journal_entry *entry)
{
    struct command_buffer *command_buffer =
        entry->dst_id ? layer_find_recording(device, handle) : NULL;
    if (!command_buffer)
        return;
    struct journal_mark mark = journal_mark(command_buffer->journal);
    journal_add(command_buffer->journal, entry);
    replay_keep(command_buffer, &mark);
}

VKAPI_ATTR void VKAPI_CALL assay_CmdCopyAccelerationStructureKHR(
    VkCommandBuffer commandBuffer, const VkCopyAccelerationStructureInfoKHR *pInfo)
{
    struct layer_device *device = layer_find_device(commandBuffer);
    struct journal_entry entry = {
        .kind = pInfo->mode == VK_COPY_ACCELERATION_STRUCTURE_MODE_COMPACT_KHR ? JOURNAL_COMPACT
                                                                               : JOURNAL_COPY,
        .dst = (uint64_t)(uintptr_t)pInfo->dst,
        .src = (uint64_t)(uintptr_t)pInfo->src,
        .dst_id = layer_accel_id(device, pInfo->dst),
        .src_id = layer_accel_id(device, pInfo->src),
    };
    note(device, commandBuffer, &entry);
    device->vk.CmdCopyAccelerationStructureKHR(commandBuffer, pInfo);
}

VKAPI_ATTR void VKAPI_CALL assay_CmdCopyMemoryToAccelerationStructureKHR(
    VkCommandBuffer commandBuffer, const VkCopyMemoryToAccelerationStructureInfoKHR *pInfo)
{
    struct layer_device *device = layer_find_device(commandBuffer);
    struct journal_entry entry = {.kind = JOURNAL_FILL,
                                  .dst = (uint64_t)(uintptr_t)pInfo->dst,
                                  .dst_id = layer_accel_id(device, pInfo->dst)};
    note(device, commandBuffer, &entry);
    device->vk.CmdCopyMemoryToAccelerationStructureKHR(commandBuffer, pInfo);
}

/* ---- on the host */

static VkResult copied_by_host(struct layer_device *device, VkAccelerationStructureKHR dst,
                               VkResult result)
{
    submissions_taint(device->submissions, layer_accel_id(device, dst));
    return result;
}

VKAPI_ATTR VkResult VKAPI_CALL
assay_CopyAccelerationStructureKHR(VkDevice device, VkDeferredOperationKHR deferredOperation,
                                   const VkCopyAccelerationStructureInfoKHR *pInfo)
{
    struct layer_device *state = layer_find_device(device);
    return copied_by_host(state, pInfo->dst,
                          state->vk.CopyAccelerationStructureKHR(device, deferredOperation, pInfo));
}

VKAPI_ATTR VkResult VKAPI_CALL assay_CopyMemoryToAccelerationStructureKHR(
    VkDevice device, VkDeferredOperationKHR deferredOperation,
    const VkCopyMemoryToAccelerationStructureInfoKHR *pInfo)
{
    struct layer_device *state = layer_find_device(device);
    return copied_by_host(
        state, pInfo->dst,
        state->vk.CopyMemoryToAccelerationStructureKHR(device, deferredOperation, pInfo));
}
