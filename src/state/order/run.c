/* SPDX-License-Identifier: Apache-2.0 */
/* The run list. It calls the consumers, on one thread at a time and without the lock. */
#include "src/state/order/records.h"

void execution_order_append_run(struct execution_order *order, struct order_batch *batch)
{
    submission_reference(batch->submission);
    batch->next = NULL;
    *order->run_end = batch;
    order->run_end = &batch->next;
}

/* Moves held batches to the run list, which frees them with the others. */
void execution_order_set_unknown_locked(struct execution_order *order,
                                        enum order_unknown_reason why)
{
    if (!order->order_unknown)
        order->unknown_reason = why;
    order->order_unknown = true;
    for (uint32_t i = 0; i < order->queue_count; i++) {
        struct order_queue *queue = &order->queues[i];
        if (!queue->held)
            continue;
        *order->run_end = queue->held;
        order->run_end = queue->held_end;
        queue->held = NULL;
        queue->held_end = &queue->held;
    }
    order->held_count = 0;
}

/* ---- running */

static void report_unknown(struct execution_order *order)
{
    order->unknown_reported = true;
    pthread_mutex_unlock(&order->lock);
    CALL_CONSUMERS(order, order_unknown, order->unknown_reason)
    pthread_mutex_lock(&order->lock);
}

/* Whether the batch must wait for the return of its call. */
static bool is_under_way(const struct order_batch *batch)
{
    return batch->submission->is_under_way && batch->submission->kind != SUBMIT_HOST_WORK;
}

/* Removes and returns the first batch of the run list. Returns NULL if its call is under way. */
static struct order_batch *take_first(struct execution_order *order)
{
    struct order_batch *batch = order->run_list;
    if (!batch || is_under_way(batch))
        return NULL;
    order->run_list = batch->next;
    if (!order->run_list)
        order->run_end = &order->run_list;
    return batch;
}

static void run(struct execution_order *order, struct order_batch *batch)
{
    if (!order->order_unknown) {
        pthread_mutex_unlock(&order->lock);
        atomic_store_explicit(&batch->state, BATCH_ORDERED, memory_order_release);
        batch_list_append_run(&order->batches, batch);
        CALL_CONSUMERS(order, run, batch)
        CALL_CONSUMERS(order, ran, batch)
        pthread_mutex_lock(&order->lock);
    }
    submission_unreference(batch->submission);
}

/* Returns false if nothing is ready. */
static bool run_first(struct execution_order *order)
{
    if (order->order_unknown && !order->unknown_reported) {
        report_unknown(order);
        return true;
    }
    struct order_batch *batch = take_first(order);
    if (batch)
        run(order, batch);
    return batch;
}

void execution_order_drain(struct execution_order *order)
{
    if (!drain_begin(&order->drain))
        return;
    do {
        while (run_first(order))
            continue;
    } while (drain_repeat(&order->drain));
}

/* ---- around the call */

void submission_submit(struct submission *submission)
{
    struct execution_order *order = submission->order;
    if (order->order_unknown || submission->kind != SUBMIT_COMMANDS)
        return;
    pthread_mutex_unlock(&order->lock);
    for (uint32_t i = 0; i < submission->batch_count; i++)
        CALL_CONSUMERS(order, submit, &submission->batches[i])
    pthread_mutex_lock(&order->lock);
}

void submission_check(struct submission *submission)
{
    struct execution_order *order = submission->order;
    bool is_runnable = submission->kind == SUBMIT_HOST_WORK
                           ? !order->run_list
                           : submission->ready_count && order->run_list == submission->batches;
    if (order->order_unknown || !is_runnable || submission->kind == SUBMIT_BINDINGS ||
        !drain_begin(&order->drain))
        return;
    for (uint32_t i = 0; i < submission->ready_count; i++)
        submission->batches[i].is_checked = true;
    pthread_mutex_unlock(&order->lock);
    uint32_t count = submission->kind == SUBMIT_HOST_WORK ? 1 : submission->ready_count;
    for (uint32_t i = 0; i < count; i++)
        CALL_CONSUMERS(order, check, &submission->batches[i])
    pthread_mutex_lock(&order->lock);
    drain_end(&order->drain);
}

/* Checked batches are at the head of the list, so no other thread runs batches. */
static void undo(struct submission *submission)
{
    struct execution_order *order = submission->order;
    drain_begin(&order->drain);
    pthread_mutex_unlock(&order->lock);
    for (uint32_t i = 0; i < submission->ready_count; i++)
        CALL_CONSUMERS(order, undo, &submission->batches[i])
    pthread_mutex_lock(&order->lock);
    drain_end(&order->drain);
}

void submission_withdraw(struct submission *submission)
{
    struct execution_order *order = submission->order;
    if (submission->kind == SUBMIT_HOST_WORK)
        return;
    if (submission->batches[0].is_checked && !order->order_unknown)
        undo(submission);
    for (struct order_batch **link = &order->run_list; *link;) {
        if ((*link)->submission != submission) {
            link = &(*link)->next;
            continue;
        }
        *link = (*link)->next;
        submission_unreference(submission); /* the caller still has one */
    }
    order->run_end = &order->run_list;
    while (*order->run_end)
        order->run_end = &(*order->run_end)->next;
}

void submission_report_failure(struct submission *submission)
{
    struct execution_order *order = submission->order;
    if (submission->kind != SUBMIT_COMMANDS)
        return;
    pthread_mutex_unlock(&order->lock);
    for (uint32_t i = 0; i < submission->batch_count; i++)
        CALL_CONSUMERS(order, fail, &submission->batches[i])
    pthread_mutex_lock(&order->lock);
}
