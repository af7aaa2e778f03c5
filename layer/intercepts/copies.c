/* SPDX-License-Identifier: Apache-2.0 */
/* Observes copies between acceleration structures, and from memory into them. A copy in a
 * command buffer is recorded in the journal, in its order among the builds; a copy on the host
 * becomes work of the host. */
#include "layer/compare/comparer.h"
#include "layer/intercepts/host_work.h"
#include "layer/intercepts/journal_access.h"
#include "observers.h"
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

void note_accel_copy(struct layer_device *device, VkCommandBuffer handle,
                     const VkCopyAccelerationStructureInfoKHR *info)
{
    struct journal_entry entry = copy_entry(device, info);
    note(device, handle, &entry);
}

void note_nv_copy(struct layer_device *device, VkCommandBuffer handle,
                  VkAccelerationStructureNV dst, VkAccelerationStructureNV src,
                  VkCopyAccelerationStructureModeKHR mode)
{
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
    note(device, handle, &entry);
}

void note_accel_read(struct layer_device *device, VkCommandBuffer handle,
                     const VkCopyMemoryToAccelerationStructureInfoKHR *info)
{
    struct journal_entry entry = fill_entry(device, info->dst);
    note(device, handle, &entry);
}

/* ---- on the host */

static struct host_work begin(struct layer_device *device, const struct journal_entry *entry)
{
    struct host_work work = host_work_begin(device);
    if (work.journal && entry->dst_id)
        journal_add(work.journal, entry);
    return work;
}

struct host_work begin_accel_copy(struct layer_device *device,
                                  const VkCopyAccelerationStructureInfoKHR *info)
{
    struct journal_entry entry = copy_entry(device, info);
    return begin(device, &entry);
}

struct host_work begin_accel_read(struct layer_device *device,
                                  const VkCopyMemoryToAccelerationStructureInfoKHR *info)
{
    struct journal_entry entry = fill_entry(device, info->dst);
    return begin(device, &entry);
}

/* With setting hazards only: the work writes no structure. */
struct host_work begin_accel_write(struct layer_device *device)
{
    struct host_work work = host_work_begin(device);
    host_work_prepare(&work, false);
    return work;
}
