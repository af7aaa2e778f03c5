/* SPDX-License-Identifier: Apache-2.0 */
/* Semaphores (Vulkan specification, Synchronization and Cache Control: Semaphore Signaling,
 * Semaphore Waiting). */
#include <stdlib.h>
#include <string.h>

#include "src/hazards/engine.h"

enum { SIGNALS_MAX = 32 };

struct semaphore {
    uint64_t dropped; /* signals up to this value may have been dropped */
    struct signal *last_dropped;
    uint32_t count;
    /* By ascending value. Each one includes those before it: the first scope of a wait has all
     * earlier signals of the semaphore. */
    struct signal *signals[SIGNALS_MAX + 1];
};

/* Drops the signals up to a value. */
static void semaphore_drop(struct semaphore *semaphore, uint64_t value)
{
    uint32_t dropped = 0;
    while (dropped < semaphore->count && semaphore->signals[dropped]->value <= value) {
        free(semaphore->last_dropped);
        semaphore->last_dropped = semaphore->signals[dropped++];
    }
    semaphore->count -= dropped;
    memmove(semaphore->signals, semaphore->signals + dropped,
            semaphore->count * sizeof(semaphore->signals[0]));
    semaphore->dropped = value > semaphore->dropped ? value : semaphore->dropped;
}

static void semaphore_free(void *record, void *context)
{
    (void)context;
    semaphore_drop(record, UINT64_MAX);
    free(((struct semaphore *)record)->last_dropped);
    free(record);
}

void hazards_free_signals(struct hazards *hazards)
{
    handle_table_each(&hazards->semaphores, semaphore_free, NULL);
    handle_table_release(&hazards->semaphores);
}

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
    signal->value = signal->count = 0;
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

/* Adds a signal, which it owns; or replaces the one with the same value. */
static void semaphore_add(struct semaphore *semaphore, struct signal *signal)
{
    uint32_t at = semaphore->count;
    while (at && semaphore->signals[at - 1]->value >= signal->value)
        at--;
    if (at < semaphore->count && semaphore->signals[at]->value == signal->value) {
        free(semaphore->signals[at]);
        semaphore->signals[at] = signal;
        return;
    }
    memmove(&semaphore->signals[at + 1], &semaphore->signals[at],
            (semaphore->count - at) * sizeof(semaphore->signals[0]));
    semaphore->signals[at] = signal;
    if (++semaphore->count > SIGNALS_MAX)
        semaphore_drop(semaphore, semaphore->signals[0]->value);
}

/* Returns the record of a semaphore, which it creates if there is none; or NULL if memory runs out.
 */
static struct semaphore *semaphore_get(struct hazards *hazards, uint64_t id)
{
    struct semaphore *semaphore = handle_table_find(&hazards->semaphores, id + 1);
    if (semaphore)
        return semaphore;
    semaphore = calloc(1, sizeof(*semaphore));
    if (semaphore && !handle_table_set(&hazards->semaphores, id + 1, semaphore)) {
        free(semaphore);
        return NULL;
    }
    return semaphore;
}

void hazards_signal(struct hazards *hazards, uint64_t semaphore, uint64_t value,
                    const struct dependency *src)
{
    uint64_t rows[HAZARD_QUEUES][SYNC_ACCESS_STAGES];
    reach_signal(hazards, src->src, rows);
    struct semaphore *record = semaphore_get(hazards, semaphore);
    if (record && record->last_dropped)
        signal_join(rows, record->last_dropped);
    for (uint32_t i = 0; record && i < record->count && record->signals[i]->value < value; i++)
        signal_join(rows, record->signals[i]);
    note_signal(hazards, rows);
    struct signal *signal = record ? signal_create(rows) : NULL;
    if (signal) {
        signal->value = value;
        semaphore_add(record, signal);
    } else {
        hazards->has_failed = true;
    }
    hazards_settle_failure(hazards);
}

void hazards_forget_signals(struct hazards *hazards, uint64_t semaphore, uint64_t value)
{
    struct semaphore *record = handle_table_find(&hazards->semaphores, semaphore + 1);
    if (!record)
        return;
    if (value == UINT64_MAX)
        semaphore_free(handle_table_remove(&hazards->semaphores, semaphore + 1), NULL);
    else
        semaphore_drop(record, value);
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

/* The last signal has the largest value. */
bool hazards_has_signal(const struct hazards *hazards, uint64_t semaphore, uint64_t value)
{
    const struct semaphore *record = handle_table_find(&hazards->semaphores, semaphore + 1);
    return record && value &&
           (value <= record->dropped ||
            (record->count && record->signals[record->count - 1]->value >= value));
}

void hazards_wait(struct hazards *hazards, uint64_t semaphore, uint64_t value,
                  const struct dependency *dst)
{
    const struct semaphore *record = handle_table_find(&hazards->semaphores, semaphore + 1);
    if (!record || !value)
        return;
    if (value <= record->dropped) {
        hazards_settle_queue(hazards);
    } else {
        for (uint32_t i = 0; i < record->count; i++)
            if (record->signals[i]->value >= value) {
                hazards_receive(hazards, record->signals[i], dst->dst);
                break;
            }
    }
    hazards_settle_failure(hazards);
}
