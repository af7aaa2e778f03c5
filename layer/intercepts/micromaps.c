/* SPDX-License-Identifier: Apache-2.0 */
/* Observes micromaps of VK_EXT_opacity_micromap. A command that writes a micromap is recorded
 * in the command buffer's journal, in its order among the builds that use micromaps, or as work of
 * the host. */
#include "layer/execution/build_records.h"
#include "layer/intercepts/intercepts.h"
#include "observers.h"
#include "src/check/replay/object_states.h"

void note_micromap(struct layer_device *device, VkMicromapEXT micromap,
                   const VkMicromapCreateInfoEXT *info)
{
    resources_add_micromap(device->resources, micromap, info);
}

void forget_micromap(struct layer_device *device, VkMicromapEXT micromap)
{
    build_records_add_destroyed(device, VK_OBJECT_TYPE_MICROMAP_EXT, handle_number(micromap));
    const uint64_t id = resources_remove_micromap(device->resources, micromap);
    structures_note_destroyed(device->structures, id, 1);
    object_names_end(device->names, VK_OBJECT_TYPE_MICROMAP_EXT, handle_number(micromap), id);
}

static struct object_facts facts_of(const struct layer_device *device, VkMicromapEXT micromap)
{
    return object_facts_find(device->resources, VK_OBJECT_TYPE_MICROMAP_EXT,
                             handle_number(micromap));
}

static struct journal_entry write_entry(const struct layer_device *device,
                                        enum build_command command, enum journal_fill fill,
                                        VkMicromapEXT micromap, VkMicromapEXT src)
{
    const struct object_facts facts = facts_of(device, micromap);
    struct journal_entry entry = journal_fill_entry(command, fill);
    entry.dst_backing = object_backing(&facts);
    entry.dst = handle_number(micromap);
    entry.src = handle_number(src);
    entry.dst_id = facts.id;
    return entry;
}

static struct journal_entry read_entry(const struct layer_device *device,
                                       enum build_command command, VkMicromapEXT src)
{
    const struct object_facts facts = facts_of(device, src);
    struct journal_entry entry = journal_read_entry(command, VK_QUERY_TYPE_MAX_ENUM);
    entry.src_backing = object_backing(&facts);
    entry.src = handle_number(src);
    entry.src_id = facts.id;
    return entry;
}

static struct journal_entry build_entry(const struct layer_device *device,
                                        enum build_command command,
                                        const VkMicromapBuildInfoEXT *info)
{
    struct journal_entry entry =
        write_entry(device, command, FILL_BUILDS_MICROMAP, info->dstMicromap, VK_NULL_HANDLE);
    entry.built = (struct built){.state = BUILT_FILLED, .is_micromap = true, .flags = info->flags};
    return entry;
}

/* What a copy reads, and what it writes. */
static void set_copy(const struct layer_device *device, enum build_command command,
                     const VkCopyMicromapInfoEXT *info, struct journal_entry entries[2])
{
    const bool compacts = info->mode == VK_COPY_MICROMAP_MODE_COMPACT_EXT;
    entries[0] = read_entry(device, command, info->src);
    entries[0].read.compacts = compacts;
    entries[1] =
        write_entry(device, command, compacts ? FILL_COMPACTS_MICROMAP : FILL_CLONES_MICROMAP,
                    info->dst, info->src);
}

/* ---- in command buffers */

void note_micromap_builds(struct layer_device *device, VkCommandBuffer handle, uint32_t count,
                          const VkMicromapBuildInfoEXT *infos)
{
    for (uint32_t i = 0; i < count; i++) {
        struct journal_entry entry = build_entry(device, COMMAND_CmdBuildMicromapsEXT, &infos[i]);
        entry.built.position = i;
        layer_record(device, handle, &entry, 1);
    }
}

bool note_micromap_copy(struct layer_device *device, VkCommandBuffer handle,
                        const VkCopyMicromapInfoEXT *info)
{
    struct journal_entry entries[2];
    set_copy(device, COMMAND_CmdCopyMicromapEXT, info, entries);
    return layer_record(device, handle, entries, 2);
}

void note_micromap_read(struct layer_device *device, VkCommandBuffer handle,
                        const VkCopyMemoryToMicromapInfoEXT *info)
{
    struct journal_entry entry = write_entry(device, COMMAND_CmdCopyMemoryToMicromapEXT,
                                             FILL_READS_MICROMAP, info->dst, VK_NULL_HANDLE);
    if (layer_bytes_at(device, info->src.deviceAddress))
        entry.src_id = info->src.deviceAddress;
    layer_record(device, handle, &entry, 1);
}

bool note_micromap_write(struct layer_device *device, VkCommandBuffer handle,
                         const VkCopyMicromapToMemoryInfoEXT *info)
{
    struct journal_entry entry = read_entry(device, COMMAND_CmdCopyMicromapToMemoryEXT, info->src);
    entry.dst = info->dst.deviceAddress;
    entry.read.dst_size = layer_bytes_at(device, info->dst.deviceAddress);
    return layer_record(device, handle, &entry, 1);
}

/* ---- on the host */

static struct host_work begin_micromap_work(struct layer_device *device,
                                            struct journal_entry *entries, uint32_t count)
{
    struct host_work work = host_work_begin(device);
    for (uint32_t i = 0; work.journal && i < count; i++)
        if (entries[i].src_id || entries[i].dst_id)
            host_work_add(&work, &entries[i]);
    return work;
}

struct host_work begin_micromap_builds(struct layer_device *device, uint32_t count,
                                       const VkMicromapBuildInfoEXT *infos)
{
    struct host_work work = host_work_begin(device);
    for (uint32_t i = 0; work.journal && i < count; i++) {
        struct journal_entry entry = build_entry(device, COMMAND_BuildMicromapsEXT, &infos[i]);
        if (entry.dst_id)
            host_work_add(&work, &entry);
    }
    return work;
}

struct host_work begin_micromap_copy(struct layer_device *device, const VkCopyMicromapInfoEXT *info)
{
    struct journal_entry entries[2];
    set_copy(device, COMMAND_CopyMicromapEXT, info, entries);
    return begin_micromap_work(device, entries, 2);
}

struct host_work begin_micromap_read(struct layer_device *device,
                                     const VkCopyMemoryToMicromapInfoEXT *info)
{
    struct journal_entry entry = write_entry(device, COMMAND_CopyMemoryToMicromapEXT,
                                             FILL_READS_MICROMAP, info->dst, VK_NULL_HANDLE);
    return begin_micromap_work(device, &entry, 1);
}

struct host_work begin_micromap_write(struct layer_device *device,
                                      const VkCopyMicromapToMemoryInfoEXT *info)
{
    struct journal_entry entry = read_entry(device, COMMAND_CopyMicromapToMemoryEXT, info->src);
    return begin_micromap_work(device, &entry, 1);
}
