/* SPDX-License-Identifier: Apache-2.0 */
/* Finds the barrier between two commands of a hazard that lacks a stage or an access on one side:
 * walks the barriers that were recorded between two commands of one queue. */
#include "layer/hazards/executed/reports.h"

#include "src/state/order/order.h"

struct barrier_lookup {
    const struct hazard *hazard;
    struct hazard_barrier_text *found;
    const struct hazard_batch_record *batch; /* that is walked */
    uint32_t next;                           /* index of the command that comes next in it */
    uint32_t later; /* index of the later command; UINT32_MAX: it is in another batch */
    struct hazard_barrier_text place; /* the command before the next entry */
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

static bool is_behind_earlier(const struct barrier_lookup *lookup)
{
    const struct hazard_batch_record *batch = lookup->batch;
    return lookup->next == batch->command_count ||
           batch->commands[lookup->next].first > lookup->hazard->earlier.number;
}

static void note_barrier(struct journal_walk *walk, const struct hazard_entry *entry)
{
    const struct barrier_lookup *lookup = walk->user;
    struct hazard_barrier_text place = lookup->place;
    place.call_site = entry->site;
    if (is_behind_earlier(lookup) && lacks_one_side(lookup->hazard, entry, &place))
        *lookup->found = place;
}

static void pass_command(struct journal_walk *walk, const struct hazard_entry *entry)
{
    struct barrier_lookup *lookup = walk->user;
    lookup->place.follows = entry->command;
    lookup->place.builds = entry->build_count;
    lookup->place.first_build = entry->first_build;
    walk->is_over = ++lookup->next > lookup->later;
}

static void begin_place(struct barrier_lookup *lookup, const struct journal *journal,
                        const char *follows)
{
    lookup->place = (struct hazard_barrier_text){
        .is_there = true, .command_buffer = journal->command_buffer, .follows = follows};
}

static void search_secondary(struct journal_walk *walk, const struct journal_entry *entry)
{
    begin_place(walk->user, entry->secondary, NULL);
    journal_walk_secondary(walk, entry);
    begin_place(walk->user, walk->journal, "vkCmdExecuteCommands");
}

/* A walk ends at the later command. */
static const struct journal_events searches = {
    .hazard_barrier = note_barrier, .hazard_command = pass_command, .execute = search_secondary};

static void search_batch(struct barrier_lookup *lookup, const struct hazard_batch_record *record)
{
    const struct order_batch *batch = record->batch;
    lookup->batch = record;
    lookup->next = 0;
    for (uint32_t i = 0; i < batch->command_count && lookup->next <= lookup->later; i++) {
        if (!batch->commands[i].captured)
            continue;
        begin_place(lookup, batch->commands[i].captured, NULL);
        journal_walk(batch->commands[i].captured, &searches, lookup);
    }
}

void hazard_search_find_barrier(const struct hazard_search *search, const struct hazard *hazard,
                                struct hazard_barrier_text *barrier)
{
    struct barrier_lookup lookup = {.hazard = hazard, .found = barrier, .later = UINT32_MAX};
    const uint32_t queue = hazard->later.queue;
    const struct order_batch *first = hazard_search_find_batch(search, hazard->earlier.number);
    bool is_behind = false;
    *barrier = (struct hazard_barrier_text){.is_there = false};
    if (hazard->is_racing || hazard->earlier.queue != queue || queue == HAZARD_HOST_QUEUE || !first)
        return;
    for (struct order_batch *batch = NULL; (batch = hazard_search_next(search, batch));) {
        is_behind |= batch == first;
        if (is_behind && batch->timestamp.queue == queue)
            search_batch(&lookup, batch->slots[USES_HAZARDS]);
    }
    lookup.later = search->current->command_count - 1;
    search_batch(&lookup, search->current);
}
