/* SPDX-License-Identifier: Apache-2.0 */
/* Collects the batches of one submitting call. Submissions are reused and keep their arrays, so a
 * call allocates nothing if an earlier one was as large. And timestamps and clocks of sparse
 * bindings. */
#include <stdlib.h>
#include <string.h>

#include "src/base/array.h"
#include "src/state/order/records.h"

static void start_over(struct submission *submission)
{
    submission->next = NULL;
    submission->is_under_way = false;
    submission->fence = VK_NULL_HANDLE;
    submission->destroy_count = 0;
    submission->queue_record = NULL;
    atomic_init(&submission->references, 1);
    submission->out_of_memory = submission->may_follow_held = false;
    submission->skip = submission->signals_foreign_object = false;
    submission->ready_count = 0;
    submission->batch_count = submission->operation_count = submission->command_count = 0;
}

struct submission *submission_create(struct execution_order *order, enum submission_kind kind,
                                     VkQueue queue)
{
    struct submission *submission = order->spare;
    if (submission)
        order->spare = submission->next;
    else
        submission = calloc(1, sizeof(*submission));
    if (!submission) {
        execution_order_set_unknown_locked(order, ORDER_UNKNOWN_OUT_OF_MEMORY);
        return NULL;
    }
    submission->order = order;
    submission->kind = kind;
    submission->origin = (struct submission_origin){.queue = queue};
    start_over(submission);
    return submission;
}

struct submission *submission_begin(struct execution_order *order, enum submission_kind kind,
                                    VkQueue queue)
{
    if (!order)
        return NULL;
    pthread_mutex_lock(&order->lock);
    struct submission *submission =
        unknown_is_set(&order->unknown) ? NULL : submission_create(order, kind, queue);
    if (!submission)
        execution_order_drain(order);
    pthread_mutex_unlock(&order->lock);
    return submission;
}

void submission_free(struct submission *submission)
{
    free(submission->batches);
    free(submission->operations);
    free(submission->commands);
    free(submission);
}

/* Notes that memory ran out unless there is room for one more element. */
static bool reserved(struct submission *submission, bool has_room)
{
    submission->out_of_memory |= !has_room;
    return has_room;
}

/* A second batch of host work is its end. */
static const enum work_phase first_phase[] = {
    [SUBMIT_COMMANDS] = WORK_OF_QUEUE, [SUBMIT_BINDINGS] = WORK_OF_QUEUE,
    [SUBMIT_HOST_WORK] = WORK_BEGINS,  [SUBMIT_HOST_SIGNAL] = WORK_SYNC,
    [SUBMIT_HOST_WAIT] = WORK_SYNC,
};

void submission_add_batch(struct submission *submission)
{
    if (!submission ||
        !reserved(submission, ARRAY_HAS_ROOM(submission->batches, submission->batch_count,
                                             submission->batch_capacity)))
        return;
    struct order_batch *batch = &submission->batches[submission->batch_count++];
    batch->submission = submission;
    batch->work = first_phase[submission->kind];
    batch->next = NULL;
    batch->commands = NULL;
    batch->uses = batch->sequences = 0;
    memset(batch->slots, 0, sizeof(batch->slots));
    atomic_init(&batch->last_destroyed, 0);
    atomic_init(&batch->state, BATCH_COLLECTED);
    batch->first_operation = submission->operation_count;
    batch->first_commands = submission->command_count;
    batch->operation_count = batch->command_count = 0;
    batch->is_open = batch->predecessors_known = batch->is_checked = batch->is_replayed = false;
    batch->skips_call = false;
    batch->timestamp = timestamp_never();
    batch->clock.queues = 0;
}

/* Returns NULL if the submission is incomplete because memory ran out. */
static struct order_batch *last_batch(struct submission *submission)
{
    return submission && !submission->out_of_memory && submission->batch_count
               ? &submission->batches[submission->batch_count - 1]
               : NULL;
}

static void add_operation(struct submission *submission,
                          const struct semaphore_operation *operation)
{
    struct order_batch *batch = last_batch(submission);
    if (!batch || !operation->handle ||
        !reserved(submission, ARRAY_HAS_ROOM(submission->operations, submission->operation_count,
                                             submission->operation_capacity)))
        return;
    submission->operations[submission->operation_count] = *operation;
    submission->operations[submission->operation_count++].stages =
        VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT;
    batch->operation_count++;
}

void submission_add_wait(struct submission *submission, VkSemaphore semaphore, uint64_t value,
                         enum semaphore_scope scope)
{
    add_operation(submission, &(struct semaphore_operation){
                                  .handle = semaphore, .value = value, .scope = scope});
}

void submission_add_signal(struct submission *submission, VkSemaphore semaphore, uint64_t value,
                           enum semaphore_scope scope)
{
    add_operation(submission,
                  &(struct semaphore_operation){
                      .handle = semaphore, .value = value, .scope = scope, .is_signal = true});
}

void submission_set_stages(struct submission *submission, VkPipelineStageFlags2 stages)
{
    const struct order_batch *batch = last_batch(submission);
    if (batch && batch->operation_count)
        submission->operations[submission->operation_count - 1].stages = stages;
}

static void add_commands(struct submission *submission, VkCommandBuffer handle, void *captured)
{
    struct order_batch *batch = last_batch(submission);
    if (!batch ||
        !reserved(submission, ARRAY_HAS_ROOM(submission->commands, submission->command_count,
                                             submission->command_capacity))) {
        const struct execution_hooks *hooks = &submission->order->hooks;
        if (captured && hooks->release)
            hooks->release(hooks->user, captured);
        return;
    }
    submission->commands[submission->command_count++] =
        (struct submitted_commands){.handle = handle, .captured = captured};
    batch->command_count++;
}

void submission_describe(struct submission *submission)
{
    for (uint32_t i = 0; i < submission->batch_count; i++) {
        struct order_batch *batch = &submission->batches[i];
        batch->origin = submission->origin;
        if (!submission->queue_record)
            batch->origin.queue = VK_NULL_HANDLE;
        batch->destroy_count = submission->destroy_count;
        batch->host = &submission->host;
        batch->timed_out_waits = submission->timed_out_waits;
        batch->operations = order_batch_operations(batch);
        batch->commands =
            batch->command_count ? &submission->commands[batch->first_commands] : NULL;
        batch->signals_fence = submission->fence && i + 1 == submission->batch_count;
        batch->signals_foreign_object = submission->signals_foreign_object;
    }
}

void submission_add_commands(struct submission *submission, VkCommandBuffer command_buffer)
{
    if (!submission)
        return;
    const struct execution_hooks *hooks = &submission->order->hooks;
    struct order_batch *batch = last_batch(submission);
    void *captured = hooks->capture ? hooks->capture(hooks->user, command_buffer) : NULL;
    if (batch && captured && hooks->is_open &&
        hooks->is_open(hooks->user, submission->origin.queue, captured))
        batch->is_open = true;
    add_commands(submission, command_buffer, captured);
}

void submission_add_work(struct submission *submission, void *captured)
{
    if (submission)
        add_commands(submission, VK_NULL_HANDLE, captured);
}

void submission_set_skip(struct submission *submission)
{
    if (submission)
        submission->skip = true;
}

void submission_set_origin(struct submission *submission, const struct submission_origin *origin,
                           uint64_t destroy_count)
{
    if (!submission) {
        shared_labels_release(origin->labels);
        return;
    }
    submission->origin = *origin;
    submission->destroy_count = destroy_count;
}

void submission_set_fence(struct submission *submission, VkFence fence)
{
    if (submission)
        submission->fence = fence;
}

/* ---- Timestamps and clocks of sparse bindings. Only semaphores and fences order them (Vulkan
 * specification, Sparse Resource Memory Binding). */

/* Bindings have an index of their own, because they and the commands of their queue don't wait for
 * each other. Returns 0 if there are too many queues. */
static uint32_t index_of_bindings(struct order_queue *queue, struct execution_order *order)
{
    if (!queue->bindings_index && order->queue_count < EXECUTION_QUEUES) {
        struct order_queue *record = &order->queues[order->queue_count];
        record->index = queue->bindings_index = order->queue_count++;
        record->held_end = &record->held;
    }
    return queue->bindings_index;
}

/* A clock that covers a batch covers all earlier batches of that index. So the batch is only added
 * if the clock covers the batch before. */
static void add_bindings(struct execution_clock *clock, const struct order_batch *batch)
{
    struct timestamp before = {batch->timestamp.queue, batch->timestamp.count - 1};
    if (batch->timestamp.count && (!before.count || execution_clock_has(clock, before)))
        execution_clock_add(clock, batch->timestamp);
}

/* The fence of the submission is signaled after all of its batches. */
static void signal_after_bindings(struct order_batch *batch, struct queue_clocks *clocks)
{
    const struct submission *submission = batch->submission;
    struct semaphore_operation *operations = order_batch_operations(batch);
    bool has_fence = submission->fence && order_batch_is_last(batch), signals = has_fence;
    struct execution_clock carried;
    execution_clock_copy(&carried, &clocks->signalled);
    execution_clock_join(&carried, &batch->clock);
    add_bindings(&carried, batch);
    execution_clock_join(&clocks->behind, &carried);
    for (uint32_t i = 0; i < batch->operation_count; i++)
        if (operations[i].is_signal) {
            order_batch_set_signal(batch, &operations[i], &carried, &clocks->behind);
            signals = true;
        }
    for (const struct order_batch *each = submission->batches; has_fence && each <= batch; each++) {
        execution_clock_join(&carried, &each->clock);
        add_bindings(&carried, each);
    }
    if (signals) {
        execution_clock_join(&clocks->signalled, &carried);
        execution_clock_join(&clocks->all, &carried);
    }
}

/* The layer does not track open waits through bindings, so one makes the order unknown. */
void order_batch_resolve_bindings(struct order_batch *batch, struct queue_clocks *clocks)
{
    struct submission *submission = batch->submission;
    execution_clock_copy(&batch->clock, &submission->host);
    if (order_batch_follow_waits(batch, &batch->clock, &batch->clock, &clocks->behind))
        execution_order_set_unknown_locked(submission->order, ORDER_UNKNOWN_TOO_MANY_WAITS);
    batch->predecessors_known = !submission->may_follow_held;
    batch->timestamp = (struct timestamp){0};
    if (batch->command_count) {
        uint32_t index = index_of_bindings(submission->queue_record, submission->order);
        if (index)
            batch->timestamp = (struct timestamp){index, ++clocks->bindings};
    }
    signal_after_bindings(batch, clocks);
}

void execution_order_join_all(struct execution_clock *clock, const struct order_queue *queue)
{
    execution_clock_join(clock, &queue->clocks.all);
    if (queue->clocks.bindings)
        execution_clock_add(clock,
                            (struct timestamp){queue->bindings_index, queue->clocks.bindings});
}
