/* SPDX-License-Identifier: Apache-2.0 */
/* Evaluates the rules about copies, queries and serializations when they execute. */
#include "src/check/replay/reads.h"

#include "src/check/walk/rows.h"

static WALK_ALL(used_source) static WALK_ALL(sized_copy)

    static VkObjectType type_of_source(const struct journal_entry *entry)
{
    if (journal_entry_reads_micromap(entry))
        return VK_OBJECT_TYPE_MICROMAP_EXT;
    return journal_entry_is_nv(entry) ? VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_NV
                                      : VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR;
}

/* Returns a micromap that the source refers to by deserialized data, and that was certainly not
 * deserialized; or 0. */
static uint64_t undeserialized_micromap(struct replay *replay, const struct built *source)
{
    const struct geometry_shapes *shapes = source->state == BUILT_FILLED ? source->shapes : NULL;
    for (uint32_t i = 0; shapes && i < shapes->count; i++) {
        const struct micromap_shape micromap = built_micromap_shape(shapes, i);
        const struct built *built = replay_read(
            replay, &(struct journal_entry){
                        .kind = JOURNAL_COPY, .src = micromap.handle, .src_id = micromap.id});
        if (built->state == BUILT_NEVER || (built->state == BUILT_BEFORE && built->is_original))
            return micromap.handle;
    }
    return 0;
}

void judge_read(struct replay *replay, const struct journal *journal,
                const struct journal_entry *entry, const struct built *source)
{
    if (source->state == BUILT_UNKNOWN)
        return;
    struct judge judge;
    judge_begin_read(&judge, replay, journal, entry);
    const struct used_source_view view = {
        .object_type = type_of_source(entry),
        .handle = entry->src,
        .read = &entry->read,
        .built = source,
        .micromap = undeserialized_micromap(replay, source),
    };
    walk_used_source(&judge.walk, &view, &judge.location);
}

/* Returns the bytes that a copy certainly writes, as the host has read; 0: unknown. The compacted
 * size of a compacted structure is unknown: it is that of its source or less. */
static VkDeviceSize queried_size(const struct journal_entry *entry, const struct built *source)
{
    const struct compacted_size *sizes = source->compacted_size;
    if (entry->kind == JOURNAL_READ)
        return sizes->serialized_id == entry->src_id ? sizes->serialized : 0;
    return source->state != BUILT_BEFORE || (source->compacted && entry->read.compacts)
               ? 0
               : sizes->size;
}

/* Returns the bytes for dst. The application may have placed another buffer at the address of a
 * serialization since the command was recorded. */
static VkDeviceSize size_of_dst(const struct replay *replay, const struct journal_entry *entry)
{
    struct address_facts now;
    if (entry->kind != JOURNAL_READ)
        return entry->read.dst_size;
    resources_look_up_address(replay->resources, entry->dst, &now);
    return now.status == ADDRESS_IN_BUFFER && now.bytes_left > entry->read.dst_size
               ? now.bytes_left
               : entry->read.dst_size;
}

void judge_copy_size(struct replay *replay, const struct journal *journal,
                     const struct journal_entry *entry, const struct built *source)
{
    const VkDeviceSize size =
        entry->read.dst_size && source->compacted_size ? queried_size(entry, source) : 0;
    if (size <= entry->read.dst_size)
        return;
    struct judge judge;
    judge_begin_read(&judge, replay, journal, entry);
    const struct sized_copy_view view = {
        .object_type = type_of_source(entry),
        .src = entry->src,
        .dst = entry->dst,
        .serializes = entry->kind == JOURNAL_READ,
        .compacts = entry->read.compacts,
        .dst_size = size_of_dst(replay, entry),
        .queried_size = size,
    };
    walk_sized_copy(&judge.walk, &view, &judge.location);
}
