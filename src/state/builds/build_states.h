/* SPDX-License-Identifier: Apache-2.0 */
/* Maps the ids of acceleration structures (struct accel_facts) to their last builds. Not locked:
 * its owner is. Each command buffer has a map of the structures that it writes itself; a device has
 * a map for all submitted work. */
#ifndef ASSAY_STATE_BUILDS_BUILD_STATES_H
#define ASSAY_STATE_BUILDS_BUILD_STATES_H

#include "src/base/handle_table.h"
#include "src/state/builds/built.h"
#include "src/state/order/clock.h"

struct build_state {
    uint64_t id;
    struct built built;
    struct timestamp written; /* when written; count 0: never; unused in a command buffer's own
                               * map */
    uint32_t host_writers;    /* number of host commands that are writing it: until they end, the
                               * state is unknown */
};

/* Zero-initialized is empty. */
struct build_states {
    struct handle_table by_id;
};

/* Returns NULL if there is no state. */
struct build_state *build_states_find(const struct build_states *states, uint64_t id);

/* Prefetch a state that will be looked up soon: first its place in the table; once that is in the
 * cache, the state itself. */
void build_states_prefetch(const struct build_states *states, uint64_t id);
void build_states_prefetch_found(const struct build_states *states, uint64_t id);

/* Sets the last build of a structure; shares `built`. If there is no memory for a new state,
 * returns false and changes nothing. */
bool build_states_set(struct build_states *states, uint64_t id, const struct built *built,
                      struct timestamp written);

/* Likewise for a state found before. */
void build_state_replace(struct build_state *state, const struct built *built,
                         struct timestamp written);

/* Called when a host command begins to write a structure. Returns false if there is no memory. */
bool build_states_add_writer(struct build_states *states, uint64_t id);

/* The previous states of structures, for commands that are replayed before they are called down and
 * may fail. Zero-initialized is empty. */
struct build_undo {
    struct build_state *before; /* state BUILT_NEVER if there was no state */
    size_t count, capacity;
};

/* Records the state of a structure before it is set or removed; `state` is NULL if there is none.
 * Moves `built` to the record and makes the state BUILT_UNKNOWN. Returns false and changes nothing
 * if there is no memory. */
bool build_undo_note(struct build_undo *undo, uint64_t id, struct build_state *state);
/* Restores all recorded states, newest first, and removes the records. */
void build_undo_carry_out(struct build_undo *undo, struct build_states *states);
void build_undo_forget(struct build_undo *undo); /* removes all records; keeps the memory if it is
                                                  * small */
void build_undo_release(struct build_undo *undo);

/* Removes the state of a structure if there is one. */
void build_states_remove(struct build_states *states, uint64_t id);
/* Frees all states and makes the map empty. */
void build_states_release(struct build_states *states);

#endif
