/* SPDX-License-Identifier: Apache-2.0 */
/* Timestamps and clocks of sparse bindings. Only semaphores and fences order them (Vulkan
 * specification, Sparse Resource Memory Binding). */
#include "src/state/order/records.h"

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
    for (uint32_t i = 0; i < batch->operation_count; i++)
        if (operations[i].is_signal) {
            order_batch_set_signal(batch, &operations[i], &carried);
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
    if (order_batch_follow_waits(batch, &batch->clock, &batch->clock))
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
