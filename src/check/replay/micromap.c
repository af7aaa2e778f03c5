/* SPDX-License-Identifier: Apache-2.0 */
/* Judging the micromaps that recorded builds use. */
#include "src/check/replay/micromap.h"

#include <string.h>

#include "src/rules/input.h"
#include "src/rules/predicates.h"

#define RULE(subject, name, level, ids)                                                            \
    if (walk->wants[RULE_##name] && !name(subject, &finding))                                      \
        walk_report(walk, RULE_##name, location, &finding);

static void walk_used_micromap(struct walk *walk, const struct used_micromap_view *used_micromap,
                               const struct location *location)
{
    struct finding finding;
#include "vuid-tables/rows/micromap_use.def"
}

static void walk_updated_micromap(struct walk *walk,
                                  const struct updated_micromap_view *updated_micromap,
                                  const struct location *location)
{
    struct finding finding;
#include "vuid-tables/rows/micromap_update.def"
}

void judge_updated_micromap(struct walk *walk, const struct updated_geometry_view *geometry,
                            const struct location *location)
{
    const struct geometry_shapes *asked = geometry->update->asked->shapes;
    const struct geometry_shapes *source = geometry->update->source->shapes;
    if (!asked->has_micromaps && !source->has_micromaps)
        return;
    struct updated_micromap_view view = {.geometry = geometry,
                                         .asked = built_micromap_shape(asked, geometry->index),
                                         .source = built_micromap_shape(source, geometry->index)};
    walk_updated_micromap(walk, &view, location);
}

/* Uses. */

struct judgement {
    struct replay *replay;
    const struct journal *journal;
    const struct journal_entry *entry;
};

static bool report(void *user, enum rule rule, const struct location *location,
                   const struct finding *finding)
{
    const struct judgement *judgement = user;
    struct replay *replay = judgement->replay;
    replay->locate(replay->user, judgement->journal, judgement->entry->micromap.position,
                   judgement->entry->info);
    return replay->found(replay->user, rule, location, finding);
}

static struct location location_of(const struct journal_entry *entry)
{
    return (struct location){.command = (enum build_command)entry->command,
                             .subject = SUBJECT_GEOMETRY,
                             .build = entry->info,
                             .geometry = entry->micromap.geometry,
                             .geometry_by_pointer = entry->geometry_by_pointer};
}

static void judge(struct replay *replay, const struct journal *journal,
                  const struct journal_entry *entry, const struct built *built,
                  const struct built *source)
{
    struct judgement judgement = {.replay = replay, .journal = journal, .entry = entry};
    static const struct check_hooks hooks = {.found = report};
    struct check_context context = {.hooks = &hooks, .user = &judgement};
    struct walk walk = {.context = &context, .wants = replay->active[entry->command]};
    const struct used_micromap_view view = {.command = (enum build_command)entry->command,
                                            .handle = entry->src,
                                            .use = &entry->micromap,
                                            .built = built,
                                            .source = source};
    const struct location location = location_of(entry);
    walk_used_micromap(&walk, &view, &location);
}

void replay_record_micromap(struct replay *replay, const struct build_states *known,
                            const struct journal *journal, struct journal_entry *entry)
{
    const struct build_state *micromap = build_states_find(known, entry->src_id);
    uint64_t updated = entry->micromap.updated_id;
    const struct build_state *source = updated ? build_states_find(known, updated) : NULL;
    if (!micromap || (updated && !source))
        return;
    entry->judged = true;
    judge(replay, journal, entry, &micromap->built, source ? &source->built : NULL);
}

static enum resource_kind kind_of(const struct journal_entry *entry)
{
    return entry->micromap.is_ext ? RESOURCE_MICROMAP : RESOURCE_ACCEL;
}

void replay_submit_micromap(struct replay *replay, const struct journal *journal,
                            const struct journal_entry *entry)
{
    const struct journal_entry updated = {.kind = JOURNAL_UPDATE,
                                          .command = entry->command,
                                          .src = entry->micromap.updated,
                                          .src_id = entry->micromap.updated_id};
    judge(replay, journal, entry, replay_read(replay, entry),
          updated.src_id ? replay_read(replay, &updated) : NULL);
}

void replay_destroyed_micromap(struct replay *replay, const struct journal *journal,
                               const struct journal_entry *entry)
{
    bool is_ext = entry->micromap.is_ext;
    enum rule rule = is_ext ? RULE_ext_opacity_micromap_is_valid : RULE_opacity_micromap_is_valid;
    if (resources_find_id(replay->resources, kind_of(entry), entry->src) == entry->src_id ||
        !replay->active[entry->command][rule])
        return;
    struct judgement judgement = {.replay = replay, .journal = journal, .entry = entry};
    const struct location location = location_of(entry);
    struct finding finding;
    finding_says(
        &finding, is_ext ? OPACITY_EXT_DATA "micromap" : OPACITY_DATA "micromap",
        "{} was destroyed after the build was recorded",
        object(is_ext ? VK_OBJECT_TYPE_MICROMAP_EXT : VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR,
               entry->src));
    report(&judgement, rule, &location, &finding);
}
