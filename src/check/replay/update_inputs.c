/* SPDX-License-Identifier: Apache-2.0 */
/* Notes of a replay about builds whose inputs are read after they have executed. */
#include "src/check/replay/update_inputs.h"

#include <stdlib.h>

#include "src/base/array.h"
#include "src/check/replay/entry_rules.h"
#include "src/snapshots/recording.h"

void input_notes_release(struct input_notes *notes)
{
    for (uint32_t i = 0; i < notes->count; i++) {
        build_inputs_release(notes->items[i].inputs);
        built_release(&notes->items[i].source);
    }
    for (uint32_t i = 0; i < notes->used_count; i++)
        built_release(&notes->used[i].built);
    for (uint32_t i = 0; i < notes->copy_count; i++)
        built_release(&notes->copies[i].source);
    free(notes->copies);
    free(notes->items);
    free(notes->used);
    free(notes->points);
    free(notes->places);
    *notes = (struct input_notes){0};
}

void input_notes_add_copy(struct input_notes *notes, const struct journal *journal,
                          const struct journal_entry *entry, struct compacted_size *sizes)
{
    const struct built source = {.state = BUILT_BEFORE, .compacted_size = sizes};
    if (ARRAY_HAS_ROOM(notes->copies, notes->copy_count, notes->copy_capacity))
        notes->copies[notes->copy_count++] =
            (struct input_note){.journal = journal, .entry = entry, .source = built_share(&source)};
}

void replay_note_place(struct journal_walk *walk, const struct journal_entry *entry)
{
    const struct replay *replay = walk->user;
    struct input_notes *notes = replay->notes;
    const uint64_t number = places_execute(replay->places, entry->placed.kind);
    if (!notes)
        return;
    if (ARRAY_HAS_ROOM(notes->places, notes->place_count, notes->place_capacity))
        notes->places[notes->place_count++] = number;
}

static bool reserved(struct input_notes *notes, bool has_room)
{
    if (!has_room)
        unknown_set(&notes->unknown, UNKNOWN_INPUT_NOTES);
    return has_room;
}

/* Returns whether the inputs of the build will be read and retained for later updates. */
static bool has_inputs_to_note(const struct replay *replay, const struct journal *journal,
                               const struct journal_entry *entry)
{
    return replay->notes && recording_with_commands(journal) && entry->built.shapes;
}

static void note_execution_point(struct replay *replay, const struct journal *journal,
                                 const struct journal_entry *entry)
{
    struct input_notes *notes = replay->notes;
    uint64_t serial;
    if (!notes || !recording_with_commands(journal) || !replay->predecessors_known ||
        entry->built.type != VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR ||
        !structures_find_serial(replay->structures, &serial))
        return;
    if (!reserved(notes, ARRAY_HAS_ROOM(notes->points, notes->point_count, notes->point_capacity)))
        return;
    struct execution_point *point = &notes->points[notes->point_count++];
    point->serial = serial;
    point->now = replay->now;
    point->is_unordered = replay->unordered;
    execution_clock_copy(&point->follows, replay->follows);
}

/* Each entry of a journal that has inputs to note gets a note, even if nothing is known of it:
 * notes and entries are paired in execution order. Returns NULL if memory runs out. */
static struct input_note *add_note(struct replay *replay, const struct journal *journal,
                                   const struct journal_entry *entry)
{
    struct input_notes *notes = replay->notes;
    if (!reserved(notes, ARRAY_HAS_ROOM(notes->items, notes->count, notes->capacity)))
        return NULL;
    struct input_note *note = &notes->items[notes->count++];
    *note = (struct input_note){.journal = journal, .entry = entry, .source.state = BUILT_UNKNOWN};
    return note;
}

void replay_note_build(struct replay *replay, const struct journal *journal,
                       const struct journal_entry *entry, struct built *built)
{
    note_execution_point(replay, journal, entry);
    if (!has_inputs_to_note(replay, journal, entry))
        return;
    struct input_note *note = add_note(replay, journal, entry);
    if (note)
        built->inputs = note->inputs = build_inputs_create(entry->built.shapes->count);
}

void replay_note_update(struct replay *replay, const struct journal *journal,
                        const struct journal_entry *entry)
{
    note_execution_point(replay, journal, entry);
    if (!has_inputs_to_note(replay, journal, entry))
        return;
    struct input_note *note = add_note(replay, journal, entry);
    const struct built *source = replay_read(replay, entry);
    if (!note || source->state != BUILT_BEFORE || !built_inputs(source))
        return;
    note->inputs = build_inputs_create(entry->built.shapes->count);
    note->source = built_share(source);
}

void replay_note_micromap(struct journal_walk *walk, const struct journal_entry *entry)
{
    struct replay *replay = walk->user;
    struct input_notes *notes = replay->notes;
    if (!notes || !recording_with_commands(walk->journal) || entry->micromap.is_ext)
        return;
    if (!reserved(notes, ARRAY_HAS_ROOM(notes->used, notes->used_count, notes->used_capacity)))
        return;
    notes->used[notes->used_count++] = (struct used_micromap_note){
        .geometry = entry->micromap.geometry, .built = built_share(replay_read(replay, entry))};
}

/* The primitive count has been validated before if both builds gave it as a parameter. */
static bool counts_are_known(const struct geometry_shapes *shapes)
{
    return shapes->count && shapes->items[0].count_known;
}

void replay_judge_inputs(struct replay *replay, const struct input_note *note)
{
    const struct geometry_shapes *requested = note->entry->built.shapes,
                                 *source = note->source.shapes;
    if (note->source.state == BUILT_UNKNOWN || !source)
        return;
    struct built now = note->entry->built;
    now.inputs = note->inputs;
    struct entry_rules rules;
    entry_rules_begin_entry(&rules, replay, note->journal, note->entry);
    for (int rule = 0; rule < RULE_COUNT; rule++)
        if (rule == RULE_primitive_count_matches_source
                ? counts_are_known(requested) && counts_are_known(source)
                : rule_infos[rule].level != LEVEL_CONTENT)
            walk_stop_rule(&rules.walk, (enum rule)rule);
    const struct update_view update = {.command = rules.location.command,
                                       .src = note->entry->src,
                                       .requested = &now,
                                       .source = &note->source};
    judge_updated_geometries(&rules, &update);
}
