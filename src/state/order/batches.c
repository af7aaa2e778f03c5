/* SPDX-License-Identifier: Apache-2.0 */
/* The life of batches: their list, the references that keep them, and the run list. The run list
 * calls the consumers, on one thread at a time and without the lock. */
#include "src/state/order/records.h"

/* ---- the list */

struct order_batch *batch_list_next(const struct batch_list *list, enum batch_sequence sequence,
                                    const struct order_batch *after, enum batch_use use)
{
    struct order_batch *batch = after ? after->following[sequence] : list->first[sequence];
    while (batch && !order_batch_is_kept(batch, use))
        batch = batch->following[sequence];
    return batch;
}

/* Call with the lock of the list. */
static void append_batch(struct batch_list *list, enum batch_sequence sequence,
                         struct order_batch *batch)
{
    struct order_batch *last = list->last[sequence];
    batch->preceding[sequence] = last;
    batch->following[sequence] = NULL;
    *(last ? &last->following[sequence] : &list->first[sequence]) = batch;
    list->last[sequence] = batch;
    batch->sequences |= 1u << sequence;
}

static void remove_from(struct batch_list *list, enum batch_sequence sequence,
                        struct order_batch *batch)
{
    struct order_batch *before = batch->preceding[sequence], *behind = batch->following[sequence];
    if (!(batch->sequences & 1u << sequence))
        return;
    *(before ? &before->following[sequence] : &list->first[sequence]) = behind;
    *(behind ? &behind->preceding[sequence] : &list->last[sequence]) = before;
}

void batch_list_append_submission(struct batch_list *list, struct submission *submission)
{
    pthread_mutex_lock(&list->lock);
    for (uint32_t i = 0; i < submission->batch_count; i++)
        append_batch(list, IN_SUBMISSION_ORDER, &submission->batches[i]);
    pthread_mutex_unlock(&list->lock);
}

static void batch_list_append_run(struct batch_list *list, struct order_batch *batch)
{
    pthread_mutex_lock(&list->lock);
    append_batch(list, IN_EXECUTION_ORDER, batch);
    pthread_mutex_unlock(&list->lock);
}

static void remove_submission(struct batch_list *list, struct submission *submission)
{
    pthread_mutex_lock(&list->lock);
    for (uint32_t i = 0; i < submission->batch_count; i++)
        for (int sequence = 0; sequence < BATCH_SEQUENCES; sequence++)
            remove_from(list, (enum batch_sequence)sequence, &submission->batches[i]);
    pthread_mutex_unlock(&list->lock);
}

/* ---- references */

static void release_captured(const struct submission *submission)
{
    const struct execution_hooks *hooks = &submission->order->hooks;
    for (uint32_t i = 0; hooks->release && i < submission->command_count; i++)
        if (submission->commands[i].captured)
            hooks->release(hooks->user, submission->commands[i].captured);
}

/* Only this thread reaches the submission. */
static void retire_submission(struct submission *submission)
{
    struct execution_order *order = submission->order;
    remove_submission(&order->batches, submission);
    for (uint32_t i = 0; i < submission->batch_count; i++)
        CALL_CONSUMERS(order, retire, &submission->batches[i])
    release_captured(submission);
    shared_labels_release(submission->origin.labels);
    pthread_mutex_lock(&order->lock);
    submission->next = order->spare;
    order->spare = submission;
    pthread_mutex_unlock(&order->lock);
}

void submission_reference(struct submission *submission)
{
    atomic_fetch_add_explicit(&submission->references, 1, memory_order_relaxed);
}

static bool drop_reference(struct submission *submission)
{
    return atomic_fetch_sub_explicit(&submission->references, 1, memory_order_acq_rel) == 1;
}

void submission_unreference(struct submission *submission)
{
    struct execution_order *order = submission->order;
    if (!drop_reference(submission))
        return;
    pthread_mutex_unlock(&order->lock);
    retire_submission(submission);
    pthread_mutex_lock(&order->lock);
}

void order_batch_release(struct order_batch *batch)
{
    if (batch && drop_reference(batch->submission))
        retire_submission(batch->submission);
}

/* Call with the lock of the list. */
static void begin_use(struct order_batch *batch, enum batch_use use, void *slot)
{
    submission_reference(batch->submission);
    batch->slots[use] = slot;
    batch->uses |= 1u << use;
}

void order_batch_keep(struct order_batch *batch, enum batch_use use, void *slot)
{
    struct batch_list *list = &batch->submission->order->batches;
    pthread_mutex_lock(&list->lock);
    begin_use(batch, use, slot);
    pthread_mutex_unlock(&list->lock);
}

bool order_batch_end_use(struct order_batch *batch, enum batch_use use)
{
    struct batch_list *list = &batch->submission->order->batches;
    pthread_mutex_lock(&list->lock);
    bool was_kept = order_batch_is_kept(batch, use);
    batch->uses &= ~(1u << use);
    pthread_mutex_unlock(&list->lock);
    return was_kept;
}

void order_batch_let_go(struct order_batch *batch, enum batch_use use)
{
    if (order_batch_end_use(batch, use))
        order_batch_release(batch);
}

struct order_batch *batch_list_take(struct batch_list *list, enum batch_sequence sequence,
                                    enum batch_use use,
                                    bool (*ends)(const void *user, const struct order_batch *batch),
                                    const void *user)
{
    pthread_mutex_lock(&list->lock);
    struct order_batch *batch = batch_list_next(list, sequence, NULL, use);
    while (batch && ends && !ends(user, batch))
        batch = batch_list_next(list, sequence, batch, use);
    if (batch)
        batch->uses &= ~(1u << use);
    pthread_mutex_unlock(&list->lock);
    return batch;
}

/* ---- walks */

bool batch_cursor_next(struct batch_cursor *at)
{
    uint32_t i = at->batch ? at->command + 1 : 0;
    struct order_batch *batch =
        at->batch ? at->batch : batch_list_next(at->list, at->sequence, NULL, at->use);
    for (; batch; batch = batch_list_next(at->list, at->sequence, batch, at->use), i = 0)
        for (; i < batch->command_count; i++)
            if (batch->commands[i].is_used[at->use]) {
                at->batch = batch;
                at->command = i;
                return true;
            }
    return false;
}

bool batch_cursor_step(struct batch_cursor *at)
{
    struct order_batch *before = at->batch;
    pthread_mutex_lock(&at->list->lock);
    bool is_found = batch_cursor_next(at);
    if (is_found && at->batch != before)
        submission_reference(at->batch->submission);
    pthread_mutex_unlock(&at->list->lock);
    if (!is_found || at->batch != before)
        order_batch_release(before);
    return is_found;
}

bool submission_set_execution(struct submission *submission, uint32_t index,
                              struct execution *execution)
{
    struct batch_list *list = &submission->order->batches;
    struct order_batch *batch = submission->batches;
    if (index >= submission->command_count)
        return false;
    while (index >= batch->first_commands + batch->command_count)
        batch++;
    pthread_mutex_lock(&list->lock);
    if (!order_batch_is_kept(batch, USES_EXECUTIONS))
        begin_use(batch, USES_EXECUTIONS, NULL);
    atomic_store(&submission->commands[index].execution, execution);
    pthread_mutex_unlock(&list->lock);
    return true;
}

/* ---- the run list. It calls the consumers, on one thread at a time and without the lock */

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
    if (!unknown_is_set(&order->unknown))
        order->unknown_reason = why;
    unknown_follow(&order->unknown, true);
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

static void run_batch(struct execution_order *order, struct order_batch *batch)
{
    if (!unknown_is_set(&order->unknown)) {
        order->running = batch;
        pthread_mutex_unlock(&order->lock);
        atomic_store_explicit(&batch->state, BATCH_ORDERED, memory_order_release);
        batch_list_append_run(&order->batches, batch);
        CALL_CONSUMERS(order, run, batch)
        CALL_CONSUMERS(order, ran, batch)
        pthread_mutex_lock(&order->lock);
        order->running = NULL;
        pthread_cond_broadcast(&order->ran);
    }
    submission_unreference(batch->submission);
}

/* Returns false if nothing is ready. */
static bool run_first(struct execution_order *order)
{
    if (unknown_is_set(&order->unknown) && !order->unknown_reported) {
        report_unknown(order);
        return true;
    }
    struct order_batch *batch = take_first(order);
    if (batch)
        run_batch(order, batch);
    return batch;
}

static bool begin_running(struct execution_order *order)
{
    if (!drain_begin(&order->drain))
        return false;
    order->runner = pthread_self();
    return true;
}

void execution_order_drain(struct execution_order *order)
{
    if (!begin_running(order))
        return;
    do {
        while (run_first(order))
            continue;
    } while (drain_repeat(&order->drain));
}

/* ---- waiting for the thread that runs batches */

enum { AWAIT_STEP_NANOSECONDS = 250 * 1000 * 1000, AWAIT_STEPS = 20 };

static bool is_observed(const struct execution_order *order, const struct order_batch *batch)
{
    return execution_clock_has(&order->host, batch->timestamp);
}

static bool lacks_observed(const struct execution_order *order)
{
    const struct order_batch *batch = order->run_list;
    if (unknown_is_set(&order->unknown) ||
        (order->drain.is_busy && pthread_equal(order->runner, pthread_self())))
        return false;
    while (batch && !is_observed(order, batch))
        batch = batch->next;
    return batch || (order->running && is_observed(order, order->running));
}

void execution_order_await_observed(struct execution_order *order)
{
    if (!order)
        return;
    pthread_mutex_lock(&order->lock);
    for (int steps = AWAIT_STEPS; steps && lacks_observed(order);)
        steps -= !timed_condition_wait(&order->ran, &order->lock, AWAIT_STEP_NANOSECONDS);
    pthread_mutex_unlock(&order->lock);
}

/* ---- around the call */

void submission_submit(struct submission *submission)
{
    struct execution_order *order = submission->order;
    if (unknown_is_set(&order->unknown) || submission->kind != SUBMIT_COMMANDS)
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
    if (unknown_is_set(&order->unknown) || !is_runnable || submission->kind == SUBMIT_BINDINGS ||
        !begin_running(order))
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
    begin_running(order);
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
    if (submission->batches[0].is_checked && !unknown_is_set(&order->unknown))
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
