/* SPDX-License-Identifier: Apache-2.0 */
/* Sparse buffers, in execution order: tracks their bindings, and validates the bindings that builds
 * find when they execute. */
#include "src/check/overlap/pairs.h"
#include "src/check/replay/entry_rules.h"
#include "src/check/walk/rows.h"

void replay_bind(struct journal_walk *walk, const struct journal_entry *entry)
{
    const struct replay *replay = walk->user;
    const struct sparse_binding binding = journal_binding(entry);
    resources_bind_sparse(replay->resources, &binding, replay->now, replay->follows);
}

/* ---- structures */

static WALK_ALL(unbound_access)

    static void report_missing(struct replay *replay, const struct journal *journal,
                               const struct journal_entry *entry,
                               const struct unbound_access_view *unbound)
{
    bool is_dst = unbound->is_dst;
    bool is_in_place = journal_is_update(entry) && entry->src_id == entry->dst_id;
    struct entry_rules rules;
    struct finding finding;
    entry_rules_begin_entry(&rules, replay, journal, entry);
    finding_says(&finding, is_dst ? "dstAccelerationStructure" : "srcAccelerationStructure",
                 "{} lies in {}, whose bytes [{}, {}) are not bound to memory",
                 object(VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR,
                        handle_number(unbound->structure->handle)),
                 object(VK_OBJECT_TYPE_BUFFER, handle_number(unbound->structure->buffer)),
                 hex(unbound->begin), hex(unbound->end));
    if (unbound->structure->fully_bound)
        also_violates(&finding, RULE_fully_bound_range_is_bound);
    if (is_in_place && is_dst)
        also_violates(&finding, RULE_update_src_is_backed_by_memory);
    else if (is_in_place)
        is_reported_with(&finding, RULE_dst_is_backed_by_memory);
    entry_rules_report(&rules,
                       is_dst ? RULE_dst_is_backed_by_memory : RULE_update_src_is_backed_by_memory,
                       &finding);
    if (is_dst || !is_in_place)
        walk_unbound_access(&rules.walk, unbound, &rules.location);
}

static void check_structure(struct replay *replay, const struct journal *journal,
                            const struct journal_entry *entry, bool is_dst)
{
    const uint64_t handle = is_dst ? entry->dst : entry->src;
    const uint64_t id = is_dst ? entry->dst_id : entry->src_id;
    struct accel_facts facts;
    resources_look_up_accel(replay->resources, (VkAccelerationStructureKHR)(uintptr_t)handle,
                            &facts);
    if (facts.id != id || !facts.is_sparse)
        return;
    const struct sparse_bytes bytes = {facts.buffer, facts.buffer_id, facts.begin,
                                       facts.begin + facts.size};
    struct sparse_bytes missing;
    if (resources_sparse_backing(replay->resources, &bytes, replay->follows, &missing) != NO)
        return;
    const struct unbound_access_view unbound = {
        .structure = &facts, .is_dst = is_dst, .begin = missing.begin, .end = missing.end};
    report_missing(replay, journal, entry, &unbound);
}

/* Silent if objects were destroyed since the submission: by now the batch may have completed, and
 * its memory may have been freed. */
void replay_backing(struct replay *replay, const struct journal *journal,
                    const struct journal_entry *entry)
{
    if (!replay->predecessors_known ||
        replay->destroy_count != resources_destroy_count(replay->resources))
        return;
    if (entry->dst_backing & BACKED_BY_SPARSE)
        check_structure(replay, journal, entry, true);
    if (entry->src_backing & BACKED_BY_SPARSE)
        check_structure(replay, journal, entry, false);
}

/* ---- ranges */

/* The ranges of the call, and the template for the pieces of the current range. */
struct range_search {
    struct sweep sweep;
    struct used_range range;
};

static void add_piece(void *user, const struct memory_span *piece)
{
    struct range_search *search = user;
    search->range.span = *piece;
    sweep_add(&search->sweep, &search->range);
}

static void find_ranges(struct replay *replay, const struct noted_ranges *noted,
                        struct range_search *search)
{
    for (uint32_t i = 0; i < noted->count; i++) {
        search->range = noted->items[i].range;
        if (search->range.is_sparse)
            resources_find_pieces(replay->resources, &noted->items[i].bytes, replay->follows,
                                  add_piece, search);
        else
            sweep_add(&search->sweep, &search->range);
    }
}

/* Skips journals with destroyed objects, which have been reported: their memory may have a new
 * owner. */
void replay_ranges(struct journal_walk *walk, const struct journal_entry *entry)
{
    struct replay *replay = walk->user;
    const struct journal *journal = walk->journal;
    if (!replay->predecessors_known || !entry->ranges ||
        journal->destroy_count != resources_destroy_count(replay->resources))
        return;
    const struct call_view call = {.command = (enum build_command)entry->command};
    const struct location first = {.command = call.command, .subject = SUBJECT_BUILD};
    struct range_search search;
    struct entry_rules rules;
    entry_rules_begin(&rules, replay, journal, entry->ranges->position, &first);
    sweep_init(&search.sweep);
    find_ranges(replay, entry->ranges, &search);
    pairs_walk_pieces(&rules.walk, &call, &search.sweep);
    sweep_release(&search.sweep);
}
