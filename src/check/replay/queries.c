/* SPDX-License-Identifier: Apache-2.0 */
/* Queries of compacted sizes, in the order of execution.
 *
 * A query is written like a structure: it holds what was asked for, until it is written again. A
 * reset by a command buffer changes nothing: until it is written the host reads either what was
 * there before, or nothing. What the host reads is the answer of a write that it knows to have
 * executed, or of the only one there was; of any other it may be the answer of an earlier one. */
#include "src/check/replay/states.h"

/* What keeps the answers about a structure. A compacted one is what it was compacted to, whatever
 * queries of it say, so of that nothing is kept. */
static struct compacted_size *size_of(struct replay *replay, const struct journal_entry *entry)
{
    const struct built *built = replay_read(replay, entry);
    if (built->state != BUILT_BEFORE || built->compacted)
        return NULL;
    struct build_state *state = build_states_find(replay->states, entry->src_id);
    if (!state->built.compacted_size)
        state->built.compacted_size = compacted_size_create();
    return state->built.compacted_size;
}

void replay_query(struct replay *replay, const struct journal_entry *entry)
{
    struct built query = {
        .state = BUILT_UNKNOWN,
        .sole = !build_states_find(replay->states, entry->dst_id),
        .compacted_size = size_of(replay, entry),
    };
    replay_write(replay, entry->dst_id, &query);
}

void replay_reset_queries(struct replay *replay, const struct journal_entry *entry)
{
    for (uint32_t i = 0; i < entry->info; i++)
        replay_erase(replay, entry->dst_id + i);
}

static bool has_seen(const struct host_view *host, const struct build_state *state)
{
    return execution_clock_has(&host->executed, state->written) ||
           (state->built.sole && execution_clock_has(&host->submitted, state->written));
}

void replay_answer(struct replay *replay, const struct host_view *host,
                   const struct journal_entry *entry)
{
    const struct build_state *state = build_states_find(replay->states, entry->src_id);
    if (!state || !replay->predecessors_known || !has_seen(host, state))
        return;
    struct compacted_size *compacted =
        entry->src ? size_of(replay, entry) : state->built.compacted_size;
    if (compacted)
        compacted_size_learn(compacted, entry->size);
}
