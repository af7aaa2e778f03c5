/* SPDX-License-Identifier: Apache-2.0 */
/* Barriers and events (Vulkan specification, Synchronization and Cache Control: Pipeline Barriers,
 * Memory Barriers, Events). */
#include <stdlib.h>

#include "src/hazards/engine.h"

/* ---- buffer barriers and the pieces of their bytes */

/* Whether the first scope of a buffer barrier has an earlier buffer barrier that made the piece's
 * write available. */
static bool continues_barrier(const struct hazards *hazards, const struct piece_notes *notes,
                              const struct first_scope *scope, stage_set src, uint64_t number)
{
    const struct chains *chains = hazards->queues[hazards->queue].chains;
    for (uint32_t i = 0; i < notes->barrier_count; i++) {
        const struct piece_barrier *barrier = &notes->barriers[i];
        if (barrier->queue != hazards->queue || barrier->number == number)
            continue;
        for (stage_set rest = barrier->dst; rest; rest &= rest - 1) {
            const enum sync_stage d = (enum sync_stage)__builtin_ctz(rest);
            if (scope_chain(scope, chains->reached[d], src, d) >= barrier->number)
                return true;
        }
    }
    return false;
}

/* Whether the piece's last write is available after a buffer barrier, and was not ordered before.
 */
static bool makes_available(const struct hazards *hazards, const struct piece *piece,
                            const struct first_scope *scope, const struct hazard_barrier *barrier,
                            uint64_t number)
{
    const uint32_t past_queue = mark_queue(piece->write);
    const enum access_kind k = mark_kind(piece->write);
    const uint64_t earlier = mark_number(piece->write);
    const stage_set src = barrier->dependency.src;
    const bool is_own = past_queue == hazards->queue;
    const struct frontier *frontier = hazards->queues[hazards->queue].from[past_queue];
    if (!piece->write || !frontier || earlier <= hazards->queues[past_queue].settled ||
        earlier <= frontier->settled)
        return false;
    if (is_own && scope_direct(scope, &barrier->dependency, k) >= earlier)
        return true;
    if (scope_available(scope, frontier->available[k], past_queue, src, k) >= earlier)
        return true;
    const enum sync_stage x = access_stage(k);
    if (barrier->is_acquisition &&
        scope_executed(scope, frontier->executed[x], past_queue, is_own, src, x) >= earlier)
        return true;
    return piece->notes && continues_barrier(hazards, piece->notes, scope, src, number);
}

/* Buffer barriers of the current queue may stand at the stages from now on. Returns false if memory
 * runs out. */
static bool chains_begin(struct hazards *hazards, stage_set stages)
{
    struct chains **chains = &hazards->queues[hazards->queue].chains;
    if (!*chains)
        *chains = calloc(1, sizeof(**chains));
    if (*chains)
        (*chains)->rows |= stages;
    return *chains;
}

/* Notes a buffer barrier with the pieces whose writes it makes available. Returns false if memory
 * runs out. */
static bool cross_pieces(struct hazards *hazards, const struct first_scope *scope,
                         const struct hazard_barrier *barrier, uint64_t number)
{
    const struct hazard_bytes *bytes = &barrier->bytes;
    struct hazard_memory *memory = hazards_memory(hazards, bytes->memory, false);
    if (barrier->is_global || bytes->begin >= bytes->end || !memory)
        return true;
    const stage_set dst = barrier->dependency.dst;
    const struct piece_barrier note = {number, hazards->queue, dst,
                                       barrier->dependency.dst_kinds & kinds_at(dst)};
    struct ranges *ranges = &memory->ranges;
    struct cursor cursor = ranges_find(ranges, bytes->begin);
    for (struct piece *piece = cursor_piece(cursor); piece && piece->begin < bytes->end;
         piece = cursor_piece(cursor)) {
        if (makes_available(hazards, piece, scope, barrier, number)) {
            piece = ranges_trim(ranges, &cursor, bytes->begin, bytes->end);
            if (!piece || !chains_begin(hazards, dst) || !piece_add_barrier(piece, &note))
                return false;
        }
        cursor_step(&cursor);
    }
    return true;
}

/* Executes the barriers of one command. */
static void cross(struct hazards *hazards, const struct first_scope *scope,
                  const struct hazard_barrier *barriers, uint32_t count, uint64_t number)
{
    struct hazard_queue *queue = &hazards->queues[hazards->queue];
    struct crossing crossing = {*scope, barriers, count, 0, false};
    for (uint32_t i = 0; i < count; i++)
        if (!cross_pieces(hazards, scope, &barriers[i], number))
            hazards->has_failed = true;
    for (uint32_t i = 0; i < HAZARD_QUEUES; i++) {
        crossing.past_queue = i;
        crossing.is_own = i == hazards->queue;
        if (queue->from[i])
            frontier_cross(queue->from[i], &hazards->queues[i].past, &crossing);
    }
    if (queue->chains)
        chains_cross(queue->chains, &crossing);
    hazards_settle_failure(hazards);
}

void hazards_barriers(struct hazards *hazards, const struct hazard_barrier *barriers,
                      uint32_t count)
{
    const uint64_t number = ++hazards->number;
    cross(hazards, &(struct first_scope){.before = number - 1}, barriers, count, number);
}

/* ---- events */

/* Fills in what happens before the event is set, of the accesses of one queue. */
static void reach_event(const struct hazards *hazards, struct hazard_event *event,
                        uint32_t past_queue, struct reached *reached)
{
    const struct frontier *frontier = hazards->queues[event->queue].from[past_queue];
    const struct past *past = &hazards->queues[past_queue].past;
    const struct first_scope scope = {.before = event->before};
    for (stage_set rest = past->stages; rest; rest &= rest - 1) {
        const enum sync_stage x = (enum sync_stage)__builtin_ctz(rest);
        reached->executed[x] = scope_executed(&scope, frontier->executed[x], past_queue,
                                              past_queue == event->queue, event->src, x);
    }
    for (kind_set rest = past->writes; rest; rest &= rest - 1) {
        const unsigned k = (unsigned)__builtin_ctz(rest);
        reached->available[k] = row_reach(frontier->available[k], event->src);
        reached->shared[k] = row_reach(frontier->shared[k], event->src);
    }
    event->reached[past_queue] = reached;
}

static struct hazard_event *event_create(struct hazards *hazards, stage_set src, uint64_t number)
{
    const struct hazard_queue *queue = &hazards->queues[hazards->queue];
    size_t count = 0;
    for (uint32_t i = 0; i < HAZARD_QUEUES; i++)
        count += queue->from[i] != NULL;
    struct hazard_event *event = calloc(1, sizeof(*event) + count * sizeof(struct reached));
    if (!event)
        return NULL;
    event->queue = hazards->queue;
    event->before = number - 1;
    event->src = src;
    struct reached *reached = (struct reached *)(event + 1);
    for (uint32_t i = 0; i < HAZARD_QUEUES; i++)
        if (queue->from[i])
            reach_event(hazards, event, i, reached++);
    const struct first_scope scope = {.before = event->before};
    for (stage_set rest = queue->chains ? queue->chains->rows : 0; rest; rest &= rest - 1) {
        const enum sync_stage x = (enum sync_stage)__builtin_ctz(rest);
        event->chains[x] = scope_chain(&scope, queue->chains->reached[x], src, x);
    }
    return event;
}

static void events_free(struct hazard_event *event)
{
    while (event) {
        struct hazard_event *next = event->next;
        free(event);
        event = next;
    }
}

void hazards_free_event(void *record)
{
    events_free(record);
}

/* Drops the settings that a new one covers: those with no other stages, as it comes later, and
 * those of other queues. Returns the rest. */
static struct hazard_event *drop_covered(struct hazard_event *event, const struct hazard_event *by)
{
    struct hazard_event *rest = NULL;
    while (event) {
        struct hazard_event *next = event->next;
        if (event->queue == by->queue && event->src & ~by->src) {
            event->next = rest;
            rest = event;
        } else {
            free(event);
        }
        event = next;
    }
    return rest;
}

void hazards_set_event(struct hazards *hazards, uint64_t event, stage_set src)
{
    const uint64_t number = ++hazards->number;
    struct hazard_event *set = event_create(hazards, src, number);
    if (set)
        set->next = drop_covered(handle_table_remove(&hazards->events, event + 1), set);
    if (!set || !handle_table_set(&hazards->events, event + 1, set)) {
        events_free(set);
        hazards->has_failed = true;
    }
    hazards_settle_failure(hazards);
}

void hazards_reset_event(struct hazards *hazards, uint64_t event)
{
    events_free(handle_table_remove(&hazards->events, event + 1));
}

void hazards_wait_event(struct hazards *hazards, uint64_t event,
                        const struct hazard_barrier *barriers, uint32_t count)
{
    const uint64_t number = ++hazards->number;
    const struct hazard_event *set = handle_table_find(&hazards->events, event + 1);
    for (; set && set->queue == hazards->queue; set = set->next)
        cross(hazards, &(struct first_scope){.before = set->before, .event = set}, barriers, count,
              number);
}
