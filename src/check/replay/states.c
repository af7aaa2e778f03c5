/* SPDX-License-Identifier: Apache-2.0 */
/* Reads and writes live states in execution order. */
#include "src/check/replay/states.h"

#include "src/state/builds/structures.h"
#include "src/state/commands/query_pools.h"

const struct built built_unknown = {.state = BUILT_UNKNOWN};
const struct built built_filled = {.state = BUILT_FILLED};
static const struct built never = {.state = BUILT_NEVER};

/* Returns whether a write is certain to be visible to the batch. */
static bool is_visible(const struct replay *replay, struct timestamp written)
{
    bool is_own = written.queue == replay->now.queue && written.count == replay->now.count;
    return !written.count || (is_own && !replay->unordered) ||
           execution_clock_has(replay->follows, written);
}

static enum resource_kind kind_of_source(const struct journal_entry *entry)
{
    const VkObjectType type = journal_entry_type(entry);
    if (type == VK_OBJECT_TYPE_MICROMAP_EXT)
        return RESOURCE_MICROMAP;
    return type == VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_NV ? RESOURCE_ACCEL_NV : RESOURCE_ACCEL;
}

static bool source_is_alive(struct replay *replay, const struct journal_entry *entry)
{
    return resources_find_id(replay->resources, kind_of_source(entry), entry->src) == entry->src_id;
}

/* A structure without a state has never been built, unless it was destroyed and its state with
 * it. */
const struct built *replay_read(struct replay *replay, const struct journal_entry *entry)
{
    const struct structure *state = structures_find(replay->structures, entry->src_id);
    if (!entry->src_id || !replay->predecessors_known || replay->out_of_memory)
        return &built_unknown;
    if (!state)
        return replay->never_is_certain && source_is_alive(replay, entry) ? &never : &built_unknown;
    return !state->host_writers && is_visible(replay, state->written) ? &state->built
                                                                      : &built_unknown;
}

const struct built *replay_find_query(struct replay *replay, const struct journal_entry *entry)
{
    const struct structure *state = structures_find(replay->structures, entry->dst_id);
    if (!entry->dst_id || !replay->predecessors_known || replay->out_of_memory)
        return &built_unknown;
    if (!state)
        return replay->never_is_certain &&
                       query_pools_has(replay->query_pools, (VkQueryPool)(uintptr_t)entry->dst,
                                       entry->dst_id) == YES
                   ? NULL
                   : &built_unknown;
    return is_visible(replay, state->written) ? &state->built : &built_unknown;
}

static void note_undo(struct replay *replay, uint64_t id, struct structure *before)
{
    if (replay->may_fail && !structures_note_undo(replay->structures, id, before))
        replay->out_of_memory = true;
}

/* If two writes are unordered, the last one is unknown from then on. */
void replay_write(struct replay *replay, uint64_t id, const struct built *built)
{
    struct structure *before = structures_find(replay->structures, id);
    bool is_conflict = before && (before->host_writers || !is_visible(replay, before->written));
    struct timestamp written = is_conflict ? timestamp_never() : replay->now;
    if (is_conflict)
        built = &built_unknown;
    if (!id)
        return;
    note_undo(replay, id, before);
    if (before)
        structures_replace(replay->structures, before, built, written);
    else if (!structures_set(replay->structures, id, built, written))
        replay->out_of_memory = true;
}
