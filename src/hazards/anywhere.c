/* SPDX-License-Identifier: Apache-2.0 */
/* Writes that shaders may make. */
#include "src/hazards/engine.h"

static struct write_anywhere *write_at(struct writes_anywhere *writes, uint64_t position)
{
    return &writes->items[position % WRITES_ANYWHERE];
}

static bool is_settled(const struct hazards *hazards, const struct write_anywhere *write)
{
    return write->number <= hazards->queues[write->queue].settled;
}

/* Whether a write is visible to a read of that kind by the current queue. */
static bool is_visible(const struct hazards *hazards, const struct write_anywhere *write,
                       enum access_kind read)
{
    const struct frontier *frontier = hazards->queues[hazards->queue].from[write->queue];
    return write->kind == ACCESS_KINDS || is_settled(hazards, write) ||
           (frontier && frontier_orders_write(frontier, write->number, write->kind, read));
}

static void drop_first(struct hazards *hazards)
{
    struct writes_anywhere *writes = &hazards->writes;
    const struct write_anywhere *write = write_at(writes, writes->first++);
    writes->dropped[write->queue] = write->number;
    if (!is_settled(hazards, write))
        writes->unsettled = write->number;
}

uint64_t hazards_write_anywhere(struct hazards *hazards, enum access_kind kind,
                                const struct hazard_bytes *bytes)
{
    struct writes_anywhere *writes = &hazards->writes;
    struct past *past = &hazards->queues[hazards->queue].past;
    const uint64_t number = ++hazards->number;
    if (writes->end - writes->first == WRITES_ANYWHERE)
        drop_first(hazards);
    *write_at(writes, writes->end++) = (struct write_anywhere){
        number, hazards->queue, kind, bytes ? *bytes : (struct hazard_bytes){.memory = 0}};
    writes->queues |= UINT32_C(1) << hazards->queue;
    if (kind < ACCESS_KINDS) {
        past->stages |= (stage_set)1 << access_stage(kind);
        past->writes |= (kind_set)1 << kind;
    }
    return number;
}

uint64_t hazards_last_forgotten_write(const struct hazards *hazards)
{
    return hazards->writes.unsettled;
}

/* Whether a write may be open that was dropped. */
static bool has_forgotten(const struct hazards *hazards)
{
    const struct writes_anywhere *writes = &hazards->writes;
    for (uint32_t rest = writes->unsettled ? writes->queues : 0; rest; rest &= rest - 1)
        if (writes->unsettled > hazards->queues[__builtin_ctz(rest)].settled)
            return true;
    return false;
}

/* Writes that are settled are visible to all reads to come: they need not be kept. */
uint64_t hazards_first_open_write(struct hazards *hazards, enum access_kind read)
{
    struct writes_anywhere *writes = &hazards->writes;
    while (writes->first < writes->end && is_settled(hazards, write_at(writes, writes->first)))
        drop_first(hazards);
    if (has_forgotten(hazards))
        return writes->unsettled;
    for (uint64_t i = writes->first; i < writes->end; i++) {
        const struct write_anywhere *write = write_at(writes, i);
        if (write->kind == ACCESS_KINDS || !is_visible(hazards, write, read))
            return write->number;
    }
    return hazards->number + 1;
}

struct hazard_side hazards_last_access(const struct hazards *hazards)
{
    return (struct hazard_side){.queue = hazards->queue, .number = hazards->number};
}

static bool may_write(const struct write_anywhere *write, const struct hazard_bytes *bytes)
{
    return !write->bytes.memory ||
           (write->bytes.memory == bytes->memory && write->bytes.begin < bytes->end &&
            bytes->begin < write->bytes.end);
}

/* Whether a write is not kept any more that may have come behind the access `since`. */
static bool has_dropped_since(const struct writes_anywhere *writes, uint64_t first,
                              const struct hazard_side *since)
{
    for (uint32_t rest = writes->queues; rest; rest &= rest - 1) {
        const uint32_t queue = (uint32_t)__builtin_ctz(rest);
        if (queue == since->queue ? writes->dropped[queue] > since->number
                                  : writes->dropped[queue] >= first)
            return true;
    }
    return false;
}

bool hazards_read_misses_writes(struct hazards *hazards, uint64_t first,
                                const struct hazard_side *since, const struct hazard_access *read,
                                struct hazard *hazard)
{
    struct writes_anywhere *writes = &hazards->writes;
    const struct write_anywhere *last = NULL;
    if (has_dropped_since(writes, first, since))
        return false;
    for (uint64_t i = writes->end; i-- > writes->first && write_at(writes, i)->number >= first;) {
        const struct write_anywhere *write = write_at(writes, i);
        if (!may_write(write, &read->bytes))
            continue;
        const bool visible = is_visible(hazards, write, read->kind);
        if (visible && (write->number > since->number || write->queue != since->queue))
            return false;
        if (!visible && !last)
            last = write;
    }
    if (!last)
        return false;
    const struct frontier *frontier = hazards->queues[hazards->queue].from[last->queue];
    const enum sync_stage d = access_stage(read->kind);
    *hazard = (struct hazard){
        .type = READ_AFTER_SHADER,
        .is_racing = last->queue != hazards->queue,
        .earlier = {last->queue, last->number, last->kind},
        .later = {hazards->queue, hazards->number, read->kind},
        .bytes = read->bytes,
        .is_ordered =
            frontier && frontier_executes(frontier, last->number, access_stage(last->kind), d),
        .is_available = frontier && frontier->available[last->kind][d] >= last->number};
    return true;
}
