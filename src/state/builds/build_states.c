/* SPDX-License-Identifier: Apache-2.0 */
/* The map from structures to their last builds. */
#include "src/state/builds/build_states.h"

#include <stdlib.h>

/* The largest undo capacity, in records, that is kept for reuse. */
enum { UNDO_RETAINED = 1024 };

struct build_state *build_states_find(const struct build_states *states, uint64_t id)
{
    return handle_table_find(&states->by_id, id);
}

void build_states_prefetch(const struct build_states *states, uint64_t id)
{
    handle_table_prefetch(&states->by_id, id);
}

void build_states_prefetch_found(const struct build_states *states, uint64_t id)
{
    const struct build_state *state = build_states_find(states, id);
    if (!state)
        return;
    __builtin_prefetch(state, 1);
    __builtin_prefetch((const char *)(state + 1) - 1, 1);
}

static struct build_state *find_or_add(struct build_states *states, uint64_t id)
{
    struct build_state *state = build_states_find(states, id);
    if (state)
        return state;
    state = calloc(1, sizeof(*state));
    if (!state || !handle_table_set(&states->by_id, id, state)) {
        free(state);
        return NULL;
    }
    state->id = id;
    return state;
}

bool build_states_set(struct build_states *states, uint64_t id, const struct built *built,
                      struct timestamp written)
{
    struct build_state *state = id ? find_or_add(states, id) : NULL;
    if (!state)
        return false;
    build_state_replace(state, built, written);
    return true;
}

bool build_states_add_writer(struct build_states *states, uint64_t id)
{
    struct build_state *state = id ? find_or_add(states, id) : NULL;
    if (state)
        state->host_writers++;
    return state;
}

void build_state_replace(struct build_state *state, const struct built *built,
                         struct timestamp written)
{
    struct built shared = built_share(built); /* `built` may point to state->built */
    built_release(&state->built);
    state->built = shared;
    state->written = written;
}

bool build_undo_note(struct build_undo *undo, uint64_t id, struct build_state *state)
{
    if (undo->count == undo->capacity) {
        size_t capacity = undo->capacity ? undo->capacity * 2 : 64;
        struct build_state *before = realloc(undo->before, capacity * sizeof(*before));
        if (!before)
            return false;
        undo->before = before;
        undo->capacity = capacity;
    }
    struct build_state *before = &undo->before[undo->count++];
    *before = (struct build_state){.id = id, .built.state = BUILT_NEVER};
    if (state) {
        before->built = state->built;
        before->written = state->written;
        state->built = (struct built){.state = BUILT_UNKNOWN};
    }
    return true;
}

/* Backwards, so that the oldest record of a structure takes effect last. */
void build_undo_carry_out(struct build_undo *undo, struct build_states *states)
{
    while (undo->count) {
        struct build_state *before = &undo->before[--undo->count];
        if (before->built.state == BUILT_NEVER)
            build_states_remove(states, before->id);
        else
            build_states_set(states, before->id, &before->built, before->written);
        built_release(&before->built);
    }
}

void build_undo_forget(struct build_undo *undo)
{
    if (undo->capacity > UNDO_RETAINED) {
        build_undo_release(undo);
        return;
    }
    while (undo->count)
        built_release(&undo->before[--undo->count].built);
}

void build_undo_release(struct build_undo *undo)
{
    while (undo->count)
        built_release(&undo->before[--undo->count].built);
    free(undo->before);
    *undo = (struct build_undo){0};
}

static void free_state(void *record, void *context)
{
    struct build_state *state = record;
    (void)context;
    built_release(&state->built);
    free(state);
}

void build_states_remove(struct build_states *states, uint64_t id)
{
    void *state = handle_table_remove(&states->by_id, id);
    if (state)
        free_state(state, NULL);
}

void build_states_release(struct build_states *states)
{
    handle_table_each(&states->by_id, free_state, NULL);
    handle_table_release(&states->by_id);
}
