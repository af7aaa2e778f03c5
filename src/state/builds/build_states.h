/* SPDX-License-Identifier: Apache-2.0 */
/* A map from acceleration structures, by their ids (struct accel_facts), to what they were last
 * built with. Not locked: its owner is. A command buffer has one of what it knows by itself, and a
 * device one of what has been submitted. */
#ifndef ASSAY_STATE_BUILDS_BUILD_STATES_H
#define ASSAY_STATE_BUILDS_BUILD_STATES_H

#include "src/base/handle_table.h"
#include "src/state/builds/built.h"
#include "src/state/order/clock.h"

struct build_state {
    uint64_t id;
    struct built built;
    struct timestamp written; /* when, count 0: never; not used by a command buffer's own map */
    uint32_t host_writers;    /* commands of the host that are writing it: until they have ended
                                 nothing is known of it */
};

/* Zero-initialized is empty. */
struct build_states {
    struct handle_table by_id;
};

/* NULL where nothing was noted. */
struct build_state *build_states_find(const struct build_states *states, uint64_t id);

/* Will soon be looked for: fetches where it is found; and then, once that has come, what is. */
void build_states_prefetch(const struct build_states *states, uint64_t id);
void build_states_prefetch_found(const struct build_states *states, uint64_t id);

/* Notes what the structure was last built with; shares it. Out of memory: an older note is
 * forgotten, and false returned. */
bool build_states_set(struct build_states *states, uint64_t id, const struct built *built,
                      struct timestamp written);

/* The same for a state that was found. */
void build_state_replace(struct build_state *state, const struct built *built,
                         struct timestamp written);

/* A command of the host begins to write the structure. False without memory. */
bool build_states_add_writer(struct build_states *states, uint64_t id);

/* What states were before they were set, so that it can be undone: for calls that are judged before
 * they happen, and then may not happen. Zero-initialized is empty. */
struct build_undo {
    struct build_state *before; /* state BUILT_NEVER where nothing was noted */
    size_t count, capacity;
};

/* Notes what is known of a structure before it is set or removed: `state`, or NULL where nothing
 * is. What it was built with moves to the note, and it is BUILT_UNKNOWN. False without memory; then
 * nothing has changed. */
bool build_undo_note(struct build_undo *undo, uint64_t id, struct build_state *state);
void build_undo_carry_out(struct build_undo *undo, struct build_states *states);
void build_undo_forget(struct build_undo *undo); /* keeps its memory, unless that is much */
void build_undo_release(struct build_undo *undo);

void build_states_remove(struct build_states *states, uint64_t id);
void build_states_release(struct build_states *states);

#endif
