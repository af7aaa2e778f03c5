/* SPDX-License-Identifier: Apache-2.0 */
/* Replays journals. */
#include "src/check/replay/replay.h"

#include <string.h>

#include "src/check/replay/entry_rules.h"
#include "src/check/replay/states.h"
#include "src/check/replay/update_inputs.h"
#include "src/state/builds/structures.h"

/* What a structure is behind a copy or an update from a source. */
static struct built built_from(const struct built *source, const struct journal_entry *entry)
{
    struct built copy = *source;
    if (copy.state == BUILT_NEVER || copy.state == BUILT_FILLED)
        copy = built_unknown;
    copy.is_original = false;
    /* An update of a structure that is not compacted may change its compacted size, and so may a
     * second compaction: the compacted size is then unknown. */
    if (copy.compacted ? journal_entry_compacts(entry) : journal_is_update(entry))
        copy.compacted_size = NULL;
    copy.compacted |= journal_entry_compacts(entry);
    return copy;
}

/* ---- recording: `user` of the first walk is a struct structures, the states that the command
 * buffer knows by itself. If it doesn't know the source of a copy or update, the result is unknown
 * until submission. */

static void apply_copy(struct journal_walk *walk, const struct journal_entry *entry)
{
    struct structures *known = walk->user;
    const struct structure *source = structures_find(known, entry->src_id);
    if (!source) {
        structures_remove(known, entry->dst_id);
        return;
    }
    const struct built copy = built_from(&source->built, entry);
    structures_set(known, entry->dst_id, &copy, timestamp_never());
}

static const struct built *filled_by(const struct journal_entry *entry)
{
    const bool reads_micromaps = entry->info == FILL_READS_ACCEL && entry->built.shapes;
    return entry->info == FILL_BUILDS_MICROMAP || reads_micromaps ? &entry->built : &built_filled;
}

static void apply_build(struct journal_walk *walk, const struct journal_entry *entry)
{
    structures_set(walk->user, entry->dst_id, &entry->built, timestamp_never());
}

static void apply_fill(struct journal_walk *walk, const struct journal_entry *entry)
{
    structures_set(walk->user, entry->dst_id, filled_by(entry), timestamp_never());
}

/* While a command waits, the host may build any structure. */
static void apply_event(struct journal_walk *walk, const struct journal_entry *entry)
{
    if (entry->info == EVENT_WAIT)
        structures_release(walk->user);
}

static const struct journal_events applies = {.build = apply_build,
                                              .update = apply_copy,
                                              .copy = apply_copy,
                                              .fill = apply_fill,
                                              .execute = journal_walk_secondary,
                                              .use_event = apply_event};

/* Applies the entries before those of the last call. Called for the first entry that has a source
 * to check. */
static void find_known_states(struct command_buffer *command_buffer)
{
    struct journal_walk walk =
        journal_start(command_buffer->journal, &applies, &command_buffer->known);
    walk.end = command_buffer->journal->call;
    journal_go_on(&walk);
    command_buffer->has_known_states = true;
}

struct recorded_call {
    struct replay *replay;
    struct command_buffer *command_buffer;
};

/* Returns what the command buffer knows; NULL: its journal is incomplete. */
static const struct structures *known_states(const struct recorded_call *call)
{
    if (!call->command_buffer->has_known_states)
        find_known_states(call->command_buffer);
    return unknown_is_set(&call->command_buffer->journal->unknown) ? NULL
                                                                   : &call->command_buffer->known;
}

static void record_source(struct journal_walk *walk, const struct journal_entry *entry)
{
    const struct recorded_call *call = walk->user;
    const struct structures *known = known_states(call);
    const struct structure *source = known ? structures_find(known, entry->src_id) : NULL;
    if (!source)
        return;
    journal_set_judged(entry);
    if (journal_is_update(entry))
        judge_update(call->replay, walk->journal, entry, &source->built);
    else
        judge_read(call->replay, walk->journal, entry, &source->built);
}

static void record_micromap(struct journal_walk *walk, const struct journal_entry *entry)
{
    const struct recorded_call *call = walk->user;
    const struct structures *known = known_states(call);
    if (known)
        replay_record_micromap(call->replay, known, walk->journal, entry);
}

void replay_recorded(struct replay *replay, struct command_buffer *command_buffer)
{
    static const struct journal_events records = {.update = record_source,
                                                  .copy = record_source,
                                                  .read = record_source,
                                                  .use_micromap = record_micromap};
    struct recorded_call call = {replay, command_buffer};
    struct journal_walk walk = journal_start_call(command_buffer->journal, &records, &call);
    journal_go_on(&walk);
}

void replay_keep(struct command_buffer *command_buffer)
{
    struct journal_walk walk =
        journal_start_call(command_buffer->journal, &applies, &command_buffer->known);
    if (command_buffer->has_known_states)
        journal_go_on(&walk);
}

/* ---- what is validated: `user` of this walk and of those behind it is the struct replay */

static void judge_backing(struct journal_walk *walk, const struct journal_entry *entry)
{
    if ((entry->dst_backing | entry->src_backing) & BACKED_BY_SPARSE)
        replay_backing(walk->user, walk->journal, entry);
}

static void judge_update_entry(struct journal_walk *walk, const struct journal_entry *entry)
{
    if (!entry->judged)
        judge_update(walk->user, walk->journal, entry, replay_read(walk->user, entry));
    judge_backing(walk, entry);
}

static void judge_read_source(struct journal_walk *walk, const struct journal_entry *entry)
{
    if (!entry->judged)
        judge_read(walk->user, walk->journal, entry, replay_read(walk->user, entry));
    judge_copy_size(walk->user, walk->journal, entry, replay_read(walk->user, entry));
}

static void judge_copy(struct journal_walk *walk, const struct journal_entry *entry)
{
    judge_read_source(walk, entry);
    replay_note_compaction(walk->user, walk->journal, entry);
}

static void judge_read_entry(struct journal_walk *walk, const struct journal_entry *entry)
{
    judge_read_source(walk, entry);
    if (entry->dst_id)
        replay_judge_query(walk->user, walk->journal, entry);
}

static void judge_micromap(struct journal_walk *walk, const struct journal_entry *entry)
{
    if (!entry->judged)
        replay_submit_micromap(walk, entry);
}

/* ---- what is written */

/* Whether nothing but builds will have written the dst of a build. */
static bool stays_original(const struct replay *replay, uint64_t id)
{
    const struct structure *before = structures_find(replay->structures, id);
    return before ? before->built.is_original
                  : replay->never_is_certain && replay->predecessors_known;
}

static void write_build(struct journal_walk *walk, const struct journal_entry *entry)
{
    struct replay *replay = walk->user;
    struct built built = entry->built;
    if (built.type == VK_ACCELERATION_STRUCTURE_TYPE_OPACITY_MICROMAP_KHR)
        built.is_original = stays_original(replay, entry->dst_id);
    replay_note_build(replay, walk->journal, entry, &built);
    replay_write(replay, entry->dst_id, &built);
}

static void write_from_source(struct replay *replay, const struct journal_entry *entry)
{
    const struct built copy = built_from(replay_read(replay, entry), entry);
    replay_write(replay, entry->dst_id, &copy);
}

static void write_update(struct journal_walk *walk, const struct journal_entry *entry)
{
    replay_note_update(walk->user, walk->journal, entry);
    write_from_source(walk->user, entry);
}

static void write_copy(struct journal_walk *walk, const struct journal_entry *entry)
{
    const struct replay *replay = walk->user;
    write_from_source(walk->user, entry);
    structures_copy_input(replay->structures, entry->dst_id, entry->src_id);
}

static void write_fill(struct journal_walk *walk, const struct journal_entry *entry)
{
    replay_write(walk->user, entry->dst_id, filled_by(entry));
}

static void submit_secondary(struct journal_walk *walk, const struct journal_entry *entry)
{
    replay_submitted(walk->user, entry->secondary);
}

/* ---- submissions */

static void submit_entry(struct journal_walk *walk, const struct journal_entry *entry);

/* What is done with entries of a kind: how they are validated, and then what is written. */
#define ENTRIES(ON)                                                                                \
    ON(build, judge_backing, write_build)                                                          \
    ON(update, judge_update_entry, write_update)                                                   \
    ON(copy, judge_copy, write_copy)                                                               \
    ON(fill, NULL, write_fill)                                                                     \
    ON(read, judge_read_entry, replay_query)                                                       \
    ON(use_micromap, judge_micromap, replay_note_micromap)                                         \
    ON(ranges, replay_ranges, NULL)                                                                \
    ON(bind, NULL, replay_bind)                                                                    \
    ON(execute, NULL, submit_secondary)                                                            \
    ON(reset_queries, NULL, replay_reset_queries)                                                  \
    ON(answer, NULL, replay_answer)                                                                \
    ON(place, NULL, replay_note_place)
#define ON_JUDGED(event, judge, write) .event = (judge),
#define ON_WRITTEN(event, judge, write) .event = (write),
#define ON_SUBMITTED(event, judge, write) .event = submit_entry,
static const struct journal_events judges = {ENTRIES(ON_JUDGED)};
static const struct journal_events writes = {ENTRIES(ON_WRITTEN)};
static const struct journal_events submits = {ENTRIES(ON_SUBMITTED)};

/* The tables are constants of this file, so the compiler calls their functions directly. */
static void submit_entry(struct journal_walk *walk, const struct journal_entry *entry)
{
    journal_hand(walk, &judges, entry);
    journal_hand(walk, &writes, entry);
}

/* Live states are in no order in memory, so a replay mostly waits for memory: prefetches the states
 * of this many entries together. */
enum { ENTRY_BATCH = 16 };

static uint32_t next_batch(struct journal_walk *walk,
                           const struct journal_entry *entries[ENTRY_BATCH])
{
    uint32_t count = 0;
    while (count < ENTRY_BATCH && (entries[count] = journal_next(walk)))
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
    struct journal_walk walk = journal_start(journal, &submits, replay);
    const struct journal_entry *entries[ENTRY_BATCH];
    for (uint32_t count; (count = next_batch(&walk, entries));) {
        fetch_states(replay->structures, entries, count);
        for (uint32_t i = 0; i < count; i++)
            submit_entry(&walk, entries[i]);
    }
}

/* ---- host commands */

void replay_judge_work(struct replay *replay, const struct journal *journal)
{
    journal_walk(journal, &judges, replay);
}

static void add_writer(struct journal_walk *walk, const struct journal_entry *entry)
{
    struct replay *replay = walk->user;
    if (!structures_add_writer(replay->structures, entry->dst_id))
        replay->out_of_memory = true;
}

void replay_begin_work(struct replay *replay, const struct journal *journal)
{
    static const struct journal_events begins = {ON_WRITES(add_writer)};
    journal_walk(journal, &begins, replay);
}

static void remove_writer(struct journal_walk *walk, const struct journal_entry *entry)
{
    const struct replay *replay = walk->user;
    structures_remove_writer(replay->structures, entry->dst_id);
}

static void write_unknown(struct journal_walk *walk, const struct journal_entry *entry)
{
    replay_write(walk->user, entry->dst_id, &built_unknown);
}

void replay_end_work(struct replay *replay, const struct journal *journal, bool failed)
{
    static const struct journal_events ends = {ON_WRITES(remove_writer)};
    static const struct journal_events failures = {ON_WRITES(write_unknown)};
    journal_walk(journal, &ends, replay);
    journal_walk(journal, failed ? &failures : &writes, replay);
}
