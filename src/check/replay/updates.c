/* SPDX-License-Identifier: Apache-2.0 */
/* Evaluates the rules about an update, its geometries and their extensions. */
#include "src/check/replay/updates.h"

#include "src/check/replay/micromap.h"

void judge_updated_geometries(struct judge *judge, const struct update_view *update)
{
    const struct geometry_shapes *asked = update->asked->shapes, *source = update->source->shapes;
    if (!asked || !source || asked->count != source->count)
        return;
    struct location location = judge->location;
    for (uint32_t i = 0; i < asked->count; i++) {
        struct updated_geometry_view geometry = {
            .update = update, .index = i, .asked = &asked->items[i], .source = &source->items[i]};
        location.geometry = i;
        location.subject =
            location.command == COMMAND_NV && asked->items[i].type == VK_GEOMETRY_TYPE_INSTANCES_KHR
                ? SUBJECT_PARAMETER
                : SUBJECT_GEOMETRY;
        walk_updated_geometry(&judge->walk, &geometry, &location);
        judge_updated_micromap(&judge->walk, &geometry, &location);
    }
}

static void judge_dense(struct judge *judge, const struct update_view *update)
{
    const struct geometry_shapes *asked = update->asked->shapes, *source = update->source->shapes;
    if (!asked || !source || asked->count != source->count)
        return;
    struct location location = judge->location;
    location.subject = SUBJECT_GEOMETRY;
    const struct dense_shape *now = built_dense_shapes(asked), *then = built_dense_shapes(source);
    const struct dense_shape *end = then + source->dense_count;
    for (uint32_t i = 0; i < asked->dense_count; i++, now++) {
        while (then < end && then->geometry < now->geometry)
            then++;
        if (then == end || then->geometry != now->geometry)
            continue;
        struct updated_dense_view dense = {.update = update, .asked = now, .source = then};
        location.geometry = now->geometry;
        walk_updated_dense(&judge->walk, &dense, &location);
    }
}

/* Returns the size that the dst of an update needs: the size of a build or, if the source is
 * compacted, the smaller compacted size. Returns 0 if neither is known. */
static VkDeviceSize size_needed(const struct geometry_shapes *asked, const struct built *source)
{
    VkDeviceSize compacted = source->compacted_size ? source->compacted_size->size : 0;
    if (!source->compacted)
        return asked->needed_size;
    return compacted < asked->needed_size ? compacted : asked->needed_size;
}

static void judge_size(struct judge *judge, const struct journal_entry *entry,
                       const struct built *source)
{
    const struct geometry_shapes *asked = entry->built.shapes;
    struct finding finding;
    if (!asked || source->state != BUILT_BEFORE || asked->dst_size >= size_needed(asked, source))
        return;
    struct value dst = object(VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR, entry->dst);
    if (source->compacted)
        finding_says(&finding, "dstAccelerationStructure",
                     "{} was created with size {}, less than the queried compacted size of its "
                     "source ({}), and less than accelerationStructureSize ({})",
                     dst, number(asked->dst_size), number(source->compacted_size->size),
                     number(asked->needed_size));
    else
        finding_says(
            &finding, "dstAccelerationStructure",
            "{} was created with size {}, less than accelerationStructureSize ({}), and its "
            "source is not compacted",
            dst, number(asked->dst_size), number(asked->needed_size));
    judge_report(judge, RULE_dst_is_large_enough, &finding);
}

void judge_update(struct replay *replay, const struct journal *journal,
                  const struct journal_entry *entry, const struct built *source)
{
    if (source->state == BUILT_UNKNOWN || source->state == BUILT_FILLED ||
        entry->built.state == BUILT_UNKNOWN)
        return;
    struct judge judge;
    judge_begin_entry(&judge, replay, journal, entry);
    const struct update_view update = {.command = judge.location.command,
                                       .src = entry->src,
                                       .asked = &entry->built,
                                       .source = source};
    walk_update(&judge.walk, &update, &judge.location);
    judge_updated_geometries(&judge, &update);
    judge_dense(&judge, &update);
    judge_size(&judge, entry, source);
}
