/* SPDX-License-Identifier: Apache-2.0 */
/* Observes copies between acceleration structures, and from memory into them. A copy in a
 * command buffer is recorded in the journal, in its order among the builds; a copy on the host
 * becomes work of the host. */
#include "layer/intercepts/intercepts.h"
#include "layer/snapshots/size_queries.h"
#include "observers.h"
#include "src/check/replay/object_states.h"

/* `type`: of both structures. */
static struct journal_entry copy_entry(const struct layer_device *device,
                                       enum build_command command, VkObjectType type,
                                       uint64_t dst_handle, uint64_t src_handle,
                                       VkCopyAccelerationStructureModeKHR mode)
{
    const struct object_facts dst = object_facts_find(device->resources, type, dst_handle);
    const struct object_facts src = object_facts_find(device->resources, type, src_handle);
    struct journal_entry entry =
        journal_copy_entry(command, mode == VK_COPY_ACCELERATION_STRUCTURE_MODE_COMPACT_KHR);
    entry.dst_backing = object_backing(&dst);
    entry.src_backing = object_backing(&src);
    entry.dst = dst_handle;
    entry.src = src_handle;
    entry.dst_id = dst.id;
    entry.src_id = src.id;
    entry.read.dst_size = dst.size;
    return entry;
}

static struct journal_entry khr_copy_entry(const struct layer_device *device,
                                           enum build_command command,
                                           const VkCopyAccelerationStructureInfoKHR *info)
{
    return copy_entry(device, command, VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR,
                      handle_number(info->dst), handle_number(info->src), info->mode);
}

/* `address`: of device memory, or 0. */
static struct journal_entry fill_entry(const struct layer_device *device,
                                       enum build_command command, VkAccelerationStructureKHR dst,
                                       VkDeviceAddress address)
{
    const struct object_facts facts = object_facts_find(
        device->resources, VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR, handle_number(dst));
    struct journal_entry entry = journal_fill_entry(command, FILL_READS_ACCEL);
    entry.dst_backing = object_backing(&facts);
    entry.dst = handle_number(dst);
    entry.dst_id = facts.id;
    entry.src_id = layer_bytes_at(device, address) ? address : 0;
    return entry;
}

/* `address`: of device memory, or 0. */
static struct journal_entry serialize_entry(const struct layer_device *device,
                                            enum build_command command,
                                            VkAccelerationStructureKHR src, VkDeviceAddress address)
{
    const struct object_facts facts = object_facts_find(
        device->resources, VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR, handle_number(src));
    struct journal_entry entry = journal_read_entry(command, VK_QUERY_TYPE_MAX_ENUM);
    entry.src_backing = object_backing(&facts);
    entry.dst = address;
    entry.src = handle_number(src);
    entry.src_id = facts.id;
    entry.read.dst_size = layer_bytes_at(device, address);
    return entry;
}

bool note_accel_copy(struct layer_device *device, VkCommandBuffer handle,
                     const VkCopyAccelerationStructureInfoKHR *info)
{
    struct journal_entry entry =
        khr_copy_entry(device, COMMAND_CmdCopyAccelerationStructureKHR, info);
    return layer_record(device, handle, &entry, 1);
}

bool note_nv_copy(struct layer_device *device, VkCommandBuffer handle,
                  VkAccelerationStructureNV dst, VkAccelerationStructureNV src,
                  VkCopyAccelerationStructureModeKHR mode)
{
    struct journal_entry entry = copy_entry(device, COMMAND_CmdCopyAccelerationStructureNV,
                                            VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_NV,
                                            handle_number(dst), handle_number(src), mode);
    return layer_record(device, handle, &entry, 1);
}

bool note_accel_read(struct layer_device *device, VkCommandBuffer handle,
                     const VkCopyMemoryToAccelerationStructureInfoKHR *info)
{
    struct journal_entry entry = fill_entry(device, COMMAND_CmdCopyMemoryToAccelerationStructureKHR,
                                            info->dst, info->src.deviceAddress);
    return layer_record(device, handle, &entry, 1);
}

bool note_accel_write(struct layer_device *device, VkCommandBuffer handle,
                      const VkCopyAccelerationStructureToMemoryInfoKHR *info)
{
    struct journal_entry entry =
        serialize_entry(device, COMMAND_CmdCopyAccelerationStructureToMemoryKHR, info->src,
                        info->dst.deviceAddress);
    return layer_record(device, handle, &entry, 1);
}

/* ---- on the host */

static struct host_work begin_host_copy(struct layer_device *device, struct journal_entry *entry)
{
    struct host_work work = host_work_begin(device);
    if (journal_entry_writes(entry) ? entry->dst_id : entry->src_id)
        host_work_add(&work, entry);
    return work;
}

/* Queries the compacted size of src before the copy is validated. A deferred copy executes
 * later, perhaps behind the build of src. */
static void query_size(struct layer_device *device, const VkCopyAccelerationStructureInfoKHR *info)
{
    const VkQueryType type = VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_KHR;
    const PFN_vkWriteAccelerationStructuresPropertiesKHR query =
        device->vk.WriteAccelerationStructuresPropertiesKHR;
    uint64_t size = 0;
    if (device->level < LEVEL_EXECUTION || !device->facts.acceleration_structure_host_commands ||
        !size_query_is_needed(device, info))
        return;
    struct journal *reading = begin_size_reading(device, type);
    const VkResult result =
        query(device->handle, 1, &info->src, type, sizeof(size), &size, sizeof(size));
    note_sizes(device, reading, 1, &info->src, type, sizeof(size), &size, sizeof(size), result);
}

struct host_work begin_accel_copy(struct layer_device *device, VkDeferredOperationKHR operation,
                                  const VkCopyAccelerationStructureInfoKHR *info)
{
    if (!operation)
        query_size(device, info);
    struct journal_entry entry = khr_copy_entry(device, COMMAND_CopyAccelerationStructureKHR, info);
    return begin_host_copy(device, &entry);
}

struct host_work begin_accel_read(struct layer_device *device,
                                  const VkCopyMemoryToAccelerationStructureInfoKHR *info)
{
    struct journal_entry entry =
        fill_entry(device, COMMAND_CopyMemoryToAccelerationStructureKHR, info->dst, 0);
    struct host_work work = host_work_begin(device);
    if (!work.journal || !entry.dst_id)
        return work;
    entry.built = (struct built){
        .state = BUILT_FILLED, .shapes = find_referenced_micromaps(device, info->src.hostAddress)};
    host_work_add(&work, &entry);
    return work;
}

struct host_work begin_accel_write(struct layer_device *device,
                                   const VkCopyAccelerationStructureToMemoryInfoKHR *info)
{
    struct journal_entry entry =
        serialize_entry(device, COMMAND_CopyAccelerationStructureToMemoryKHR, info->src, 0);
    return begin_host_copy(device, &entry);
}
