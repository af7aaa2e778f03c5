/* SPDX-License-Identifier: Apache-2.0 */
/* The rules of an update, and where their findings are. */
#include "src/check/replay/judge.h"

#include "src/check/replay/micromap.h"

/* Most updates have no findings: only those that do are worth locating. */
static bool report(void *user, enum rule rule, const struct location *location,
                   const struct finding *finding)
{
    const struct update_judgement *judgement = user;
    struct replay *replay = judgement->replay;
    replay->locate(replay->user, judgement->journal, judgement->entry->built.position,
                   judgement->entry->info);
    return replay->found(replay->user, rule, location, finding);
}

static const struct check_hooks hooks = {.found = report};

void update_judgement_begin(struct update_judgement *judgement, struct replay *replay,
                            const struct journal *journal, const struct journal_entry *entry)
{
    enum build_command command = (enum build_command)entry->command;
    *judgement = (struct update_judgement){
        .replay = replay,
        .journal = journal,
        .entry = entry,
        .context = {.hooks = &hooks, .user = judgement},
        .walk = {.context = &judgement->context, .wants = replay->active[command]},
        .location = {.command = command,
                     .subject = command == COMMAND_NV ? SUBJECT_PARAMETER : SUBJECT_BUILD,
                     .build = entry->info,
                     .geometry_by_pointer = entry->geometry_by_pointer},
    };
}

void judge_geometries(struct walk *walk, const struct update_view *update,
                      const struct location *build)
{
    const struct geometry_shapes *asked = update->asked->shapes, *source = update->source->shapes;
    if (!asked || !source || asked->count != source->count)
        return;
    struct location location = *build;
    for (uint32_t i = 0; i < asked->count; i++) {
        struct updated_geometry_view geometry = {
            .update = update, .index = i, .asked = &asked->items[i], .source = &source->items[i]};
        location.geometry = i;
        location.subject =
            build->command == COMMAND_NV && asked->items[i].type == VK_GEOMETRY_TYPE_INSTANCES_KHR
                ? SUBJECT_PARAMETER
                : SUBJECT_GEOMETRY;
        walk_updated_geometry(walk, &geometry, &location);
        judge_updated_micromap(walk, &geometry, &location);
    }
}

static void judge_dense(struct walk *walk, const struct update_view *update,
                        const struct location *build)
{
    const struct geometry_shapes *asked = update->asked->shapes, *source = update->source->shapes;
    if (!asked || !source || asked->count != source->count)
        return;
    struct location location = *build;
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
        walk_updated_dense(walk, &dense, &location);
    }
}

/* What the dst of an update needs at least: the size of a build, or, of a compacted source, that to
 * which its build compacts. 0 where neither is known. */
static VkDeviceSize size_needed(const struct geometry_shapes *asked, const struct built *source)
{
    VkDeviceSize compacted = source->compacted_size ? source->compacted_size->size : 0;
    if (!source->compacted)
        return asked->needed_size;
    return compacted < asked->needed_size ? compacted : asked->needed_size;
}

static void judge_size(struct walk *walk, const struct journal_entry *entry,
                       const struct built *source, const struct location *location)
{
    const struct geometry_shapes *asked = entry->built.shapes;
    struct finding finding;
    if (!asked || source->state != BUILT_BEFORE || asked->dst_size >= size_needed(asked, source) ||
        !walk->wants[RULE_dst_is_large_enough])
        return;
    struct value dst = object(VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR, entry->dst);
    if (source->compacted)
        finding_says(
            &finding, "dstAccelerationStructure",
            "{} was created with size {}, less than the compacted size of its source ({}), as "
            "that was queried, and than accelerationStructureSize ({})",
            dst, number(asked->dst_size), number(source->compacted_size->size),
            number(asked->needed_size));
    else
        finding_says(
            &finding, "dstAccelerationStructure",
            "{} was created with size {}, less than accelerationStructureSize ({}), and its "
            "source is not compacted",
            dst, number(asked->dst_size), number(asked->needed_size));
    walk->context->hooks->found(walk->context->user, RULE_dst_is_large_enough, location, &finding);
}

void judge_update(struct replay *replay, const struct journal *journal,
                  const struct journal_entry *entry, const struct built *source)
{
    if (source->state == BUILT_UNKNOWN || source->state == BUILT_FILLED ||
        entry->built.state == BUILT_UNKNOWN)
        return;
    struct update_judgement judgement;
    update_judgement_begin(&judgement, replay, journal, entry);
    struct update_view update = {.command = judgement.location.command,
                                 .src = entry->src,
                                 .asked = &entry->built,
                                 .source = source};
    walk_update(&judgement.walk, &update, &judgement.location);
    judge_geometries(&judgement.walk, &update, &judgement.location);
    judge_dense(&judgement.walk, &update, &judgement.location);
    judge_size(&judgement.walk, entry, source, &judgement.location);
}
