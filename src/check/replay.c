/* SPDX-License-Identifier: Apache-2.0 */
/* Replaying journals. */
#include "check/replay.h"

#include <string.h>

#include "check/walk.h"

/* Secondary command buffers within secondary ones (VK_EXT_nested_command_buffer). */
enum { DEPTH_MAX = 8 };

static const struct built nothing = {.state = BUILT_UNKNOWN};
static const struct built never = {.state = BUILT_NEVER};

/* Judging. */

static void start_walk(struct walk *walk, struct check_context *context, struct replay *replay,
                       enum build_command command)
{
    context->found = replay->found;
    context->user = replay->user;
    walk->context = context;
    walk->findings = 0;
    memcpy(walk->wants, replay->active[command], sizeof(walk->wants));
}

static void judge_geometries(struct walk *walk, const struct update_view *update,
                             const struct location *build)
{
    const struct geometry_shapes *asked = update->asked->shapes, *source = update->source->shapes;
    if (!asked || !source || asked->count != source->count)
        return;
    struct location location = *build;
    location.subject = SUBJECT_GEOMETRY;
    for (uint32_t i = 0; i < asked->count; i++) {
        struct updated_geometry_view geometry = {
            .update = update, .index = i, .asked = &asked->items[i], .source = &source->items[i]};
        location.geometry = i;
        walk_updated_geometry(walk, &geometry, &location);
    }
}

static void judge(struct replay *replay, const struct command_buffer *command_buffer,
                  const struct journal_entry *entry, const struct built *source)
{
    if (source->state == BUILT_UNKNOWN || entry->built.state == BUILT_UNKNOWN)
        return;
    struct check_context context = {0};
    struct walk walk;
    start_walk(&walk, &context, replay, (enum build_command)entry->command);
    struct update_view update = {.src = entry->src, .asked = &entry->built, .source = source};
    struct location location = {.command = (enum build_command)entry->command,
                                .subject = SUBJECT_BUILD,
                                .build = entry->info};
    replay->locate(replay->user, command_buffer, entry->built.position);
    walk_update(&walk, &update, &location);
    judge_geometries(&walk, &update, &location);
}

/* What the command buffer knows by itself. A source that it does not know makes its result unknown
 * to it, too: that is for the submission to tell. */

static void keep_entry(struct build_states *known, const struct journal_entry *entry);

static void keep_secondary(struct replay *replay, struct build_states *known,
                           const struct journal_entry *entry, int depth);

static void keep_copy(struct build_states *known, const struct journal_entry *entry)
{
    const struct build_state *source = build_states_find(known, entry->src_id);
    if (!source) {
        build_states_remove(known, entry->dst_id);
        return;
    }
    struct built copy = source->built;
    if (entry->kind == JOURNAL_COMPACT)
        copy.compacted = true;
    build_states_set(known, entry->dst_id, &copy, (struct moment){0});
}

static void keep_entry(struct build_states *known, const struct journal_entry *entry)
{
    switch ((enum journal_kind)entry->kind) {
    case JOURNAL_BUILD:
        build_states_set(known, entry->dst_id, &entry->built, (struct moment){0});
        break;
    case JOURNAL_UPDATE:
    case JOURNAL_COPY:
    case JOURNAL_COMPACT:
        keep_copy(known, entry);
        break;
    case JOURNAL_FILL:
        build_states_set(known, entry->dst_id, &nothing, (struct moment){0});
        break;
    case JOURNAL_EXECUTE:
        break;
    }
}

/* A secondary that was recorded anew since invalidates what executes it; say no more of it. */
static const struct command_buffer *executed(struct replay *replay,
                                             const struct journal_entry *entry)
{
    const struct command_buffer *secondary =
        command_buffers_find(replay->command_buffers, entry->execute.secondary);
    return secondary && secondary->recording == entry->execute.recording ? secondary : NULL;
}

static void keep_entries(struct replay *replay, struct build_states *known,
                         struct journal_cursor cursor, int depth)
{
    for (const struct journal_entry *entry; (entry = journal_next(&cursor));) {
        if (entry->kind == JOURNAL_EXECUTE)
            keep_secondary(replay, known, entry, depth);
        else
            keep_entry(known, entry);
    }
}

static void keep_secondary(struct replay *replay, struct build_states *known,
                           const struct journal_entry *entry, int depth)
{
    const struct command_buffer *secondary = executed(replay, entry);
    if (secondary && depth < DEPTH_MAX)
        keep_entries(replay, known, journal_start(&secondary->journal), depth + 1);
}

static bool asks_for_a_source(const struct journal_entry *entry)
{
    return entry->kind == JOURNAL_UPDATE || entry->kind == JOURNAL_COPY ||
           entry->kind == JOURNAL_COMPACT;
}

/* Entries before `mark`, when the first update comes. */
static void learn(struct replay *replay, struct command_buffer *command_buffer,
                  const struct journal_mark *mark)
{
    struct journal_cursor cursor = journal_start(&command_buffer->journal);
    struct journal_cursor end = journal_start_after(&command_buffer->journal, mark);
    const struct journal_entry *stop = journal_next(&end);
    for (const struct journal_entry *entry; (entry = journal_next(&cursor)) && entry != stop;) {
        if (entry->kind == JOURNAL_EXECUTE)
            keep_secondary(replay, &command_buffer->known, entry, 0);
        else
            keep_entry(&command_buffer->known, entry);
    }
    command_buffer->knows = true;
}

void replay_recorded(struct replay *replay, struct command_buffer *command_buffer,
                     const struct journal_mark *mark)
{
    struct journal_cursor cursor = journal_start_after(&command_buffer->journal, mark);
    for (struct journal_entry *entry; (entry = journal_next(&cursor));) {
        if (!command_buffer->knows && asks_for_a_source(entry))
            learn(replay, command_buffer, mark);
        if (entry->kind != JOURNAL_UPDATE || command_buffer->journal.incomplete)
            continue;
        const struct build_state *source = build_states_find(&command_buffer->known, entry->src_id);
        if (!source)
            continue;
        entry->judged = true;
        judge(replay, command_buffer, entry, &source->built);
    }
}

void replay_keep(struct replay *replay, struct command_buffer *command_buffer,
                 const struct journal_mark *mark)
{
    if (command_buffer->knows)
        keep_entries(replay, &command_buffer->known,
                     journal_start_after(&command_buffer->journal, mark), 0);
}

/* Submissions. */

static bool is_settled(struct replay *replay, const struct build_state *state)
{
    return replay->follows(replay->user, state->written);
}

/* What a structure was last built with for a reader in this batch. A structure that nobody wrote
 * has never been built. */
static const struct built *live(struct replay *replay, uint64_t id)
{
    const struct build_state *state = build_states_find(replay->states, id);
    if (!id)
        return &nothing;
    if (!state)
        return &never;
    return is_settled(replay, state) ? &state->built : &nothing;
}

/* Two writes without an order between them leave it open for good which came last. */
static void write_state(struct replay *replay, uint64_t id, const struct built *built)
{
    const struct build_state *before = build_states_find(replay->states, id);
    bool contested = before && !is_settled(replay, before);
    if (contested && before->written.count != UINT64_MAX)
        build_states_set(replay->states, id, &nothing, moment_never());
    else if (!contested)
        build_states_set(replay->states, id, built, replay->now);
}

static void write_copy(struct replay *replay, const struct journal_entry *entry)
{
    struct built copy = *live(replay, entry->src_id);
    if (copy.state == BUILT_NEVER)
        copy = nothing;
    if (entry->kind == JOURNAL_COMPACT)
        copy.compacted = true;
    write_state(replay, entry->dst_id, &copy);
}

static void submit_entries(struct replay *replay, const struct command_buffer *command_buffer,
                           int depth);

static void submit_entry(struct replay *replay, const struct command_buffer *command_buffer,
                         const struct journal_entry *entry, int depth)
{
    const struct command_buffer *secondary;
    switch ((enum journal_kind)entry->kind) {
    case JOURNAL_BUILD:
        write_state(replay, entry->dst_id, &entry->built);
        break;
    case JOURNAL_UPDATE:
        if (!entry->judged)
            judge(replay, command_buffer, entry, live(replay, entry->src_id));
        write_copy(replay, entry);
        break;
    case JOURNAL_COPY:
    case JOURNAL_COMPACT:
        write_copy(replay, entry);
        break;
    case JOURNAL_FILL:
        write_state(replay, entry->dst_id, &nothing);
        break;
    case JOURNAL_EXECUTE:
        secondary = executed(replay, entry);
        if (secondary && depth < DEPTH_MAX)
            submit_entries(replay, secondary, depth + 1);
        break;
    }
}

static void submit_entries(struct replay *replay, const struct command_buffer *command_buffer,
                           int depth)
{
    struct journal_cursor cursor = journal_start(&command_buffer->journal);
    for (const struct journal_entry *entry; (entry = journal_next(&cursor));)
        submit_entry(replay, command_buffer, entry, depth);
}

void replay_submitted(struct replay *replay, const struct command_buffer *command_buffer)
{
    submit_entries(replay, command_buffer, 0);
}

void replay_forget(struct replay *replay, const struct command_buffer *command_buffer)
{
    struct journal_cursor cursor = journal_start(&command_buffer->journal);
    for (const struct journal_entry *entry; (entry = journal_next(&cursor));)
        if (entry->kind != JOURNAL_EXECUTE)
            build_states_set(replay->states, entry->dst_id, &nothing, replay->now);
}
