/* SPDX-License-Identifier: Apache-2.0 */
/* Observes micromaps of VK_EXT_opacity_micromap. A command that writes a micromap is recorded
 * in the command buffer's journal, in its order among the builds that use micromaps, or as work of
 * the host. */
#include "layer/intercepts/host_work.h"
#include "layer/intercepts/journal_access.h"
#include "observers.h"
#include "src/check/replay/replay.h"

void note_micromap(struct layer_device *device, VkMicromapEXT micromap,
                   const VkMicromapCreateInfoEXT *info)
{
    resources_add_micromap(device->resources, micromap, info);
}

void forget_micromap(struct layer_device *device, VkMicromapEXT micromap)
{
    structures_note_destroyed(device->structures,
                              resources_remove_micromap(device->resources, micromap), 1);
    object_names_set(device->names, VK_OBJECT_TYPE_MICROMAP_EXT, (uint64_t)(uintptr_t)micromap,
                     NULL);
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

void note_micromap_builds(struct layer_device *device, VkCommandBuffer handle, uint32_t count,
                          const VkMicromapBuildInfoEXT *infos)
{
    for (uint32_t i = 0; i < count; i++)
        note_write(device, handle, build_entry(device, &infos[i]));
}

void note_micromap_copy(struct layer_device *device, VkCommandBuffer handle,
                        const VkCopyMicromapInfoEXT *info)
{
    note_write(device, handle, copy_entry(device, info));
}

void note_micromap_read(struct layer_device *device, VkCommandBuffer handle,
                        const VkCopyMemoryToMicromapInfoEXT *info)
{
    note_write(device, handle, read_entry(device, info));
}

/* ---- on the host */

static void add_write(const struct host_work *work, struct journal_entry entry)
{
    if (work->journal && entry.dst_id)
        journal_add(work->journal, &entry);
}

struct host_work begin_micromap_builds(struct layer_device *device, uint32_t count,
                                       const VkMicromapBuildInfoEXT *infos)
{
    struct host_work work = host_work_begin(device);
    for (uint32_t i = 0; i < count; i++)
        add_write(&work, build_entry(device, &infos[i]));
    return work;
}

struct host_work begin_micromap_copy(struct layer_device *device, const VkCopyMicromapInfoEXT *info)
{
    struct host_work work = host_work_begin(device);
    add_write(&work, copy_entry(device, info));
    return work;
}

struct host_work begin_micromap_read(struct layer_device *device,
                                     const VkCopyMemoryToMicromapInfoEXT *info)
{
    struct host_work work = host_work_begin(device);
    add_write(&work, read_entry(device, info));
    return work;
}
