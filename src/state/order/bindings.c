/* SPDX-License-Identifier: Apache-2.0 */
/* Moments and clocks of sparse bindings, which semaphores and fences alone put in order (Vulkan
 * specification, Sparse Resource Memory Binding). */
#include "src/state/order/records.h"

/* Bindings count apart from the commands of their queue, as neither waits for the other. 0: there
 * are too many queues. */
static uint32_t index_of_bindings(struct order_queue *queue, struct execution_order *order)
{
    if (!queue->bindings_index && order->queue_count < EXECUTION_QUEUES) {
        struct order_queue *record = &order->queues[order->queue_count];
        record->index = queue->bindings_index = order->queue_count++;
        record->held_end = &record->held;
    }
    return queue->bindings_index;
}

/* A clock that names a batch names all before it, so that it can't name one without those. */
static void add_bindings(struct execution_clock *clock, const struct order_batch *batch)
{
    struct timestamp before = {batch->timestamp.queue, batch->timestamp.count - 1};
    if (batch->timestamp.count && (!before.count || execution_clock_has(clock, before)))
        execution_clock_add(clock, batch->timestamp);
}

/* The fence is signalled after all of its submission. */
static void signal_after_bindings(struct order_batch *batch, struct queue_clocks *clocks)
{
    const struct submission *submission = batch->submission;
    const struct semaphore_operation *operations = order_batch_operations(batch);
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
    for (const struct order_batch *of = submission->batches; has_fence && of <= batch; of++) {
        execution_clock_join(&carried, &of->clock);
        add_bindings(&carried, of);
    }
    if (signals) {
        execution_clock_join(&clocks->signalled, &carried);
        execution_clock_join(&clocks->all, &carried);
    }
}

/* An open wait can't be followed through bindings. */
void order_batch_resolve_bindings(struct order_batch *batch, struct queue_clocks *clocks)
{
    struct submission *submission = batch->submission;
    execution_clock_copy(&batch->clock, &submission->host);
    if (order_batch_follow_waits(batch, &batch->clock, &batch->clock))
        execution_order_set_unknown_locked(submission->order, ORDER_UNKNOWN_TOO_MANY_WAITS);
    batch->predecessors_known = !submission->uncertain;
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
