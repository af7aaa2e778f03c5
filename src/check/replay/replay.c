/* SPDX-License-Identifier: Apache-2.0 */
/* Replays journals. */
#include "src/check/replay/replay.h"

#include <string.h>

#include "src/check/replay/judge.h"
#include "src/check/replay/states.h"
#include "src/check/replay/update_inputs.h"
#include "src/state/builds/structures.h"

/* What writes structures, or decides what is known of them. */
#define STATE_KINDS                                                                                \
    (JOURNAL_WRITES | JOURNAL_BIT(JOURNAL_EXECUTE) | JOURNAL_BIT(JOURNAL_WAIT_EVENT))
/* What a submission or host command replays. */
#define REPLAYED_KINDS                                                                             \
    (STATE_KINDS | JOURNAL_BIT(JOURNAL_USE_MICROMAP) | JOURNAL_BIT(JOURNAL_RANGES) |               \
     JOURNAL_BIT(JOURNAL_BIND) | JOURNAL_BIT(JOURNAL_READ) | JOURNAL_BIT(JOURNAL_RESET_QUERIES) |  \
     JOURNAL_BIT(JOURNAL_ANSWER))

/* Applies a copy or update to the states that the command buffer knows by itself. If it doesn't
 * know the source, the result is unknown until submission. */

static void apply_copy(struct structures *known, const struct journal_entry *entry)
{
    const struct structure *source = structures_find(known, entry->src_id);
    if (!source) {
        structures_remove(known, entry->dst_id);
        return;
    }
    struct built copy = source->built;
    if (copy.state == BUILT_FILLED)
        copy = built_unknown;
    if (entry->kind == JOURNAL_COMPACT)
        copy.compacted = true;
    structures_set(known, entry->dst_id, &copy, timestamp_never());
}

static const struct built *filled_by(const struct journal_entry *entry)
{
    const bool reads_micromaps = entry->info == FILL_READS_ACCEL && entry->built.shapes;
    return entry->info == FILL_BUILDS_MICROMAP || reads_micromaps ? &entry->built : &built_filled;
}

static void apply_entries(struct structures *known, struct journal_cursor cursor);

static void apply_entry(struct structures *known, const struct journal_entry *entry)
{
    switch ((enum journal_kind)entry->kind) {
    case JOURNAL_BUILD:
        structures_set(known, entry->dst_id, &entry->built, timestamp_never());
        break;
    case JOURNAL_UPDATE:
    case JOURNAL_COPY:
    case JOURNAL_COMPACT:
        apply_copy(known, entry);
        break;
    case JOURNAL_FILL:
        structures_set(known, entry->dst_id, filled_by(entry), timestamp_never());
        break;
    case JOURNAL_EXECUTE:
        apply_entries(known, journal_start(entry->secondary, STATE_KINDS));
        break;
    /* The host may have built any structure meanwhile. */
    case JOURNAL_WAIT_EVENT:
        structures_release(known);
        break;
    default: /* not of STATE_KINDS */
        break;
    }
}

/* Recursive: the device limits how deep secondary command buffers nest
 * (VK_EXT_nested_command_buffer). */
static void apply_entries(struct structures *known, struct journal_cursor cursor)
{
    for (const struct journal_entry *entry; (entry = journal_next(&cursor));)
        apply_entry(known, entry);
}

/* Applies the entries before those of the last call. Called for the first entry that has a source
 * to check. */
static void find_known_states(struct command_buffer *command_buffer)
{
    const struct journal *journal = command_buffer->journal;
    struct journal_cursor cursor = journal_start(journal, STATE_KINDS);
    cursor.end = journal->call;
    apply_entries(&command_buffer->known, cursor);
    command_buffer->has_known_states = true;
}

static void judge_by_known_state(struct replay *replay, const struct structures *known,
                                 const struct journal *journal, struct journal_entry *entry)
{
    const struct structure *source = structures_find(known, entry->src_id);
    if (!source)
        return;
    entry->judged = true;
    if (entry->kind == JOURNAL_UPDATE)
        judge_update(replay, journal, entry, &source->built);
    else
        judge_read(replay, journal, entry, &source->built);
}

void replay_recorded(struct replay *replay, struct command_buffer *command_buffer)
{
    struct journal *journal = command_buffer->journal;
    struct journal_cursor cursor = journal_start_call(journal, REPLAYED_KINDS);
    for (struct journal_entry *entry; (entry = journal_next(&cursor));) {
        if (!command_buffer->has_known_states && journal_entry_has_source_to_check(entry))
            find_known_states(command_buffer);
        if (entry->kind == JOURNAL_USE_MICROMAP && !journal->incomplete)
            replay_record_micromap(replay, &command_buffer->known, journal, entry);
        else if (journal_entry_has_source_to_check(entry) && !journal->incomplete)
            judge_by_known_state(replay, &command_buffer->known, journal, entry);
    }
}

void replay_keep(struct command_buffer *command_buffer)
{
    if (command_buffer->has_known_states)
        apply_entries(&command_buffer->known,
                      journal_start_call(command_buffer->journal, STATE_KINDS));
}

/* ---- submissions */

/* Whether nothing but builds will have written the dst of a build. */
static bool stays_original(const struct replay *replay, uint64_t id)
{
    const struct structure *before = structures_find(replay->structures, id);
    return before ? before->built.is_original
                  : replay->never_is_certain && replay->predecessors_known;
}

static void write_build(struct replay *replay, const struct journal *journal,
                        const struct journal_entry *entry)
{
    struct built built = entry->built;
    if (built.type == VK_ACCELERATION_STRUCTURE_TYPE_OPACITY_MICROMAP_KHR)
        built.is_original = stays_original(replay, entry->dst_id);
    replay_note_build(replay, journal, entry, &built);
    replay_write(replay, entry->dst_id, &built);
}

static void write_copy(struct replay *replay, const struct journal_entry *entry)
{
    struct built copy = *replay_read(replay, entry);
    if (copy.state == BUILT_NEVER || copy.state == BUILT_FILLED)
        copy = built_unknown;
    copy.is_original = false;
    /* An update of a structure that is not compacted may change its compacted size, and so may a
     * second compaction: the compacted size is then unknown. */
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
        structures_copy_input(replay->structures, entry->dst_id, entry->src_id);
        break;
    case JOURNAL_FILL:
        replay_write(replay, entry->dst_id, filled_by(entry));
        break;
    case JOURNAL_USE_MICROMAP:
        replay_note_micromap(replay, journal, entry);
        break;
    case JOURNAL_BIND:
        replay_bind(replay, entry);
        break;
    case JOURNAL_EXECUTE:
        replay_submitted(replay, entry->secondary);
        break;
    case JOURNAL_READ:
        replay_query(replay, entry);
        break;
    case JOURNAL_RESET_QUERIES:
        replay_reset_queries(replay, entry, !journal->command_buffer);
        break;
    case JOURNAL_ANSWER:
        replay_answer(replay, journal->host, entry);
        break;
    default: /* ranges have been validated, and other entries write nothing */
        break;
    }
}

/* Validates the sparse bindings that a build uses. */
static void judge_sparse(struct replay *replay, const struct journal *journal,
                         const struct journal_entry *entry)
{
    if ((entry->dst_backing | entry->src_backing) & BACKED_BY_SPARSE)
        replay_backing(replay, journal, entry);
    if (entry->kind == JOURNAL_RANGES)
        replay_ranges(replay, journal, entry);
}

static void judge_by_live_states(struct replay *replay, const struct journal *journal,
                                 const struct journal_entry *entry)
{
    if (entry->kind == JOURNAL_UPDATE)
        judge_update(replay, journal, entry, replay_read(replay, entry));
    if (entry->kind == JOURNAL_USE_MICROMAP)
        replay_submit_micromap(replay, journal, entry);
    if (JOURNAL_READS & JOURNAL_BIT(entry->kind))
        judge_read(replay, journal, entry, replay_read(replay, entry));
}

static void submit_entry(struct replay *replay, const struct journal *journal,
                         const struct journal_entry *entry)
{
    if (!entry->judged)
        judge_by_live_states(replay, journal, entry);
    if (JOURNAL_BIT(entry->kind) & JOURNAL_READS)
        judge_copy_size(replay, journal, entry, replay_read(replay, entry));
    if (entry->kind == JOURNAL_COMPACT)
        replay_note_compaction(replay, journal, entry);
    if (entry->kind == JOURNAL_READ && entry->dst_id)
        replay_judge_query(replay, journal, entry);
    judge_sparse(replay, journal, entry);
    write_entry(replay, journal, entry);
}

/* Live states are in no order in memory, so a replay mostly waits for memory: prefetches the states
 * of this many entries together. */
enum { ENTRY_BATCH = 16 };

static uint32_t next_batch(struct journal_cursor *cursor,
                           const struct journal_entry *entries[ENTRY_BATCH])
{
    uint32_t count = 0;
    while (count < ENTRY_BATCH && (entries[count] = journal_next(cursor)))
        count++;
    return count;
}

static void fetch_states(const struct structures *states,
                         const struct journal_entry *const entries[], uint32_t count)
{
    for (uint32_t i = 0; i < count; i++)
        structures_prefetch(states, entries[i]->dst_id);
    for (uint32_t i = 0; i < count; i++)
        structures_prefetch_found(states, entries[i]->dst_id);
}

void replay_submitted(struct replay *replay, const struct journal *journal)
{
    struct journal_cursor cursor = journal_start(journal, REPLAYED_KINDS);
    const struct journal_entry *entries[ENTRY_BATCH];
    for (uint32_t count; (count = next_batch(&cursor, entries));) {
        fetch_states(replay->structures, entries, count);
        for (uint32_t i = 0; i < count; i++)
            submit_entry(replay, journal, entries[i]);
    }
}

/* ---- host commands */

void replay_judge_work(struct replay *replay, const struct journal *journal)
{
    struct journal_cursor cursor = journal_start(journal, REPLAYED_KINDS);
    for (const struct journal_entry *entry; (entry = journal_next(&cursor));) {
        judge_by_live_states(replay, journal, entry);
        if (JOURNAL_BIT(entry->kind) & JOURNAL_READS)
            judge_copy_size(replay, journal, entry, replay_read(replay, entry));
        judge_sparse(replay, journal, entry);
    }
}

void replay_begin_work(struct replay *replay, const struct journal *journal)
{
    struct journal_cursor cursor = journal_start(journal, JOURNAL_WRITES);
    for (const struct journal_entry *entry; (entry = journal_next(&cursor));) {
        if (!structures_add_writer(replay->structures, entry->dst_id))
            replay->out_of_memory = true;
    }
}

static void remove_writers(struct replay *replay, const struct journal *journal)
{
    struct journal_cursor cursor = journal_start(journal, JOURNAL_WRITES);
    for (const struct journal_entry *entry; (entry = journal_next(&cursor));)
        structures_remove_writer(replay->structures, entry->dst_id);
}

void replay_end_work(struct replay *replay, const struct journal *journal, bool failed)
{
    remove_writers(replay, journal);
    struct journal_cursor cursor = journal_start(journal, REPLAYED_KINDS);
    for (const struct journal_entry *entry; (entry = journal_next(&cursor));)
        if (!failed)
            write_entry(replay, journal, entry);
        else if (JOURNAL_WRITES & JOURNAL_BIT(entry->kind))
            replay_write(replay, entry->dst_id, &built_unknown);
}
