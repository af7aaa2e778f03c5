/* SPDX-License-Identifier: Apache-2.0 */
/* Observes copies between acceleration structures, and from memory into them. A copy in a
 * command buffer is recorded in the journal, in its order among the builds; a copy on the host
 * becomes work of the host. */
#include "layer/compare/comparer.h"
#include "layer/intercepts/intercepts.h"
#include "observers.h"
#include "src/state/resources/nv_shape.h"

static unsigned char backing_of(enum tristate backed)
{
    return backed == YES ? BACKED_BY_MEMORY : 0;
}

static struct journal_entry copy_entry(const struct layer_device *device,
                                       enum build_command command,
                                       const VkCopyAccelerationStructureInfoKHR *info)
{
    const bool compacts = info->mode == VK_COPY_ACCELERATION_STRUCTURE_MODE_COMPACT_KHR;
    struct accel_facts dst, src;
    resources_look_up_accel(device->resources, info->dst, &dst);
    resources_look_up_accel(device->resources, info->src, &src);
    return (struct journal_entry){
        .dst_backing = backing_of(dst.backed),
        .src_backing = backing_of(src.backed),
        .kind = compacts ? JOURNAL_COMPACT : JOURNAL_COPY,
        .command = (unsigned char)command,
        .dst = (uint64_t)(uintptr_t)info->dst,
        .src = (uint64_t)(uintptr_t)info->src,
        .dst_id = dst.id,
        .src_id = src.id,
        .read = {.compacts = compacts,
                 .query = VK_QUERY_TYPE_MAX_ENUM,
                 .dst_size = dst.details_known ? dst.size : 0},
    };
}

/* `address`: of device memory, or 0. */
static struct journal_entry fill_entry(const struct layer_device *device,
                                       enum build_command command, VkAccelerationStructureKHR dst,
                                       VkDeviceAddress address)
{
    struct accel_facts facts;
    resources_look_up_accel(device->resources, dst, &facts);
    return (struct journal_entry){.kind = JOURNAL_FILL,
                                  .command = (unsigned char)command,
                                  .dst_backing = backing_of(facts.backed),
                                  .dst = (uint64_t)(uintptr_t)dst,
                                  .dst_id = facts.id,
                                  .src_id = layer_bytes_at(device, address) ? address : 0};
}

/* `address`: of device memory, or 0. */
static struct journal_entry serialize_entry(const struct layer_device *device,
                                            enum build_command command,
                                            VkAccelerationStructureKHR src, VkDeviceAddress address)
{
    struct accel_facts facts;
    resources_look_up_accel(device->resources, src, &facts);
    return (struct journal_entry){
        .kind = JOURNAL_READ,
        .command = (unsigned char)command,
        .src_backing = backing_of(facts.backed),
        .dst = address,
        .src = (uint64_t)(uintptr_t)src,
        .src_id = facts.id,
        .read = {.query = VK_QUERY_TYPE_MAX_ENUM, .dst_size = layer_bytes_at(device, address)}};
}

bool note_accel_copy(struct layer_device *device, VkCommandBuffer handle,
                     const VkCopyAccelerationStructureInfoKHR *info)
{
    struct journal_entry entry = copy_entry(device, COMMAND_CmdCopyAccelerationStructureKHR, info);
    return layer_record(device, handle, &entry, 1);
}

bool note_nv_copy(struct layer_device *device, VkCommandBuffer handle,
                  VkAccelerationStructureNV dst, VkAccelerationStructureNV src,
                  VkCopyAccelerationStructureModeKHR mode)
{
    const bool compacts = mode == VK_COPY_ACCELERATION_STRUCTURE_MODE_COMPACT_KHR;
    uint64_t dst_handle = (uint64_t)(uintptr_t)dst, src_handle = (uint64_t)(uintptr_t)src;
    struct nv_accel_facts facts, facts_of_src;
    resources_look_up_nv_accel(device->resources, dst, &facts);
    nv_shape_release(facts.created);
    resources_look_up_nv_accel(device->resources, src, &facts_of_src);
    nv_shape_release(facts_of_src.created);
    struct journal_entry entry = {
        .dst_backing = backing_of(facts.binding == NV_BOUND ? YES : UNKNOWN),
        .src_backing = backing_of(facts_of_src.binding == NV_BOUND ? YES : UNKNOWN),
        .kind = compacts ? JOURNAL_COMPACT : JOURNAL_COPY,
        .command = COMMAND_CmdCopyAccelerationStructureNV,
        .dst = dst_handle,
        .src = src_handle,
        .dst_id = facts.id,
        .src_id = facts_of_src.id,
        .read = {.compacts = compacts,
                 .query = VK_QUERY_TYPE_MAX_ENUM,
                 .dst_size = facts.sizes.known ? facts.sizes.object : 0},
    };
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
    if (entry->kind == JOURNAL_READ ? entry->src_id : entry->dst_id)
        host_work_add(&work, entry);
    return work;
}

struct host_work begin_accel_copy(struct layer_device *device,
                                  const VkCopyAccelerationStructureInfoKHR *info)
{
    struct journal_entry entry = copy_entry(device, COMMAND_CopyAccelerationStructureKHR, info);
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
