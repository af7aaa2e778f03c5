/* SPDX-License-Identifier: Apache-2.0 */
/* The run list. It calls the hooks, on one thread at a time and without the lock. */
#include "src/state/order/records.h"

void execution_order_append_run(struct execution_order *order, struct order_batch *batch)
{
    batch->submission->references++;
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

static void release_captured(const struct submission *submission)
{
    const struct execution_hooks *hooks = &submission->order->hooks;
    for (uint32_t i = 0; i < submission->command_count; i++)
        if (submission->commands[i].captured)
            hooks->release(hooks->user, submission->commands[i].captured);
}

void submission_unreference(struct submission *submission)
{
    struct execution_order *order = submission->order;
    if (--submission->references)
        return;
    if (submission->command_count && order->hooks.release) {
        pthread_mutex_unlock(&order->lock);
        release_captured(submission);
        pthread_mutex_lock(&order->lock);
    }
    shared_labels_release(submission->labels);
    submission->next = order->spare;
    order->spare = submission;
}

static enum work_phase phase_of(const struct order_batch *batch)
{
    const struct submission *submission = batch->submission;
    if (submission->kind == SUBMIT_HOST_SIGNAL || submission->kind == SUBMIT_HOST_WAIT)
        return WORK_SYNC;
    if (submission->kind != SUBMIT_HOST_WORK)
        return WORK_OF_QUEUE;
    if (batch == submission->batches)
        return WORK_BEGINS;
    return submission->state == SUBMISSION_FAILED ? WORK_FAILS : WORK_ENDS;
}

static struct batch_run describe(const struct order_batch *batch)
{
    const struct submission *submission = batch->submission;
    return (struct batch_run){
        .queue = submission->queue_record ? submission->queue : VK_NULL_HANDLE,
        .submission = submission->number,
        .queue_labels = submission->labels,
        .work = phase_of(batch),
        .timestamp = batch->timestamp,
        .clock = &batch->clock,
        .host = &submission->host,
        .operations = order_batch_operations(batch),
        .operation_count = batch->operation_count,
        .signals_fence = submission->fence && order_batch_is_last(batch),
        .is_exposed = submission->is_exposed,
        .commands = batch->command_count ? &submission->commands[batch->first_commands] : NULL,
        .command_count = batch->command_count,
        .checked = submission->checked && batch < &submission->batches[submission->ready_count],
        .destroy_count = submission->destroy_count,
        .predecessors_known = batch->predecessors_known,
    };
}

/* ---- running */

static void report_unknown(struct execution_order *order)
{
    order->unknown_reported = true;
    if (!order->hooks.order_unknown)
        return;
    order->busy = true;
    pthread_mutex_unlock(&order->lock);
    order->hooks.order_unknown(order->hooks.user, order->unknown_reason);
    pthread_mutex_lock(&order->lock);
    order->busy = false;
}

/* Whether the batch must wait for the return of its call. */
static bool is_under_way(const struct order_batch *batch)
{
    return batch->submission->state == SUBMISSION_PREPARED &&
           batch->submission->kind != SUBMIT_HOST_WORK;
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

static void run(struct execution_order *order, const struct order_batch *batch)
{
    if (!order->order_unknown && order->hooks.run) {
        struct batch_run description = describe(batch);
        order->busy = true;
        pthread_mutex_unlock(&order->lock);
        order->hooks.run(order->hooks.user, &description);
        pthread_mutex_lock(&order->lock);
        order->busy = false;
    }
    submission_unreference(batch->submission);
}

void execution_order_drain(struct execution_order *order)
{
    while (!order->busy) {
        struct order_batch *batch = NULL;
        if (order->order_unknown && !order->unknown_reported)
            report_unknown(order);
        else if ((batch = take_first(order)))
            run(order, batch);
        else
            break;
    }
}

/* ---- around the call */

bool submission_inspect(struct submission *submission)
{
    struct execution_order *order = submission->order;
    if (!order->hooks.inspect || order->order_unknown || submission->kind != SUBMIT_COMMANDS)
        return false;
    bool skip = false;
    pthread_mutex_unlock(&order->lock);
    for (uint32_t i = 0; i < submission->batch_count; i++) {
        struct batch_run description = describe(&submission->batches[i]);
        skip |= order->hooks.inspect(order->hooks.user, &description);
    }
    pthread_mutex_lock(&order->lock);
    return skip;
}

bool submission_check(struct submission *submission)
{
    struct execution_order *order = submission->order;
    bool is_runnable = submission->kind == SUBMIT_HOST_WORK
                           ? !order->run_list
                           : submission->ready_count && order->run_list == submission->batches;
    if (!order->hooks.check || order->order_unknown || order->busy || !is_runnable ||
        submission->kind == SUBMIT_BINDINGS)
        return false;
    bool skip = false;
    submission->checked = true;
    order->busy = true;
    pthread_mutex_unlock(&order->lock);
    uint32_t count = submission->kind == SUBMIT_HOST_WORK ? 1 : submission->ready_count;
    for (uint32_t i = 0; i < count; i++) {
        struct batch_run description = describe(&submission->batches[i]);
        skip |= order->hooks.check(order->hooks.user, &description);
    }
    pthread_mutex_lock(&order->lock);
    order->busy = false;
    return skip;
}

/* Checked batches are at the head of the list, so no other thread is in a hook. */
static void report_drop(struct execution_order *order)
{
    order->busy = true;
    pthread_mutex_unlock(&order->lock);
    order->hooks.drop(order->hooks.user);
    pthread_mutex_lock(&order->lock);
    order->busy = false;
}

void submission_withdraw(struct submission *submission)
{
    struct execution_order *order = submission->order;
    if (submission->kind == SUBMIT_HOST_WORK)
        return;
    if (submission->checked && order->hooks.drop && !order->order_unknown)
        report_drop(order);
    for (struct order_batch **link = &order->run_list; *link;) {
        if ((*link)->submission != submission) {
            link = &(*link)->next;
            continue;
        }
        *link = (*link)->next;
        submission->references--; /* the caller still has one */
    }
    order->run_end = &order->run_list;
    while (*order->run_end)
        order->run_end = &(*order->run_end)->next;
}
