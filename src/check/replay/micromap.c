/* SPDX-License-Identifier: Apache-2.0 */
/* Validates the micromaps that recorded builds use. */
#include "src/check/replay/micromap.h"

#include "src/check/replay/judge.h"
#include "src/rules/input.h"

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

/* ---- uses */

static void judge_use(struct replay *replay, const struct journal *journal,
                      const struct journal_entry *entry, const struct built *built,
                      const struct built *source)
{
    struct judge judge;
    judge_begin_entry(&judge, replay, journal, entry);
    const struct used_micromap_view view = {.command = (enum build_command)entry->command,
                                            .handle = entry->src,
                                            .use = &entry->micromap,
                                            .built = built,
                                            .source = source};
    walk_used_micromap(&judge.walk, &view, &judge.location);
}

void replay_record_micromap(struct replay *replay, const struct structures *known,
                            const struct journal *journal, struct journal_entry *entry)
{
    const struct structure *micromap = structures_find(known, entry->src_id);
    uint64_t updated = entry->micromap.updated_id;
    const struct structure *source = updated ? structures_find(known, updated) : NULL;
    if (!micromap || (updated && !source))
        return;
    entry->judged = true;
    judge_use(replay, journal, entry, &micromap->built, source ? &source->built : NULL);
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
    judge_use(replay, journal, entry, replay_read(replay, entry),
              updated.src_id ? replay_read(replay, &updated) : NULL);
}

void replay_destroyed_micromap(struct replay *replay, const struct journal *journal,
                               const struct journal_entry *entry)
{
    bool is_ext = entry->micromap.is_ext;
    if (resources_find_id(replay->resources, kind_of(entry), entry->src) == entry->src_id)
        return;
    struct judge judge;
    struct finding finding;
    judge_begin_entry(&judge, replay, journal, entry);
    finding_says(
        &finding, is_ext ? OPACITY_EXT_DATA "micromap" : OPACITY_DATA "micromap",
        "{} was destroyed after the build was recorded",
        object(is_ext ? VK_OBJECT_TYPE_MICROMAP_EXT : VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR,
               entry->src));
    judge_report(&judge,
                 is_ext ? RULE_ext_opacity_micromap_is_valid : RULE_opacity_micromap_is_valid,
                 &finding);
}
