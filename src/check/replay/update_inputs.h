/* SPDX-License-Identifier: Apache-2.0 */
/* What a replay notes for when the data of its builds can be read: of each build that may be
 * updated later, what is to be filled; of each update, the source that it is measured by. */
#ifndef ASSAY_CHECK_REPLAY_UPDATE_INPUTS_H
#define ASSAY_CHECK_REPLAY_UPDATE_INPUTS_H

#include "src/check/replay/states.h"
#include "src/state/builds/built_flags.h"

struct input_note {
    const struct journal *journal; /* that has the entry: of a command buffer that was submitted */
    const struct journal_entry *entry;
    struct build_inputs *inputs; /* of this execution; NULL without memory */
    struct built source; /* of an update: what that was last built with; else BUILT_UNKNOWN */
};

/* What a micromap of VK_KHR_opacity_micromap was last built with when a build came to use it. */
struct used_micromap_note {
    const struct journal *journal;
    uint32_t position, geometry; /* of the build */
    struct built built;
};

/* When a build of instances came, for what it refers to. */
struct execution_point_note {
    const struct journal *journal;
    uint32_t position; /* of the build */
    struct execution_point point;
};

/* In the order of execution. Zero-initialized is empty. */
struct input_notes {
    struct input_note *items;
    uint32_t count, capacity;
    struct used_micromap_note *used;
    uint32_t used_count, used_capacity;
    struct execution_point_note *points;
    uint32_t point_count, point_capacity;
};
void input_notes_release(struct input_notes *notes);

/* Notes a build, which is now attached to `built`, and an update, before its source changes. */
void replay_note_build(struct replay *replay, const struct journal *journal,
                       const struct journal_entry *entry, struct built *built);
void replay_note_update(struct replay *replay, const struct journal *journal,
                        const struct journal_entry *entry);
void replay_note_micromap(struct replay *replay, const struct journal *journal,
                          const struct journal_entry *entry);

/* Judges an update whose contents, and those of its source, are as known as they will be. */
void replay_judge_inputs(struct replay *replay, const struct input_note *note);

#endif
