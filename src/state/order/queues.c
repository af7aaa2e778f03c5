/* SPDX-License-Identifier: Apache-2.0 */
/* The order of one device, and the course of a submission through it. */
#include <stdlib.h>

#include "src/base/array.h"
#include "src/state/order/records.h"

VkResult execution_order_create(struct execution_order **order, const struct execution_hooks *hooks)
{
    *order = calloc(1, sizeof(**order));
    if (!*order)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    (*order)->hooks = *hooks;
    (*order)->queue_count = EXECUTION_HOST + 1;
    (*order)->run_end = &(*order)->run_list;
    pthread_mutex_init(&(*order)->lock, NULL);
    timed_condition_init(&(*order)->ran);
    pthread_mutex_init(&(*order)->batches.lock, NULL);
    return VK_SUCCESS;
}

/* ---- consumers */

bool execution_order_add_consumer(struct execution_order *order, struct batch_consumer consumer)
{
    if (!ARRAY_HAS_ROOM(order->consumers, order->consumer_count, order->consumer_capacity))
        return false;
    order->consumers[order->consumer_count++] = consumer;
    return true;
}

struct batch_list *execution_order_batches(struct execution_order *order)
{
    return &order->batches;
}

void execution_order_deliver(const struct execution_order *order)
{
    for (uint32_t i = 0; order && i < order->consumer_count; i++)
        if (order->consumers[i].deliver)
            order->consumers[i].deliver(order->consumers[i].user);
}

bool execution_order_wait(const struct execution_order *order)
{
    for (uint32_t i = 0; i < order->consumer_count; i++)
        if (order->consumers[i].wait && order->consumers[i].wait(order->consumers[i].user))
            return true;
    return false;
}

void execution_order_run_unordered(const struct execution_order *order, struct execution *execution)
{
    CALL_CONSUMERS(order, run_unordered, execution)
}

/* ---- the end */

static void free_semaphore(void *record)
{
    semaphore_clock_release(record);
    free(record);
}

void execution_order_end(struct execution_order *order)
{
    if (!order)
        return;
    pthread_mutex_lock(&order->lock);
    order->unknown_reported = true;
    execution_order_set_unknown_locked(order, ORDER_UNKNOWN_DEVICE_LOST);
    execution_order_drain(order);
    pthread_mutex_unlock(&order->lock);
}

void execution_order_destroy(struct execution_order *order)
{
    if (!order)
        return;
    execution_order_end(order);
    while (order->spare) {
        struct submission *submission = order->spare;
        order->spare = submission->next;
        submission_free(submission);
    }
    handle_table_drop(&order->semaphores, free_semaphore);
    handle_table_drop(&order->fences, free);
    pthread_mutex_destroy(&order->batches.lock);
    pthread_mutex_destroy(&order->lock);
    pthread_cond_destroy(&order->ran);
    free(order->consumers);
    free(order);
}

#define REASON(reason, cause, unchecked) {cause, "submissions of devices " unchecked},
const struct order_unknown_words order_unknown_words[] = {ORDER_UNKNOWN_REASONS(REASON)};

void execution_order_set_unknown(struct execution_order *order, enum order_unknown_reason why)
{
    if (!order)
        return;
    pthread_mutex_lock(&order->lock);
    execution_order_set_unknown_locked(order, why);
    execution_order_drain(order);
    pthread_mutex_unlock(&order->lock);
}

/* ---- preparing */

/* A queue gets its index at its first submission. Returns NULL if there are too many queues. */
static struct order_queue *find_queue(struct execution_order *order, VkQueue handle)
{
    for (uint32_t i = EXECUTION_HOST + 1; i < order->queue_count; i++)
        if (order->queues[i].handle == handle)
            return &order->queues[i];
    if (order->queue_count == EXECUTION_QUEUES)
        return NULL;
    struct order_queue *queue = &order->queues[order->queue_count];
    queue->handle = handle;
    queue->index = order->queue_count++;
    queue->held_end = &queue->held;
    return queue;
}

static bool has_queue(enum submission_kind kind)
{
    return kind == SUBMIT_COMMANDS || kind == SUBMIT_BINDINGS;
}

/* Two calls may submit to one queue at the same time (VK_KHR_internally_synchronized_queues). The
 * layer can't know which of them comes first, so the order becomes unknown. */
static bool take_queue(struct submission *submission)
{
    struct order_queue *queue = find_queue(submission->order, submission->origin.queue);
    if (!queue || queue->under_way) {
        execution_order_set_unknown_locked(submission->order, queue
                                                                  ? ORDER_UNKNOWN_RACING_THREADS
                                                                  : ORDER_UNKNOWN_TOO_MANY_QUEUES);
        return false;
    }
    queue->under_way = submission;
    submission->queue_record = queue;
    return true;
}

/* A held batch counts as not submitted until the call that releases it has returned. Before that,
 * the application may learn of its completion in ways that the layer can't track, and submit work
 * that depends on it. If that is possible, `may_follow_held` is set. */
static void start_batches(struct submission *submission)
{
    struct execution_order *order = submission->order;
    if (submission->out_of_memory)
        execution_order_set_unknown_locked(order, ORDER_UNKNOWN_OUT_OF_MEMORY);
    if (unknown_is_set(&order->unknown) || (has_queue(submission->kind) && !take_queue(submission)))
        return;
    submission->is_under_way = true;
    submission->may_follow_held = order->in_flight && order->held_count;
    execution_clock_copy(&submission->host, &order->host);
    submission->timed_out_waits = order->timed_out_waits;
    if (submission->kind != SUBMIT_HOST_WORK)
        order->in_flight++;

    submission_announce(submission);
    const struct order_fence *fence = execution_order_fence(order, submission->fence);
    submission->signals_foreign_object |= fence && fence->foreign;
    submission_resolve_ready(submission);
    if (submission->ready_count < submission->batch_count)
        order->waiting++;
    if (submission->out_of_memory)
        execution_order_set_unknown_locked(order, ORDER_UNKNOWN_OUT_OF_MEMORY);
    submission_describe(submission);
    submission_set_states(submission, BATCH_PREPARED);
    batch_list_append_submission(&order->batches, submission);
    if (has_queue(submission->kind))
        for (uint32_t i = 0; i < submission->ready_count; i++)
            if (submission->kind == SUBMIT_COMMANDS || submission->batches[i].command_count)
                execution_order_append_run(order, &submission->batches[i]);
}

/* ---- finishing */

static void end_submission(struct submission *submission)
{
    struct execution_order *order = submission->order;
    submission->is_under_way = false;
    if (submission->kind != SUBMIT_HOST_WORK)
        order->in_flight--;
    if (submission->ready_count < submission->batch_count)
        order->waiting--;
    if (submission->queue_record)
        submission->queue_record->under_way = NULL;
}

/* The second batch of host work is its end. */
static void add_end_of_work(struct submission *submission)
{
    submission_add_batch(submission);
    if (submission->out_of_memory)
        return;
    submission->batches[1].work = WORK_ENDS;
    submission->batches[1].first_commands = submission->batches[0].first_commands;
    submission->batches[1].command_count = submission->batches[0].command_count;
}

void order_batch_end_on_host(struct order_batch *batch)
{
    struct execution_order *order = batch->submission->order;
    batch->timestamp = (struct timestamp){EXECUTION_HOST, ++order->host_count};
    execution_clock_add(&order->host, batch->timestamp);
    execution_order_append_run(order, batch);
}

static void finish_successful(struct submission *submission)
{
    struct execution_order *order = submission->order;
    end_submission(submission);
    for (uint32_t i = 0; i < submission->ready_count && has_queue(submission->kind); i++)
        atomic_store_explicit(&submission->batches[i].state, BATCH_SUBMITTED, memory_order_release);
    if (unknown_is_set(&order->unknown))
        return;
    submission->serial = ++order->last_serial;
    submission_publish(submission);
    if (submission->kind == SUBMIT_HOST_WORK)
        order_batch_end_on_host(&submission->batches[1]);
    if (submission->kind == SUBMIT_HOST_SIGNAL && order->hooks.follows_host)
        order_batch_end_on_host(&submission->batches[0]);
    execution_order_release_held(order);
    if (order->held_count > EXECUTION_HELD_BATCHES)
        execution_order_set_unknown_locked(order, ORDER_UNKNOWN_TOO_MANY_WAITS);
}

/* If the device is lost, it may have executed a part of the submission. */
static void fail_batches(struct submission *submission, VkResult result)
{
    submission_withdraw(submission);
    submission_retract(submission);
    end_submission(submission);
    if (result == VK_ERROR_DEVICE_LOST)
        return;
    submission_set_states(submission, BATCH_FAILED);
    submission_report_failure(submission);
}

bool submission_prepare(struct submission *submission)
{
    if (!submission)
        return false;
    struct execution_order *order = submission->order;
    if (!submission->batch_count)
        submission_add_batch(submission);
    if (submission->kind == SUBMIT_HOST_WORK)
        add_end_of_work(submission);
    pthread_mutex_lock(&order->lock);
    if (!unknown_is_set(&order->unknown))
        start_batches(submission);
    bool is_prepared = submission->is_under_way;
    if (is_prepared) {
        submission_submit(submission);
        submission_check(submission);
    }
    bool skip = submission->skip;
    for (uint32_t i = 0; i < submission->batch_count; i++)
        skip |= submission->batches[i].skips_call;
    if (is_prepared && skip)
        fail_batches(submission, VK_ERROR_VALIDATION_FAILED_EXT);
    else if (is_prepared && submission->kind == SUBMIT_HOST_WORK)
        execution_order_append_run(order, &submission->batches[0]);
    execution_order_drain(order);
    pthread_mutex_unlock(&order->lock);
    return skip;
}

static void fail_work(struct submission *submission)
{
    end_submission(submission);
    submission->batches[1].work = WORK_FAILS;
    if (!unknown_is_set(&submission->order->unknown))
        order_batch_end_on_host(&submission->batches[1]);
}

static void finish_batches(struct submission *submission, VkResult result)
{
    struct execution_order *order = submission->order;
    if (result == VK_ERROR_DEVICE_LOST)
        execution_order_set_unknown_locked(order, ORDER_UNKNOWN_DEVICE_LOST);
    if (submission->is_under_way && result >= VK_SUCCESS)
        finish_successful(submission);
    else if (submission->is_under_way && submission->kind == SUBMIT_HOST_WORK)
        fail_work(submission);
    else if (submission->is_under_way)
        fail_batches(submission, result);
    submission_unreference(submission);
}

void submission_finish(struct submission *submission, VkResult result)
{
    if (!submission)
        return;
    struct execution_order *order = submission->order;
    pthread_mutex_lock(&order->lock);
    finish_batches(submission, result);
    execution_order_drain(order);
    pthread_mutex_unlock(&order->lock);
}

void submission_finish_silently(struct submission *submission, VkResult result)
{
    if (!submission)
        return;
    struct execution_order *order = submission->order;
    pthread_mutex_lock(&order->lock);
    finish_batches(submission, result);
    pthread_mutex_unlock(&order->lock);
}

void execution_order_run(struct execution_order *order)
{
    if (!order)
        return;
    pthread_mutex_lock(&order->lock);
    execution_order_drain(order);
    pthread_mutex_unlock(&order->lock);
}

/* Returns NULL if nothing was submitted to the queue, or if the order is unknown. */
static const struct order_queue *queue_in_use(const struct execution_order *order, VkQueue handle)
{
    for (uint32_t i = EXECUTION_HOST + 1;
         i < order->queue_count && !unknown_is_set(&order->unknown); i++)
        if (order->queues[i].handle == handle)
            return &order->queues[i];
    return NULL;
}

bool execution_order_holds_queue(struct execution_order *order, VkQueue handle)
{
    if (!order)
        return false;
    pthread_mutex_lock(&order->lock);
    const struct order_queue *queue = queue_in_use(order, handle);
    bool holds = queue && queue->held;
    pthread_mutex_unlock(&order->lock);
    return holds;
}

bool execution_order_has_pending(struct execution_order *order)
{
    pthread_mutex_lock(&order->lock);
    const bool is_own = order->drain.is_busy && pthread_equal(order->runner, pthread_self());
    const bool has_pending = order->held_count || (!is_own && (order->run_list || order->running));
    pthread_mutex_unlock(&order->lock);
    return has_pending;
}

struct submission *execution_order_under_way(struct execution_order *order, VkQueue handle)
{
    pthread_mutex_lock(&order->lock);
    const struct order_queue *queue = queue_in_use(order, handle);
    struct submission *submission = queue ? queue->under_way : NULL;
    pthread_mutex_unlock(&order->lock);
    return submission;
}
