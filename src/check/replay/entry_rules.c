/* SPDX-License-Identifier: Apache-2.0 */
/* Locates builds of a replay, evaluates the rules about updates, reads and micromaps, and reports
 * all findings of the replay. */
#include "src/check/replay/entry_rules.h"

#include "src/check/replay/object_states.h"
#include "src/check/walk/rows.h"
#include "src/rules/shared.h"

static bool report_judged(void *user, enum rule rule, const struct location *location,
                          const struct finding *finding)
{
    const struct entry_rules *rules = user;
    struct replay *replay = rules->replay;
    uint32_t origin = location->subject == SUBJECT_ARGUMENT
                          ? rules->origin
                          : journal_origin_at(rules->journal, rules->first_build + location->build);
    return replay->found(replay->user, rules->journal, rules->first_build, origin, rule, location,
                         finding);
}

static const struct check_hooks hooks = {.found = report_judged};

void entry_rules_begin(struct entry_rules *rules, struct replay *replay,
                       const struct journal *journal, uint32_t position,
                       const struct location *location)
{
    rules->replay = replay;
    rules->journal = journal;
    rules->first_build = position - location->build;
    rules->origin = 0;
    rules->location = *location;
    rules->context = (struct check_context){.hooks = &hooks,
                                            .user = rules,
                                            .level = LEVEL_EXECUTION,
                                            .active = replay->active[location->command]};
    walk_start(&rules->walk, &rules->context);
}

static struct location location_of_read(const struct journal_entry *entry)
{
    struct location location = {
        .command = (enum build_command)entry->command,
        .subject = SUBJECT_ARGUMENT,
        .argument = entry->command == COMMAND_CmdCopyAccelerationStructureNV ? NULL : "pInfo",
    };
    if (journal_entry_is_query(entry)) {
        location.argument = journal_entry_type(entry) == VK_OBJECT_TYPE_MICROMAP_EXT
                                ? "pMicromaps"
                                : "pAccelerationStructures";
        location.is_element = true;
        location.build = entry->info;
    } else if (entry->command == COMMAND_CmdBuildMicromapsEXT) {
        location.argument = "pInfos";
        location.is_element = true;
        location.build = entry->built.position;
    }
    return location;
}

static struct location location_of(const struct journal_entry *entry)
{
    struct location location = {.command = (enum build_command)entry->command,
                                .subject = SUBJECT_BUILD,
                                .build = entry->info,
                                .geometry_by_pointer = entry->geometry_by_pointer};
    if (journal_is_use_micromap(entry)) {
        location.subject = SUBJECT_GEOMETRY;
        location.geometry = entry->micromap.geometry;
    } else if (entry->command == COMMAND_NV) {
        location.subject = SUBJECT_PARAMETER;
    }
    return location;
}

void entry_rules_begin_entry(struct entry_rules *rules, struct replay *replay,
                             const struct journal *journal, const struct journal_entry *entry)
{
    uint32_t position =
        journal_is_use_micromap(entry) ? entry->micromap.position : entry->built.position;
    const struct location location = location_of(entry);
    entry_rules_begin(rules, replay, journal, position, &location);
}

void entry_rules_begin_read(struct entry_rules *rules, struct replay *replay,
                            const struct journal *journal, const struct journal_entry *entry)
{
    const struct location location = location_of_read(entry);
    entry_rules_begin(rules, replay, journal, location.build, &location);
    rules->origin = entry->origin;
}

void entry_rules_begin_query(struct entry_rules *rules, struct replay *replay,
                             const struct journal *journal, const struct journal_entry *entry)
{
    const struct location location = {.command = (enum build_command)entry->command,
                                      .subject = SUBJECT_ARGUMENT};
    entry_rules_begin(rules, replay, journal, 0, &location);
    rules->origin = entry->origin;
}

void entry_rules_report(struct entry_rules *rules, enum rule rule, const struct finding *finding)
{
    enum rule other = finding->reported_with;
    bool is_named = other != RULE_COUNT && rules->context.active[other];
    if (rules->walk.active[rule] && !is_named)
        report_judged(rules, rule, &rules->location, finding);
}

/* ---- updates, their geometries and their extensions */

void judge_updated_geometries(struct entry_rules *rules, const struct update_view *update)
{
    const struct geometry_shapes *requested = update->requested->shapes,
                                 *source = update->source->shapes;
    if (!requested || !source || requested->count != source->count)
        return;
    struct location location = rules->location;
    for (uint32_t i = 0; i < requested->count; i++) {
        struct updated_geometry_view geometry = {.update = update,
                                                 .index = i,
                                                 .requested = &requested->items[i],
                                                 .source = &source->items[i]};
        location.geometry = i;
        location.subject =
            location.command == COMMAND_NV && type_is_instances(requested->items[i].type)
                ? SUBJECT_PARAMETER
                : SUBJECT_GEOMETRY;
        walk_updated_geometry(&rules->walk, &geometry, &location);
        judge_updated_micromap(&rules->walk, &geometry, &location);
    }
}

static void judge_dense(struct entry_rules *rules, const struct update_view *update)
{
    const struct geometry_shapes *requested = update->requested->shapes,
                                 *source = update->source->shapes;
    if (!requested || !source || requested->count != source->count)
        return;
    struct location location = rules->location;
    location.subject = SUBJECT_GEOMETRY;
    const struct dense_shape *now = built_dense_shapes(requested),
                             *then = built_dense_shapes(source);
    const struct dense_shape *end = then + source->dense_count;
    for (uint32_t i = 0; i < requested->dense_count; i++, now++) {
        while (then < end && then->geometry < now->geometry)
            then++;
        if (then == end || then->geometry != now->geometry)
            continue;
        struct updated_dense_view dense = {.update = update, .requested = now, .source = then};
        location.geometry = now->geometry;
        walk_updated_dense(&rules->walk, &dense, &location);
    }
}

/* Returns the size that the dst of an update needs: the size of a build or, if the source is
 * compacted, the smaller compacted size. Returns 0 if neither is known. */
static VkDeviceSize size_needed(VkDeviceSize requested, const struct built *source)
{
    VkDeviceSize compacted = source->compacted_size ? source->compacted_size->size : 0;
    return source->compacted && compacted < requested ? compacted : requested;
}

static void judge_size(struct entry_rules *rules, const struct journal_entry *entry,
                       const struct built *source)
{
    const struct geometry_shapes *requested = entry->built.shapes;
    const VkDeviceSize needed = built_needed_size(&entry->built);
    struct finding finding;
    if (!requested || source->state != BUILT_BEFORE ||
        requested->dst_size >= size_needed(needed, source))
        return;
    struct value dst = object(VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR, entry->dst);
    if (source->compacted)
        finding_says(&finding, "dstAccelerationStructure",
                     "{} was created with size {}, less than the queried compacted size of its "
                     "source ({}), and less than accelerationStructureSize ({})",
                     dst, number(requested->dst_size), number(source->compacted_size->size),
                     number(needed));
    else
        finding_says(
            &finding, "dstAccelerationStructure",
            "{} was created with size {}, less than accelerationStructureSize ({}), and its "
            "source is not compacted",
            dst, number(requested->dst_size), number(needed));
    entry_rules_report(rules, RULE_dst_is_large_enough, &finding);
}

void judge_update(struct replay *replay, const struct journal *journal,
                  const struct journal_entry *entry, const struct built *source)
{
    if (source->state == BUILT_UNKNOWN || source->state == BUILT_FILLED ||
        entry->built.state == BUILT_UNKNOWN)
        return;
    struct entry_rules rules;
    entry_rules_begin_entry(&rules, replay, journal, entry);
    const struct update_view update = {.command = rules.location.command,
                                       .src = entry->src,
                                       .requested = &entry->built,
                                       .source = source};
    walk_update(&rules.walk, &update, &rules.location);
    judge_updated_geometries(&rules, &update);
    judge_dense(&rules, &update);
    judge_size(&rules, entry, source);
}

/* ---- copies, queries and serializations, when they execute */

static WALK_ALL(used_source) static WALK_ALL(sized_copy)

    /* Returns a micromap that the source refers to by deserialized data, and that was certainly not
     * deserialized; or 0. */
    static uint64_t undeserialized_micromap(struct replay *replay, const struct built *source)
{
    const struct geometry_shapes *shapes = source->state == BUILT_FILLED ? source->shapes : NULL;
    for (uint32_t i = 0; shapes && i < shapes->count; i++) {
        const struct micromap_shape micromap = built_micromap_shape(shapes, i);
        const struct built *built = replay_read(
            replay, &(struct journal_entry){.src = micromap.handle, .src_id = micromap.id});
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
    struct entry_rules rules;
    entry_rules_begin_read(&rules, replay, journal, entry);
    const struct used_source_view view = {
        .object_type = journal_entry_type(entry),
        .handle = entry->src,
        .read = &entry->read,
        .built = source,
        .micromap = undeserialized_micromap(replay, source),
    };
    walk_used_source(&rules.walk, &view, &rules.location);
}

static bool is_clone(const struct journal_entry *entry)
{
    return journal_is_copy(entry) && !entry->read.compacts;
}

/* Whether the host has read the size of src, which a clone copies: its copies may have another. */
static bool full_size_is_known(const struct journal_entry *entry, const struct built *source)
{
    return is_clone(entry) && source->compacted_size && source->compacted_size->full &&
           source->compacted_size->serialized_id == entry->src_id;
}

/* Returns the bytes that a copy certainly accesses of src and of dst, as the host has read; 0:
 * unknown. The compacted size of a compacted structure is unknown: it is that of its source or
 * less. */
static VkDeviceSize queried_size(const struct journal_entry *entry, const struct built *source)
{
    const struct compacted_size *sizes = source->compacted_size;
    if (!sizes || source->state == BUILT_UNKNOWN)
        return 0;
    if (journal_is_read(entry))
        return sizes->serialized_id == entry->src_id ? sizes->serialized : 0;
    if (source->state != BUILT_BEFORE || (source->compacted && entry->read.compacts))
        return 0;
    return full_size_is_known(entry, source) ? sizes->full : sizes->size;
}

/* Returns the facts of a structure that a copy accesses; nothing if it is not the one that was
 * recorded. */
static struct object_facts find_copied(const struct replay *replay,
                                       const struct journal_entry *entry, uint64_t handle,
                                       uint64_t id)
{
    const struct object_facts facts =
        object_facts_find(replay->resources, journal_entry_type(entry), handle);
    return facts.id == id ? facts : (struct object_facts){0};
}

/* Returns the bytes that the build of src needs, which a clone goes on to hold; 0 if they are
 * unknown, or if src was created with less. A compacted structure needs fewer, and so may one whose
 * size was queried. */
static VkDeviceSize cloned_size(const struct replay *replay, const struct journal_entry *entry,
                                const struct built *source, const struct object_facts *src)
{
    const bool is_whole = is_clone(entry) && source->state == BUILT_BEFORE && !source->compacted;
    const bool is_queried = replay->sizes_may_be_unknown ||
                            (source->compacted_size && source->compacted_size->full_is_queried);
    const VkDeviceSize needed = is_whole && !is_queried ? built_needed_size(source) : 0;
    return src->size >= needed ? needed : 0;
}

/* Structures that begin at the same byte are reported at the call. */
static void judge_copied_bytes(struct entry_rules *rules, const struct sized_copy_view *copy,
                               const struct memory_span *src, const struct memory_span *dst)
{
    struct finding finding;
    const uint64_t apart =
        src->begin < dst->begin ? dst->begin - src->begin : src->begin - dst->begin;
    if (!src->memory || src->memory != dst->memory || !apart || apart >= copy->queried_size)
        return;
    finding_says(&finding, "dst",
                 "{} begins at byte {} of {}, and src {} at byte {}: the copy accesses {} of each",
                 object(copy->object_type, copy->dst), hex(dst->begin),
                 object(VK_OBJECT_TYPE_DEVICE_MEMORY, handle_number(dst->memory)),
                 object(copy->object_type, copy->src), hex(src->begin),
                 count_of(copy->queried_size, "byte"));
    entry_rules_report(rules, RULE_copied_memory_does_not_overlap, &finding);
}

/* Returns the bytes for dst. The application may have placed another buffer at the address of a
 * serialization since the command was recorded. */
static VkDeviceSize size_of_dst(const struct replay *replay, const struct journal_entry *entry)
{
    struct address_facts now;
    if (!journal_is_read(entry))
        return entry->read.dst_size;
    resources_look_up_address(replay->resources, entry->dst, &now);
    return now.status == ADDRESS_IN_BUFFER && now.bytes_left > entry->read.dst_size
               ? now.bytes_left
               : entry->read.dst_size;
}

void judge_copy_size(struct replay *replay, const struct journal *journal,
                     const struct journal_entry *entry, const struct built *source)
{
    struct object_facts src = {0}, dst = {0};
    struct entry_rules rules;
    if (!entry->read.dst_size)
        return;
    if (!journal_is_read(entry)) {
        src = find_copied(replay, entry, entry->src, entry->src_id);
        dst = find_copied(replay, entry, entry->dst, entry->dst_id);
    }
    const struct sized_copy_view view = {
        .object_type = journal_entry_type(entry),
        .src = entry->src,
        .dst = entry->dst,
        .serializes = journal_is_read(entry),
        .compacts = entry->read.compacts,
        .dst_size = size_of_dst(replay, entry),
        .queried_size = queried_size(entry, source),
        .is_full = full_size_is_known(entry, source),
        .needed_size = cloned_size(replay, entry, source, &src),
    };
    entry_rules_begin_read(&rules, replay, journal, entry);
    walk_sized_copy(&rules.walk, &view, &rules.location);
    judge_copied_bytes(&rules, &view, &src.span, &dst.span);
}

/* ---- micromaps that recorded builds use */

void judge_updated_micromap(struct walk *walk, const struct updated_geometry_view *geometry,
                            const struct location *location)
{
    const struct geometry_shapes *requested = geometry->update->requested->shapes;
    const struct geometry_shapes *source = geometry->update->source->shapes;
    if (!requested->has_micromaps && !source->has_micromaps)
        return;
    struct updated_micromap_view view = {.geometry = geometry,
                                         .requested =
                                             built_micromap_shape(requested, geometry->index),
                                         .source = built_micromap_shape(source, geometry->index)};
    walk_updated_micromap(walk, &view, location);
}

static void judge_use(struct replay *replay, const struct journal *journal,
                      const struct journal_entry *entry, const struct built *built,
                      const struct built *source)
{
    struct entry_rules rules;
    entry_rules_begin_entry(&rules, replay, journal, entry);
    const struct used_micromap_view view = {.command = (enum build_command)entry->command,
                                            .handle = entry->src,
                                            .use = &entry->micromap,
                                            .built = built,
                                            .source = source};
    walk_used_micromap(&rules.walk, &view, &rules.location);
}

void replay_record_micromap(struct replay *replay, const struct structures *known,
                            const struct journal *journal, const struct journal_entry *entry)
{
    const struct structure *micromap = structures_find(known, entry->src_id);
    uint64_t updated = entry->micromap.updated_id;
    const struct structure *source = updated ? structures_find(known, updated) : NULL;
    if (!micromap || (updated && !source))
        return;
    journal_set_judged(entry);
    judge_use(replay, journal, entry, &micromap->built, source ? &source->built : NULL);
}

static enum resource_kind kind_of(const struct journal_entry *entry)
{
    return entry->micromap.is_ext ? RESOURCE_MICROMAP : RESOURCE_ACCEL;
}

void replay_submit_micromap(struct journal_walk *walk, const struct journal_entry *entry)
{
    struct replay *replay = walk->user;
    const struct journal_entry updated = {.command = entry->command,
                                          .src = entry->micromap.updated,
                                          .src_id = entry->micromap.updated_id};
    judge_use(replay, walk->journal, entry, replay_read(replay, entry),
              updated.src_id ? replay_read(replay, &updated) : NULL);
}

void replay_destroyed_micromap(struct journal_walk *walk, const struct journal_entry *entry)
{
    struct replay *replay = walk->user;
    bool is_ext = entry->micromap.is_ext;
    if (resources_find_id(replay->resources, kind_of(entry), entry->src) == entry->src_id)
        return;
    struct entry_rules rules;
    struct finding finding;
    entry_rules_begin_entry(&rules, replay, walk->journal, entry);
    finding_says(&finding, is_ext ? OPACITY_EXT_DATA "micromap" : OPACITY_DATA "micromap",
                 "{} was destroyed after the build was recorded",
                 destroyed_object(is_ext ? VK_OBJECT_TYPE_MICROMAP_EXT
                                         : VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR,
                                  entry->src, entry->src_id));
    entry_rules_report(&rules,
                       is_ext ? RULE_ext_opacity_micromap_is_valid : RULE_opacity_micromap_is_valid,
                       &finding);
}
