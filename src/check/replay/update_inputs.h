/* SPDX-License-Identifier: Apache-2.0 */
/* Notes of a replay that are used when the inputs of its builds are read: for each build that may
 * be updated later, the inputs to fill in; for each update, its source to compare with. */
#ifndef ASSAY_CHECK_REPLAY_UPDATE_INPUTS_H
#define ASSAY_CHECK_REPLAY_UPDATE_INPUTS_H

#include "src/base/unknown.h"
#include "src/check/replay/states.h"
#include "src/state/builds/structures.h"

struct input_note {
    const struct journal *journal; /* has the entry; belongs to a submitted command buffer */
    const struct journal_entry *entry;
    struct build_inputs *inputs; /* of this execution; NULL: they are not needed, or no memory */
    struct built source;         /* last build of an update's source; else BUILT_UNKNOWN */
};

/* The last build of a micromap of VK_KHR_opacity_micromap when a build used it. */
struct used_micromap_note {
    uint32_t geometry;
    struct built built;
};

/* In execution order. Zero-initialized is empty. */
struct input_notes {
    struct input_note *items;
    uint32_t count, capacity;
    struct used_micromap_note *used;
    uint32_t used_count, used_capacity;
    /* Compacting copies whose size is read later. Their `source` has the compacted size only. */
    struct input_note *copies;
    uint32_t copy_count, copy_capacity;
    /* Of builds of instances, needed to look up the structures that the instances refer to. */
    struct execution_point *points;
    uint32_t point_count, point_capacity;
    /* The numbers of JOURNAL_PLACE entries (places_execute()). */
    uint64_t *places;
    uint32_t place_count, place_capacity;
    struct unknown unknown; /* some notes are missing: the others cannot be paired with builds */
};
/* Frees all notes and makes them empty. */
void input_notes_release(struct input_notes *notes);

/* Without memory the copy is not noted. */
void input_notes_add_copy(struct input_notes *notes, const struct journal *journal,
                          const struct journal_entry *entry, struct compacted_size *sizes);

/* Note a build, and attach the note's inputs to `built`; note an update, before its source changes;
 * note the use of a micromap, and the number of a build at a place, as events of the journal
 * (states.h). */
void replay_note_build(struct replay *replay, const struct journal *journal,
                       const struct journal_entry *entry, struct built *built);
void replay_note_update(struct replay *replay, const struct journal *journal,
                        const struct journal_entry *entry);
void replay_note_micromap(struct journal_walk *walk, const struct journal_entry *entry);
void replay_note_place(struct journal_walk *walk, const struct journal_entry *entry);

/* Validates an update whose inputs, and those of its source, have been read as far as possible. */
void replay_judge_inputs(struct replay *replay, const struct input_note *note);

#endif
