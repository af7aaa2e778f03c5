/* SPDX-License-Identifier: Apache-2.0 */
/* Finds the barrier between two commands of a hazard that lacks a stage or an access on one side:
 * walks the barriers that were recorded between two commands of one queue. Those behind a secondary
 * command buffer are left out. */
#include "layer/execution/hazards/reports.h"

#include "src/state/order/order.h"

struct barrier_search {
    const struct hazard *hazard;
    struct hazard_barrier_text *found;
};

/* ---- one barrier */

static bool covers_bytes(const struct hazard_entry *entry, const struct hazard_bytes *bytes)
{
    return entry->is_global || (entry->bytes.memory == bytes->memory &&
                                entry->bytes.begin < bytes->end && bytes->begin < entry->bytes.end);
}

/* Fills what the barrier lacks. Returns false if that is nothing, or something on both sides. */
static bool lacks_one_side(const struct hazard *hazard, const struct hazard_entry *entry,
                           struct hazard_barrier_text *barrier)
{
    const struct dependency *dependency = &entry->dependency;
    const enum access_kind earlier = hazard->earlier.kind, later = hazard->later.kind;
    const bool needs_access = hazard->type != WRITE_AFTER_READ;
    const bool src_stage = dependency->src & 1u << access_stage(earlier);
    const bool dst_stage = dependency->dst & 1u << access_stage(later);
    const bool has_src = src_stage && (!needs_access || dependency->src_kinds & 1u << earlier);
    const bool has_dst = dst_stage && (!needs_access || dependency->dst_kinds & 1u << later);
    barrier->lacks_src = !has_src;
    barrier->lacks_stage = has_src ? !dst_stage : !src_stage;
    return has_src != has_dst && !entry->is_acquisition && covers_bytes(entry, &hazard->bytes);
}

/* ---- all barriers between the commands */

/* `command`: the one before the barriers; its journal, and if it has an item, what it was. */
static void note_barrier(const struct barrier_search *search, const struct hazard_command *command,
                         const struct hazard_entry *entry)
{
    struct hazard_barrier_text barrier = {.is_there = true};
    if (!lacks_one_side(search->hazard, entry, &barrier))
        return;
    barrier.command_buffer = command->journal->command_buffer;
    if (command->item) {
        barrier.call_site = journal_site(command->journal, command->item->origin);
        barrier.follows = command->item->command;
        barrier.builds = command->item->info;
        barrier.first_build = command->item->geometry;
    }
    *search->found = barrier;
}

/* Walks from a place to the next command. */
static void search_barriers(const struct barrier_search *search,
                            const struct hazard_command *command, struct journal_cursor cursor)
{
    for (const struct hazard_entry *entry; (entry = hazard_next(&cursor));) {
        if (entry->kind == HAZARD_COMMAND || entry->kind == JOURNAL_EXECUTE)
            return;
        if (entry->kind == HAZARD_BARRIER)
            note_barrier(search, command, entry);
    }
}

enum { WALKED = JOURNAL_HAZARDS | JOURNAL_BIT(JOURNAL_EXECUTE) };

/* Searches behind the earlier command, and before the later one, which is the last of `current`. */
static void search_batch(const struct barrier_search *search,
                         const struct hazard_batch_record *batch, bool is_current)
{
    const uint64_t earlier = search->hazard->earlier.number;
    for (uint32_t i = 0; i < batch->command_count; i++) {
        const struct hazard_command *command = &batch->commands[i];
        const bool is_last = i + 1 == batch->command_count;
        const bool begins_journal = !i || command[-1].journal != command->journal;
        if (begins_journal && command->first > earlier)
            search_barriers(search, &(struct hazard_command){.journal = command->journal},
                            journal_start(command->journal, WALKED));
        if (is_last ? !is_current : command[1].first > earlier)
            search_barriers(search, command,
                            journal_start_at(command->journal, command->place, WALKED));
    }
}

void hazard_judge_find_barrier(const struct hazard_judge *judge, const struct hazard *hazard,
                               struct hazard_barrier_text *barrier)
{
    const struct barrier_search search = {hazard, barrier};
    const uint32_t queue = hazard->later.queue;
    const struct order_batch *first = hazard_judge_find_batch(judge, hazard->earlier.number);
    bool is_behind = false;
    *barrier = (struct hazard_barrier_text){.is_there = false};
    if (hazard->is_racing || hazard->earlier.queue != queue || queue == HAZARD_HOST_QUEUE || !first)
        return;
    for (struct order_batch *batch = NULL; (batch = hazard_judge_next(judge, batch));) {
        is_behind |= batch == first;
        if (is_behind && batch->timestamp.queue == queue)
            search_batch(&search, batch->slots[USES_HAZARDS], false);
    }
    search_batch(&search, judge->current, true);
}
