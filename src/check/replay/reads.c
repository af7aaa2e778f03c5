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
    };
    walk_used_source(&judge.walk, &view, &judge.location);
}

/* The compacted size of a compacted structure is unknown: it is that of its source or less. */
void judge_copy_size(struct replay *replay, const struct journal *journal,
                     const struct journal_entry *entry, const struct built *source)
{
    const struct compacted_size *compacted = source->compacted_size;
    if (!entry->read.dst_size || source->state != BUILT_BEFORE || !compacted || !compacted->size ||
        (source->compacted && entry->read.compacts))
        return;
    struct judge judge;
    judge_begin_read(&judge, replay, journal, entry);
    const struct sized_copy_view view = {
        .src = entry->src,
        .dst = entry->dst,
        .compacts = entry->read.compacts,
        .dst_size = entry->read.dst_size,
        .compacted_size = compacted->size,
    };
    walk_sized_copy(&judge.walk, &view, &judge.location);
}
