/* SPDX-License-Identifier: Apache-2.0 */
/* Barriers, events and semaphores (Vulkan specification, Synchronization and Cache Control:
 * Pipeline Barriers, Memory Barriers, Events, Semaphore Signaling, Semaphore Waiting). */
#include <stdlib.h>
#include <string.h>

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
static void cross_barriers(struct hazards *hazards, const struct first_scope *scope,
                           const struct hazard_barrier *barriers, uint32_t count, uint64_t number)
{
    struct hazard_queue *queue = &hazards->queues[hazards->queue];
    struct crossing crossing = {*scope, barriers, count, 0, false};
    for (uint32_t i = 0; i < count; i++)
        if (!cross_pieces(hazards, scope, &barriers[i], number))
            unknown_set(&hazards->failure, UNKNOWN_HAZARDS);
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
    cross_barriers(hazards, &(struct first_scope){.before = number - 1}, barriers, count, number);
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
        unknown_set(&hazards->failure, UNKNOWN_HAZARDS);
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
        cross_barriers(hazards, &(struct first_scope){.before = set->before, .event = set},
                       barriers, count, number);
}

/* ---- semaphores */

/* ---- signals */

/* Raises executed[x] to what happens before a signal with the stages `src` on the current queue. */
static void signal_reach(const struct hazards *hazards, uint32_t past_queue, stage_set src,
                         uint64_t executed[SYNC_ACCESS_STAGES])
{
    const struct frontier *frontier = hazards->queues[hazards->queue].from[past_queue];
    const struct first_scope scope = {.before = hazards->number};
    for (unsigned x = 0; frontier && src && x < SYNC_ACCESS_STAGES; x++) {
        const uint64_t reach =
            scope_executed(&scope, frontier->executed[x], past_queue, past_queue == hazards->queue,
                           src, (enum sync_stage)x);
        executed[x] = later_of(executed[x], later_of(reach, frontier->settled));
    }
}

static bool row_is_empty(const uint64_t executed[SYNC_ACCESS_STAGES])
{
    uint64_t any = 0;
    for (unsigned x = 0; x < SYNC_ACCESS_STAGES; x++)
        any |= executed[x];
    return !any;
}

static void signal_join(uint64_t rows[HAZARD_QUEUES][SYNC_ACCESS_STAGES],
                        const struct signal *signal)
{
    for (uint32_t i = 0; i < signal->count; i++)
        for (unsigned x = 0; x < SYNC_ACCESS_STAGES; x++) {
            uint64_t *row = rows[signal->pasts[i].queue];
            row[x] = later_of(row[x], signal->pasts[i].executed[x]);
        }
}

/* Makes a signal of rows that are not empty. Returns NULL if memory runs out. */
static struct signal *signal_create(uint64_t rows[HAZARD_QUEUES][SYNC_ACCESS_STAGES])
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < HAZARD_QUEUES; i++)
        count += !row_is_empty(rows[i]);
    struct signal *signal = malloc(sizeof(*signal) + count * sizeof(signal->pasts[0]));
    if (!signal)
        return NULL;
    signal->number = signal->count = 0;
    for (uint32_t i = 0; i < HAZARD_QUEUES; i++)
        if (!row_is_empty(rows[i])) {
            struct signal_past *past = &signal->pasts[signal->count++];
            past->queue = i;
            memcpy(past->executed, rows[i], sizeof(past->executed));
        }
    return signal;
}

/* The first scope of a signal has the signals of the queue's earlier batches as well (signal
 * operation order). Those of one batch are not ordered. */
static void reach_signal(const struct hazards *hazards, stage_set src,
                         uint64_t rows[HAZARD_QUEUES][SYNC_ACCESS_STAGES])
{
    memcpy(rows, hazards->queues[hazards->queue].signalled, sizeof(hazards->signalled));
    for (uint32_t i = 0; i < HAZARD_QUEUES; i++)
        signal_reach(hazards, i, src, rows[i]);
}

/* The next batches' signals have this signal in their first scopes. */
static void note_signal(struct hazards *hazards, uint64_t rows[HAZARD_QUEUES][SYNC_ACCESS_STAGES])
{
    for (uint32_t i = 0; i < HAZARD_QUEUES; i++)
        for (unsigned x = 0; x < SYNC_ACCESS_STAGES; x++)
            hazards->signalled[i][x] = later_of(hazards->signalled[i][x], rows[i][x]);
    hazards->has_signalled = true;
}

static void end_signals(struct hazards *hazards)
{
    if (hazards->has_signalled)
        memcpy(hazards->queues[hazards->queue].signalled, hazards->signalled,
               sizeof(hazards->signalled));
    memset(hazards->signalled, 0, sizeof(hazards->signalled));
    hazards->has_signalled = false;
}

struct signal *hazards_complete_batch(struct hazards *hazards)
{
    end_signals(hazards);
    const struct hazard_queue *queue = &hazards->queues[hazards->queue];
    uint64_t rows[HAZARD_QUEUES][SYNC_ACCESS_STAGES] = {{0}};
    for (uint32_t i = 0; i < HAZARD_QUEUES; i++)
        if (i != hazards->queue)
            signal_reach(hazards, i, ALL_SYNC_STAGES, rows[i]);
    uint32_t known = 0;
    for (uint32_t i = 0; i < HAZARD_QUEUES; i++)
        known += i != hazards->queue && queue->from[i];
    if (!known)
        return NULL;
    struct signal *completion = signal_create(rows);
    if (!completion)
        unknown_set(&hazards->failure, UNKNOWN_HAZARDS);
    return completion;
}

/* The semaphore's signal before happens before this one, too. If it is no longer kept, everything
 * before does. */
static void reach_previous(struct hazards *hazards, uint64_t previous,
                           uint64_t rows[HAZARD_QUEUES][SYNC_ACCESS_STAGES])
{
    const struct signal *signal = hazards->signals[previous % HAZARD_SIGNALS];
    if (!previous || !signal || signal->number < previous)
        return; /* there was none */
    if (signal->number == previous) {
        signal_join(rows, signal);
    } else {
        hazards_settle_queue(hazards);
        reach_signal(hazards, ALL_SYNC_STAGES, rows);
    }
}

static void keep_signal(struct hazards *hazards, uint64_t number,
                        uint64_t rows[HAZARD_QUEUES][SYNC_ACCESS_STAGES])
{
    struct signal **kept = &hazards->signals[number % HAZARD_SIGNALS];
    if (!number || (*kept && (*kept)->number > number))
        return;
    free(*kept);
    *kept = signal_create(rows);
    if (*kept)
        (*kept)->number = number;
    else
        unknown_set(&hazards->failure, UNKNOWN_HAZARDS);
}

void hazards_signal(struct hazards *hazards, uint64_t number, uint64_t previous,
                    const struct dependency *src)
{
    uint64_t rows[HAZARD_QUEUES][SYNC_ACCESS_STAGES];
    reach_signal(hazards, src->src, rows);
    reach_previous(hazards, previous, rows);
    note_signal(hazards, rows);
    keep_signal(hazards, number, rows);
    hazards_settle_failure(hazards);
}

/* ---- waits */

void hazards_receive(struct hazards *hazards, const struct signal *signal, stage_set dst)
{
    for (uint32_t i = 0; i < signal->count; i++) {
        const struct signal_past *past = &signal->pasts[i];
        struct frontier *frontier = hazards_frontier(hazards, past->queue);
        if (frontier)
            frontier_receive(frontier, &hazards->queues[past->queue].past, past->executed, dst);
    }
}

void hazards_wait(struct hazards *hazards, uint64_t number, const struct dependency *dst)
{
    const struct signal *signal = hazards->signals[number % HAZARD_SIGNALS];
    if (signal && signal->number == number)
        hazards_receive(hazards, signal, dst->dst);
    else
        hazards_settle_queue(hazards);
    hazards_settle_failure(hazards);
}
