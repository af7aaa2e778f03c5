/* SPDX-License-Identifier: Apache-2.0 */
/* Replaying journals. */
#include "src/check/replay/replay.h"

#include <string.h>

#include "src/check/replay/micromap.h"
#include "src/check/replay/states.h"
#include "src/check/replay/update_inputs.h"
#include "src/check/replay/updates.h"
#include "src/state/builds/built_flags.h"

/* What the command buffer knows by itself. A source that it does not know makes its result unknown
 * to it, too: that is for the submission to tell. */

static void keep_copy(struct build_states *known, const struct journal_entry *entry)
{
    const struct build_state *source = build_states_find(known, entry->src_id);
    if (!source) {
        build_states_remove(known, entry->dst_id);
        return;
    }
    struct built copy = source->built;
    if (copy.state == BUILT_FILLED)
        copy = built_unknown;
    if (entry->kind == JOURNAL_COMPACT)
        copy.compacted = true;
    build_states_set(known, entry->dst_id, &copy, timestamp_never());
}

static void keep_entries(struct build_states *known, struct journal_cursor cursor);

static void keep_entry(struct build_states *known, const struct journal_entry *entry)
{
    switch ((enum journal_kind)entry->kind) {
    case JOURNAL_BUILD:
        build_states_set(known, entry->dst_id, &entry->built, timestamp_never());
        break;
    case JOURNAL_UPDATE:
    case JOURNAL_COPY:
    case JOURNAL_COMPACT:
        keep_copy(known, entry);
        break;
    case JOURNAL_FILL:
        build_states_set(known, entry->dst_id, &built_filled, timestamp_never());
        break;
    case JOURNAL_EXECUTE:
        keep_entries(known, journal_start(entry->secondary));
        break;
    /* The host may have built anything meanwhile. */
    case JOURNAL_WAIT_EVENT:
        build_states_release(known);
        break;
    case JOURNAL_USE_MICROMAP:
    case JOURNAL_RANGES:
    case JOURNAL_BIND:
    case JOURNAL_QUERY:
    case JOURNAL_RESET_QUERIES:
    case JOURNAL_ANSWER:
    case JOURNAL_SET_EVENT:
    case JOURNAL_RESET_EVENT:
        break;
    }
}

/* Secondary command buffers nest as deep as the device allows (VK_EXT_nested_command_buffer). */
static void keep_entries(struct build_states *known, struct journal_cursor cursor)
{
    for (const struct journal_entry *entry; (entry = journal_next(&cursor));)
        keep_entry(known, entry);
}

/* Entries before `mark`, when the first that asks for a source comes. */
static void learn(struct command_buffer *command_buffer, const struct journal_mark *mark)
{
    struct journal_cursor cursor = journal_start(command_buffer->journal);
    struct journal_cursor end = journal_start_after(command_buffer->journal, mark);
    const struct journal_entry *stop = journal_next(&end);
    for (const struct journal_entry *entry; (entry = journal_next(&cursor)) && entry != stop;)
        keep_entry(&command_buffer->known, entry);
    command_buffer->has_known_states = true;
}

void replay_recorded(struct replay *replay, struct command_buffer *command_buffer,
                     const struct journal_mark *mark)
{
    struct journal *journal = command_buffer->journal;
    struct journal_cursor cursor = journal_start_after(journal, mark);
    for (struct journal_entry *entry; (entry = journal_next(&cursor));) {
        if (!command_buffer->has_known_states && journal_entry_has_source_to_check(entry))
            learn(command_buffer, mark);
        if (entry->kind == JOURNAL_USE_MICROMAP && !journal->incomplete)
            replay_record_micromap(replay, &command_buffer->known, journal, entry);
        if (entry->kind != JOURNAL_UPDATE || journal->incomplete)
            continue;
        const struct build_state *source = build_states_find(&command_buffer->known, entry->src_id);
        if (!source)
            continue;
        entry->judged = true;
        judge_update(replay, journal, entry, &source->built);
    }
}

void replay_keep(struct command_buffer *command_buffer, const struct journal_mark *mark)
{
    if (command_buffer->has_known_states)
        keep_entries(&command_buffer->known, journal_start_after(command_buffer->journal, mark));
}

/* Submissions. */

static void write_build(struct replay *replay, const struct journal *journal,
                        const struct journal_entry *entry)
{
    struct built built = entry->built;
    replay_note_build(replay, journal, entry, &built);
    replay_write(replay, entry->dst_id, &built);
}

static void write_copy(struct replay *replay, const struct journal_entry *entry)
{
    struct built copy = *replay_read(replay, entry);
    if (copy.state == BUILT_NEVER || copy.state == BUILT_FILLED)
        copy = built_unknown;
    /* An update of what is not compacted may compact to another size, and so may what is compacted
     * again; of that nothing is known. */
    if (copy.compacted ? entry->kind == JOURNAL_COMPACT : entry->kind == JOURNAL_UPDATE)
        copy.compacted_size = NULL;
    if (entry->kind == JOURNAL_COMPACT)
        copy.compacted = true;
    replay_write(replay, entry->dst_id, &copy);
}

static void write_entry(struct replay *replay, const struct journal *journal,
                        const struct journal_entry *entry)
{
    switch ((enum journal_kind)entry->kind) {
    case JOURNAL_BUILD:
        write_build(replay, journal, entry);
        break;
    case JOURNAL_UPDATE:
        replay_note_update(replay, journal, entry);
        write_copy(replay, entry);
        break;
    case JOURNAL_COPY:
    case JOURNAL_COMPACT:
        write_copy(replay, entry);
        break;
    case JOURNAL_FILL:
        replay_write(replay, entry->dst_id, &built_filled);
        break;
    case JOURNAL_USE_MICROMAP:
        replay_note_micromap(replay, journal, entry);
        break;
    case JOURNAL_RANGES:
    case JOURNAL_SET_EVENT:
    case JOURNAL_RESET_EVENT:
    case JOURNAL_WAIT_EVENT:
        break;
    case JOURNAL_BIND:
        replay_bind(replay, entry);
        break;
    case JOURNAL_EXECUTE:
        replay_submitted(replay, entry->secondary);
        break;
    case JOURNAL_QUERY:
        replay_query(replay, entry);
        break;
    case JOURNAL_RESET_QUERIES:
        replay_reset_queries(replay, entry);
        break;
    case JOURNAL_ANSWER:
        replay_answer(replay, journal->host, entry);
        break;
    }
}

/* What a build that uses sparse buffers finds bound to them. */
static void judge_sparse(struct replay *replay, const struct journal *journal,
                         const struct journal_entry *entry)
{
    if (entry->dst_is_sparse || entry->src_is_sparse)
        replay_backing(replay, journal, entry);
    if (entry->kind == JOURNAL_RANGES)
        replay_ranges(replay, journal, entry);
}

static void judge_live(struct replay *replay, const struct journal *journal,
                       const struct journal_entry *entry)
{
    if (entry->kind == JOURNAL_UPDATE)
        judge_update(replay, journal, entry, replay_read(replay, entry));
    if (entry->kind == JOURNAL_USE_MICROMAP)
        replay_submit_micromap(replay, journal, entry);
}

static void submit_entry(struct replay *replay, const struct journal *journal,
                         const struct journal_entry *entry)
{
    if (!entry->judged)
        judge_live(replay, journal, entry);
    judge_sparse(replay, journal, entry);
    write_entry(replay, journal, entry);
}

/* Most of a replay is waiting for live states, which lie in no order: those of so many entries are
 * fetched together. */
enum { ENTRIES_TOGETHER = 16 };

static uint32_t next_entries(struct journal_cursor *cursor,
                             const struct journal_entry *entries[ENTRIES_TOGETHER])
{
    uint32_t count = 0;
    while (count < ENTRIES_TOGETHER && (entries[count] = journal_next(cursor)))
        count++;
    return count;
}

static void fetch_states(const struct build_states *states,
                         const struct journal_entry *const entries[], uint32_t count)
{
    for (uint32_t i = 0; i < count; i++)
        build_states_prefetch(states, entries[i]->dst_id);
    for (uint32_t i = 0; i < count; i++)
        build_states_prefetch_found(states, entries[i]->dst_id);
}

void replay_submitted(struct replay *replay, const struct journal *journal)
{
    struct journal_cursor cursor = journal_start(journal);
    const struct journal_entry *entries[ENTRIES_TOGETHER];
    for (uint32_t count; (count = next_entries(&cursor, entries));) {
        fetch_states(replay->states, entries, count);
        for (uint32_t i = 0; i < count; i++)
            submit_entry(replay, journal, entries[i]);
    }
}

/* Work of the host. */

void replay_judge_work(struct replay *replay, const struct journal *journal)
{
    struct journal_cursor cursor = journal_start(journal);
    for (const struct journal_entry *entry; (entry = journal_next(&cursor));) {
        judge_live(replay, journal, entry);
        judge_sparse(replay, journal, entry);
    }
}

/* Queries are read and reset at once. */
static bool writes_a_structure(const struct journal_entry *entry)
{
    switch ((enum journal_kind)entry->kind) {
    case JOURNAL_BUILD:
    case JOURNAL_UPDATE:
    case JOURNAL_COPY:
    case JOURNAL_COMPACT:
    case JOURNAL_FILL:
        return true;
    case JOURNAL_USE_MICROMAP:
    case JOURNAL_RANGES:
    case JOURNAL_BIND:
    case JOURNAL_EXECUTE:
    case JOURNAL_QUERY:
    case JOURNAL_RESET_QUERIES:
    case JOURNAL_ANSWER:
    case JOURNAL_SET_EVENT:
    case JOURNAL_RESET_EVENT:
    case JOURNAL_WAIT_EVENT:
        break;
    }
    return false;
}

void replay_begin_work(struct replay *replay, const struct journal *journal)
{
    struct journal_cursor cursor = journal_start(journal);
    for (const struct journal_entry *entry; (entry = journal_next(&cursor));) {
        if (!writes_a_structure(entry))
            continue;
        built_flags_forget(replay->flags, entry->dst_id);
        if (!build_states_add_writer(replay->states, entry->dst_id))
            replay->out_of_memory = true;
    }
}

static void remove_writers(struct replay *replay, const struct journal *journal)
{
    struct journal_cursor cursor = journal_start(journal);
    for (const struct journal_entry *entry; (entry = journal_next(&cursor));) {
        struct build_state *state = build_states_find(replay->states, entry->dst_id);
        if (writes_a_structure(entry) && state && state->host_writers)
            state->host_writers--;
    }
}

void replay_end_work(struct replay *replay, const struct journal *journal, bool failed)
{
    remove_writers(replay, journal);
    struct journal_cursor cursor = journal_start(journal);
    for (const struct journal_entry *entry; (entry = journal_next(&cursor));)
        if (!failed)
            write_entry(replay, journal, entry);
        else if (writes_a_structure(entry))
            replay_write(replay, entry->dst_id, &built_unknown);
}
