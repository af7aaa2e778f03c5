/* SPDX-License-Identifier: Apache-2.0 */
/* Queries of properties, in execution order.
 *
 * A query is written like a structure: it holds the structure that it was written for until it is
 * written again. A reset by a command buffer keeps the structure: until the next write, the host
 * reads either the earlier result or none. A result that the host reads is trusted if the host
 * knows that its write has executed, or if there was only one write; otherwise it may be the result
 * of an earlier write. */
#include "src/check/replay/entry_rules.h"
#include "src/check/replay/update_inputs.h"
#include "src/check/walk/rows.h"
#include "src/view/life_view.h"

static WALK_ALL(written_query)

    void replay_judge_query(struct replay *replay, const struct journal *journal,
                            const struct journal_entry *entry)
{
    const struct built *before = replay_find_query(replay, entry);
    if (before && before->state != BUILT_BEFORE)
        return;
    struct entry_rules rules;
    entry_rules_begin_query(&rules, replay, journal, entry);
    const struct written_query_view view = {.pool = (VkQueryPool)(uintptr_t)entry->dst,
                                            .number = entry->read.number,
                                            .is_available = before != NULL};
    walk_written_query(&rules.walk, &view, &rules.location);
}

static bool is_serialization_size(VkQueryType type)
{
    return type == VK_QUERY_TYPE_ACCELERATION_STRUCTURE_SERIALIZATION_SIZE_KHR ||
           type == VK_QUERY_TYPE_MICROMAP_SERIALIZATION_SIZE_EXT;
}

/* Whether copies of a structure may report another result. */
static bool is_of_one_structure(VkQueryType type)
{
    return type == VK_QUERY_TYPE_ACCELERATION_STRUCTURE_SIZE_KHR || is_serialization_size(type);
}

/* Whether a query of this type reports a size of the build. Queries of a compacted structure don't
 * report the size that its source compacts to. */
static bool reports_size(const struct built *built, VkQueryType type)
{
    if (built->state == BUILT_FILLED)
        return built->is_micromap && is_serialization_size(type);
    return built->state == BUILT_BEFORE && !built->compacted &&
           (is_of_one_structure(type) ||
            type == VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_KHR ||
            type == VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_NV);
}

/* Returns the record of the sizes of a structure that a query reports, or NULL. */
static struct compacted_size *compacted_size_of(struct replay *replay,
                                                const struct journal_entry *entry, VkQueryType type)
{
    if (!reports_size(replay_read(replay, entry), type))
        return NULL;
    struct built *built = &structures_find(replay->structures, entry->src_id)->built;
    if (!built->compacted_size)
        built->compacted_size = compacted_size_create(entry->src_id);
    if (!built->compacted_size) {
        replay->sizes_may_be_unknown = true;
        return NULL;
    }
    if (type == VK_QUERY_TYPE_ACCELERATION_STRUCTURE_SIZE_KHR)
        built->compacted_size->full_is_queried = true;
    return is_of_one_structure(type) && built->compacted_size->serialized_id != entry->src_id
               ? NULL
               : built->compacted_size;
}

void replay_note_compaction(struct replay *replay, const struct journal *journal,
                            const struct journal_entry *entry)
{
    if (!replay->notes || !entry->read.size_pool ||
        !(replay_read(replay, entry)->flags &
          VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_COMPACTION_BIT_KHR))
        return;
    struct compacted_size *sizes =
        compacted_size_of(replay, entry, VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_KHR);
    if (sizes && !sizes->size)
        input_notes_add_copy(replay->notes, journal, entry, sizes);
}

void replay_query(struct journal_walk *walk, const struct journal_entry *entry)
{
    struct replay *replay = walk->user;
    const struct structure *before = structures_find(replay->structures, entry->dst_id);
    if (!entry->dst_id)
        return;
    struct built query = {
        .state = BUILT_BEFORE,
        .queried = entry->src,
        .sole = !before || before->built.unwritten,
        .compacted_size = compacted_size_of(replay, entry, entry->read.query),
    };
    replay_write(replay, entry->dst_id, &query);
}

/* The host resets only queries that no pending command uses, so nothing reads an earlier result. */
void replay_reset_queries(struct journal_walk *walk, const struct journal_entry *entry)
{
    struct replay *replay = walk->user;
    const bool by_host = !walk->journal->command_buffer;
    for (uint32_t i = 0; i < entry->info; i++) {
        const struct structure *before =
            by_host ? NULL : structures_find(replay->structures, entry->dst_id + i);
        struct built query = before ? before->built : (struct built){.unwritten = true};
        query.state = BUILT_NEVER;
        replay_write(replay, entry->dst_id + i, &query);
    }
}

static bool is_visible_to_host(const struct host_view *host, const struct structure *state)
{
    return execution_clock_has(&host->executed, state->written) ||
           (state->built.sole && execution_clock_has(&host->submitted, state->written));
}

void replay_answer(struct journal_walk *walk, const struct journal_entry *entry)
{
    struct replay *replay = walk->user;
    const struct structure *state = structures_find(replay->structures, entry->src_id);
    const VkQueryType type = (VkQueryType)entry->info;
    if (!state || !replay->predecessors_known || !is_visible_to_host(walk->journal->host, state))
        return;
    struct compacted_size *compacted =
        entry->src ? compacted_size_of(replay, entry, type) : state->built.compacted_size;
    if (!compacted)
        return;
    if (is_of_one_structure(type)) {
        *(is_serialization_size(type) ? &compacted->serialized : &compacted->full) = entry->number;
        return;
    }
    compacted_size_update(compacted, entry->number);
    if (replay->compacted && entry->number &&
        type == VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_KHR)
        replay->compacted(replay->user, entry->src ? entry->src : state->built.queried,
                          entry->number);
}
