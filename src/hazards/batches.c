/* SPDX-License-Identifier: Apache-2.0 */
/* Batches: what is ordered before one, and what is dropped once batches have completed. */
#include <stdlib.h>

#include "src/base/array.h"
#include "src/hazards/engine.h"

/* ---- records */

struct hazards *hazards_create(void (*found)(void *user, const struct hazard *hazard), void *user)
{
    struct hazards *hazards = calloc(1, sizeof(*hazards));
    if (!hazards)
        return NULL;
    hazards->found = found;
    hazards->user = user;
    return hazards;
}

static void memory_free(void *record)
{
    ranges_release(&((struct hazard_memory *)record)->ranges);
    free(record);
}

static void drop_accesses(struct hazards *hazards)
{
    handle_table_drop(&hazards->memories, memory_free);
    hazards->recent = NULL;
}

void hazards_destroy(struct hazards *hazards)
{
    if (!hazards)
        return;
    drop_accesses(hazards);
    for (uint32_t i = 0; i < HAZARD_SIGNALS; i++)
        free(hazards->signals[i]);
    handle_table_drop(&hazards->events, hazards_free_event);
    for (uint32_t i = 0; i < HAZARD_QUEUES; i++) {
        struct hazard_queue *queue = &hazards->queues[i];
        for (uint32_t j = 0; j < HAZARD_QUEUES; j++)
            free(queue->from[j]);
        free(queue->chains);
        for (uint32_t j = 0; j < queue->batch_count; j++)
            free(queue->batches[j].completion);
        free(queue->batches);
    }
    free(hazards);
}

struct frontier *hazards_frontier(struct hazards *hazards, uint32_t past_queue)
{
    struct frontier **frontier = &hazards->queues[hazards->queue].from[past_queue];
    if (!*frontier)
        *frontier = calloc(1, sizeof(**frontier));
    if (!*frontier)
        unknown_set(&hazards->failure, UNKNOWN_HAZARDS);
    return *frontier;
}

struct hazard_memory *hazards_memory(struct hazards *hazards, uint64_t id, bool is_new)
{
    if (hazards->recent && hazards->recent->id == id)
        return hazards->recent;
    struct hazard_memory *memory = handle_table_find(&hazards->memories, id + 1);
    if (!memory && is_new) {
        memory = calloc(1, sizeof(*memory));
        if (!memory)
            return NULL;
        memory->id = id;
        memory->ranges.piece_count = &hazards->piece_count;
        if (!handle_table_set(&hazards->memories, id + 1, memory)) {
            free(memory);
            return NULL;
        }
    }
    if (memory)
        hazards->recent = memory;
    return memory;
}

void hazards_settle_failure(struct hazards *hazards)
{
    if (!unknown_is_set(&hazards->failure))
        return;
    hazards->failure = (struct unknown){0};
    /* Without it, nothing that follows on this queue would count as ordered. */
    hazards_frontier(hazards, hazards->queue);
    drop_accesses(hazards);
    for (uint32_t i = 0; i < HAZARD_QUEUES; i++)
        hazards->queues[i].settled = hazards->number;
}

/* ---- batches */

/* Returns how many batches of a queue satisfy the condition, which the first ones do: they have
 * numbers up to `number`, or accesses that begin at `first` or before. */
static uint32_t count_batches(const struct hazard_queue *queue, uint64_t number, uint64_t first)
{
    uint32_t low = 0, count = queue->batch_count;
    while (count) {
        const uint32_t half = count / 2;
        const struct batch_record *batch = &queue->batches[low + half];
        const bool is_in = batch->number <= number && batch->first <= first;
        low = is_in ? low + half + 1 : low;
        count = is_in ? count - half - 1 : half;
    }
    return low;
}

uint64_t hazards_batch_of(const struct hazards *hazards, uint32_t queue, uint64_t number)
{
    const uint32_t count = count_batches(&hazards->queues[queue], UINT64_MAX, number);
    return count ? hazards->queues[queue].batches[count - 1].number : 0;
}

/* Returns the last number that a queue's batches up to `batch` have, or 0 if there are none. */
static uint64_t last_number(const struct hazards *hazards, const struct hazard_queue *queue,
                            uint64_t batch)
{
    const uint32_t count = count_batches(queue, batch, UINT64_MAX);
    if (count == queue->batch_count)
        return count ? hazards->number : 0;
    return count ? queue->batches[count].first - 1 : 0;
}

static void settle_frontier(struct hazards *hazards, uint32_t past_queue, uint64_t number)
{
    if (number <= hazards->queues[past_queue].settled)
        return;
    struct frontier *frontier = hazards_frontier(hazards, past_queue);
    if (frontier && frontier->settled < number)
        frontier->settled = number;
}

/* The host had observed the completion of a queue's batches before it submitted the current one. */
static void complete_batches(struct hazards *hazards, uint32_t past_queue, uint64_t batch)
{
    const struct hazard_queue *past = &hazards->queues[past_queue];
    const uint32_t count = count_batches(past, batch, UINT64_MAX);
    settle_frontier(hazards, past_queue, last_number(hazards, past, batch));
    if (!count || !past->batches[count - 1].completion)
        return;
    struct frontier *frontier = hazards_frontier(hazards, past_queue);
    if (!frontier || frontier->completed == past->batches[count - 1].number)
        return;
    frontier->completed = past->batches[count - 1].number;
    hazards_receive(hazards, past->batches[count - 1].completion, ALL_SYNC_STAGES);
}

void hazards_settle_queue(struct hazards *hazards)
{
    for (uint32_t i = 0; i < HAZARD_QUEUES; i++)
        if (hazards->queues[i].past.stages)
            settle_frontier(hazards, i, hazards->number);
}

void hazards_begin_batch(struct hazards *hazards, const struct hazard_batch *batch)
{
    struct hazard_queue *queue = &hazards->queues[batch->queue];
    hazards->queue = batch->queue;
    hazards->batch = batch->number;
    hazards->command_first = hazards->number + 1;
    hazards_frontier(hazards, batch->queue);
    for (uint32_t i = 0; i < HAZARD_QUEUES; i++)
        hazards->before[i] = i < batch->count ? batch->before[i] : 0;
    for (uint32_t i = 0; i < batch->count && i < HAZARD_QUEUES; i++)
        complete_batches(hazards, i, batch->completed[i]);
    if (!batch->is_certain)
        hazards_settle_queue(hazards);
    if (ARRAY_HAS_ROOM(queue->batches, queue->batch_count, queue->batch_capacity))
        queue->batches[queue->batch_count++] =
            (struct batch_record){batch->number, hazards->number + 1, NULL};
    else
        unknown_set(&hazards->failure, UNKNOWN_HAZARDS);
    hazards_settle_failure(hazards);
}

void hazards_end_batch(struct hazards *hazards)
{
    struct hazard_queue *queue = &hazards->queues[hazards->queue];
    const uint32_t count = queue->batch_count;
    struct signal *completion = hazards_complete_batch(hazards);
    if (count && queue->batches[count - 1].number == hazards->batch) {
        queue->batches[count - 1].completion = completion;
    } else { /* no record: what the batch accesses would never count as complete */
        free(completion);
        unknown_set(&hazards->failure, UNKNOWN_HAZARDS);
    }
    hazards_settle_failure(hazards);
}

/* ---- forgetting */

/* Drops the marks that are settled. Returns whether any is left. */
static bool piece_is_wanted(struct piece *piece, void *context)
{
    const struct hazards *hazards = context;
    access_mark *const write = &piece->write;
    access_mark left = 0;
    if (mark_number(*write) <= hazards->queues[mark_queue(*write)].settled)
        *write = 0;
    for (uint32_t i = 0; i < piece_read_count(piece); i++) {
        access_mark *const read = piece_read(piece, i);
        if (mark_number(*read) <= hazards->queues[mark_queue(*read)].settled)
            *read = 0;
        left |= *read;
    }
    return *write || left;
}

static void memory_sweep(void *record, void *context)
{
    struct hazard_memory *memory = record;
    ranges_sweep(&memory->ranges, piece_is_wanted, context);
}

void hazards_prune(struct hazards *hazards, const uint64_t *completed, uint32_t count)
{
    for (uint32_t i = 0; i < count && i < HAZARD_QUEUES; i++) {
        struct hazard_queue *queue = &hazards->queues[i];
        const uint64_t settled = last_number(hazards, queue, completed[i]);
        if (settled > queue->settled)
            queue->settled = settled;
        /* The last batch that has completed says what completed before it on other queues. */
        const uint32_t done = count_batches(queue, completed[i], UINT64_MAX);
        const uint32_t dropped = done ? done - 1 : 0;
        for (uint32_t j = 0; j < dropped; j++)
            free(queue->batches[j].completion);
        queue->batch_count -= dropped;
        for (uint32_t j = 0; dropped && j < queue->batch_count; j++)
            queue->batches[j] = queue->batches[j + dropped];
    }
    /* A sweep takes as long as there are pieces: sweeps wait until their number has doubled. */
    if (hazards->piece_count > 2 * hazards->swept_count) {
        handle_table_each(&hazards->memories, memory_sweep, hazards);
        hazards->swept_count = hazards->piece_count;
    }
}

void hazards_forget_memory(struct hazards *hazards, uint64_t memory)
{
    struct hazard_memory *record = handle_table_remove(&hazards->memories, memory + 1);
    hazards->recent = NULL;
    if (record)
        memory_free(record);
}

uint64_t hazards_piece_count(const struct hazards *hazards)
{
    return hazards->piece_count;
}
