/* SPDX-License-Identifier: Apache-2.0 */
/* Semaphores (Vulkan specification, Synchronization and Cache Control: Semaphore Signaling,
 * Semaphore Waiting). */
#include <stdlib.h>
#include <string.h>

#include "src/hazards/engine.h"

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
    hazards->has_failed |= !completion;
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
        hazards->has_failed = true;
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
