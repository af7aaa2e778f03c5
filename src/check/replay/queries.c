/* SPDX-License-Identifier: Apache-2.0 */
/* Queries of compacted sizes, in execution order.
 *
 * A query is written like a structure: it holds the structure that it was written for until it is
 * written again. A reset by a command buffer changes nothing: until the next write, the host reads
 * either the earlier result or none. A result that the host reads is trusted if the host knows that
 * its write has executed, or if there was only one write; otherwise it may be the result of an
 * earlier write. */
#include "src/check/replay/states.h"

/* Returns the record of the compacted size of a structure, or NULL. A compacted structure has none:
 * queries of it don't report the size that its source compacts to. */
static struct compacted_size *compacted_size_of(struct replay *replay,
                                                const struct journal_entry *entry)
{
    const struct built *built = replay_read(replay, entry);
    if (built->state != BUILT_BEFORE || built->compacted)
        return NULL;
    struct structure *state = structures_find(replay->structures, entry->src_id);
    if (!state->built.compacted_size)
        state->built.compacted_size = compacted_size_create();
    return state->built.compacted_size;
}

void replay_query(struct replay *replay, const struct journal_entry *entry)
{
    if (!entry->dst_id)
        return;
    struct built query = {
        .state = BUILT_UNKNOWN,
        .queried = entry->src,
        .sole = !structures_find(replay->structures, entry->dst_id),
        .compacted_size = compacted_size_of(replay, entry),
    };
    replay_write(replay, entry->dst_id, &query);
}

void replay_reset_queries(struct replay *replay, const struct journal_entry *entry)
{
    for (uint32_t i = 0; i < entry->info; i++)
        replay_erase(replay, entry->dst_id + i);
}

static bool is_visible_to_host(const struct host_view *host, const struct structure *state)
{
    return execution_clock_has(&host->executed, state->written) ||
           (state->built.sole && execution_clock_has(&host->submitted, state->written));
}

void replay_answer(struct replay *replay, const struct host_view *host,
                   const struct journal_entry *entry)
{
    const struct structure *state = structures_find(replay->structures, entry->src_id);
    if (!state || !replay->predecessors_known || !is_visible_to_host(host, state))
        return;
    struct compacted_size *compacted =
        entry->src ? compacted_size_of(replay, entry) : state->built.compacted_size;
    if (!compacted)
        return;
    compacted_size_update(compacted, entry->number);
    if (replay->compacted && entry->number)
        replay->compacted(replay->user, entry->src ? entry->src : state->built.queried,
                          entry->number);
}
