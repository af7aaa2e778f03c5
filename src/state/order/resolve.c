/* SPDX-License-Identifier: Apache-2.0 */
/* Gives batches their timestamps and clocks from the semaphores that they wait for, and decides
 * which batches are held (Vulkan specification, Semaphore Signaling, Semaphore Waiting).
 *
 * A batch of commands follows all earlier batches of commands of its queue. The clock of a wait
 * counts for later signals in any case, but for the batch's work on acceleration structures only if
 * the wait's stages include that work. The stages of a signal limit the clock that it carries in
 * the same way. Semaphores alone order sparse bindings: the signal of a binding carries the binding
 * itself, its waits, and the clocks of earlier signals of the queue. */
#include "src/state/order/records.h"

static struct semaphore_clock *find_semaphore(const struct execution_order *order,
                                              const struct semaphore_operation *operation)
{
    struct semaphore_clock *semaphore =
        operation->id ? execution_order_semaphore(order, operation->handle) : NULL;
    return semaphore && semaphore->id == operation->id ? semaphore : NULL;
}

/* ---- before and after the call */

/* Drops signals that no later wait needs. A batch that is held, or will be, must not follow
 * completions that the host has observed since its call began. So signals are only dropped if there
 * is no such batch. What a foreign semaphore has reached proves nothing. */
static void prune_operations(const struct execution_order *order, struct semaphore_clock *semaphore)
{
    if (!order->held_count && !order->waiting && !semaphore->foreign)
        semaphore_clock_prune(semaphore, &order->host);
}

/* Gives an operation of a binary semaphore its value. */
static void set_value(struct semaphore_clock *semaphore, struct semaphore_operation *operation)
{
    const uint64_t last = semaphore_clock_last(semaphore);
    if (operation->is_signal) {
        operation->value = operation->signal;
        return;
    }
    operation->value = !semaphore->foreign && last > semaphore->last_wait ? last : 0;
    operation->last_wait = semaphore->last_wait;
    semaphore->last_wait = last;
}

void submission_announce(struct submission *submission)
{
    struct execution_order *order = submission->order;
    for (uint32_t i = 0; i < submission->operation_count; i++) {
        struct semaphore_operation *operation = &submission->operations[i];
        struct semaphore_clock *semaphore = execution_order_semaphore(order, operation->handle);
        operation->id = semaphore ? semaphore->id : 0;
        if (!semaphore)
            continue;
        prune_operations(order, semaphore);
        operation->signal = operation->is_signal ? ++order->last_signal : 0;
        if (!semaphore->timeline)
            set_value(semaphore, operation);
        if (!operation->is_signal)
            continue;
        submission->signals_foreign_object |= semaphore->foreign;
        if (!semaphore_clock_announce(semaphore, operation->value, operation->signal, submission))
            submission->out_of_memory = true;
    }
}

void submission_retract(struct submission *submission)
{
    for (uint32_t i = submission->operation_count; i-- > 0;) {
        const struct semaphore_operation *operation = &submission->operations[i];
        struct semaphore_clock *semaphore = find_semaphore(submission->order, operation);
        if (!semaphore)
            continue;
        if (operation->is_signal)
            semaphore_clock_retract(semaphore, operation->value, submission);
        else if (!semaphore->timeline)
            semaphore->last_wait = operation->last_wait;
    }
}

static void publish_operation(struct submission *submission,
                              const struct semaphore_operation *operation)
{
    struct execution_order *order = submission->order;
    struct semaphore_clock *semaphore =
        operation->is_signal ? find_semaphore(order, operation) : NULL;
    if (!semaphore)
        return;
    semaphore_clock_publish(semaphore, operation->value, submission);
    semaphore_clock_catch_up(semaphore, &order->host, &order->maybe);
    if (operation->value <= semaphore->seen)
        execution_order_add_host_wait(order, operation->handle, operation->value);
}

static void publish_batch(const struct order_batch *batch)
{
    struct submission *submission = batch->submission;
    for (uint32_t i = 0; i < batch->operation_count; i++)
        publish_operation(submission, &submission->operations[batch->first_operation + i]);
}

bool order_batch_is_last(const struct order_batch *batch)
{
    return batch == &batch->submission->batches[batch->submission->batch_count - 1];
}

/* Call if the last batch is resolved; `clocks` are those of the queue after it. */
static void give_fence_clock(const struct order_batch *last, const struct queue_clocks *clocks)
{
    struct submission *submission = last->submission;
    struct order_fence *fence = execution_order_fence(submission->order, submission->fence);
    if (!fence || fence->serial != submission->serial)
        return;
    fence->has_clock = true;
    execution_clock_copy(&fence->clock,
                         submission->kind == SUBMIT_BINDINGS ? &clocks->signalled : &clocks->all);
    execution_clock_copy(&fence->behind, &clocks->behind);
    if (fence->seen)
        execution_order_join_fence(submission->order, fence);
}

static void hold_back(struct order_batch *batch)
{
    struct submission *submission = batch->submission;
    struct order_queue *queue = submission->queue_record;
    submission_reference(submission);
    atomic_store_explicit(&batch->state, BATCH_HELD, memory_order_release);
    batch->next = NULL;
    *queue->held_end = batch;
    queue->held_end = &batch->next;
    submission->order->held_count++;
    if (submission->kind == SUBMIT_BINDINGS)
        queue->held_bindings++;
}

void submission_publish(struct submission *submission)
{
    struct order_queue *queue = submission->queue_record;
    struct order_fence *fence = execution_order_fence(submission->order, submission->fence);
    if (fence) {
        fence->serial = submission->serial;
        fence->seen = fence->has_clock = false;
    }
    if (queue && submission->ready_count)
        queue->clocks = submission->clocks;
    for (uint32_t i = submission->ready_count; i < submission->batch_count; i++)
        hold_back(&submission->batches[i]);
    for (uint32_t i = 0; i < submission->ready_count; i++)
        publish_batch(&submission->batches[i]);
    if (submission->ready_count == submission->batch_count)
        give_fence_clock(&submission->batches[submission->batch_count - 1], &submission->clocks);
}

/* ---- waits */

/* Finds the signal with which a wait ends. */
static enum semaphore_wait_status resolve_wait(const struct order_batch *batch,
                                               struct semaphore_operation *wait,
                                               const struct semaphore_signal **signal)
{
    struct submission *submission = batch->submission;
    struct semaphore_clock *semaphore = find_semaphore(submission->order, wait);
    *signal = NULL;
    if (!semaphore)
        return wait->id ? SEMAPHORE_OPEN : SEMAPHORE_REACHED; /* destroyed : never tracked */
    enum semaphore_wait_status status =
        semaphore_clock_wait(semaphore, wait->value, submission, signal);
    wait->is_met = status == SEMAPHORE_MET;
    wait->signal = *signal ? (*signal)->number : 0;
    return status;
}

static bool is_held_back(const struct order_batch *batch)
{
    struct semaphore_operation *operations = order_batch_operations(batch);
    const struct semaphore_signal *signal;
    for (uint32_t i = 0; i < batch->operation_count; i++)
        if (!operations[i].is_signal &&
            resolve_wait(batch, &operations[i], &signal) == SEMAPHORE_NOT_YET)
            return true;
    return false;
}

bool order_batch_follow_waits(const struct order_batch *batch, struct execution_clock *builds,
                              struct execution_clock *all, struct execution_clock *behind)
{
    struct semaphore_operation *operations = order_batch_operations(batch);
    bool open = false;
    for (uint32_t i = 0; i < batch->operation_count; i++) {
        const struct semaphore_signal *signal;
        if (operations[i].is_signal)
            continue;
        enum semaphore_wait_status status = resolve_wait(batch, &operations[i], &signal);
        open |= status == SEMAPHORE_OPEN;
        if (!signal || status != SEMAPHORE_REACHED)
            continue;
        execution_clock_join(all, &signal->clock);
        execution_clock_join(behind, &signal->behind);
        if (operations[i].scope != SCOPE_NOTHING)
            execution_clock_join(builds, &signal->clock);
    }
    return open;
}

/* ---- open batches */

static void add_open(struct submission *submission, struct queue_clocks *clocks)
{
    uint32_t index = submission->queue_record->index;
    struct timestamp last = {index, clocks->last_open};
    if (!clocks->first_open || execution_clock_has(&submission->host, last))
        clocks->first_open = clocks->count;
    clocks->last_open = clocks->count;
    submission->order->has_open = true;
}

/* Whether the batch follows an open batch whose completion the host had not observed. */
static bool follows_open(const struct order_batch *batch, const struct queue_clocks *own)
{
    const struct submission *submission = batch->submission;
    const struct execution_order *order = submission->order;
    for (uint32_t i = EXECUTION_HOST + 1; i < order->queue_count; i++) {
        const struct queue_clocks *clocks =
            i == submission->queue_record->index ? own : &order->queues[i].clocks;
        if (clocks->first_open &&
            execution_clock_has(&own->all, (struct timestamp){i, clocks->first_open}) &&
            !execution_clock_has(&submission->host, (struct timestamp){i, clocks->last_open}))
            return true;
    }
    return false;
}

/* ---- resolving */

/* Bindings without a timestamp execute at an unknown time. A signal of the host has none yet, but
 * the host observes it. */
void order_batch_set_signal(struct order_batch *batch, struct semaphore_operation *operation,
                            const struct execution_clock *carried,
                            const struct execution_clock *behind)
{
    const struct submission *submission = batch->submission;
    struct semaphore_clock *semaphore = find_semaphore(submission->order, operation);
    struct timestamp when = batch->timestamp;
    if (submission->queue_record && !when.count)
        when = timestamp_never();
    if (semaphore)
        operation->previous =
            semaphore_clock_set(semaphore, operation->value, submission, carried, behind, when);
}

/* The signals of one batch are not ordered among themselves: `signalled` precedes all of them. */
static void signal_after_commands(struct order_batch *batch, struct queue_clocks *clocks)
{
    const struct submission *submission = batch->submission;
    struct semaphore_operation *operations = order_batch_operations(batch);
    struct execution_clock builds;
    bool signals_builds = false, signals_all = submission->fence && order_batch_is_last(batch);
    execution_clock_copy(&builds, &clocks->builds);
    execution_clock_join(&builds, &clocks->signalled);
    for (uint32_t i = 0; i < batch->operation_count; i++) {
        if (!operations[i].is_signal)
            continue;
        const struct execution_clock *const carried[] = {
            [SCOPE_NOTHING] = &clocks->signalled,
            [SCOPE_BUILDS] = &builds,
            [SCOPE_ALL] = &clocks->all,
        };
        order_batch_set_signal(batch, &operations[i], carried[operations[i].scope],
                               &clocks->behind);
        signals_builds |= operations[i].scope == SCOPE_BUILDS;
        signals_all |= operations[i].scope == SCOPE_ALL;
    }
    if (signals_all || signals_builds)
        execution_clock_join(&clocks->signalled, signals_all ? &clocks->all : &builds);
}

static void resolve_commands(struct order_batch *batch, struct queue_clocks *clocks)
{
    struct submission *submission = batch->submission;
    execution_clock_join(&clocks->builds, &submission->host);
    execution_clock_join(&clocks->all, &submission->host);
    execution_clock_join(&clocks->behind, &submission->host);
    bool open = order_batch_follow_waits(batch, &clocks->builds, &clocks->all, &clocks->behind) ||
                batch->is_open;

    batch->timestamp = (struct timestamp){submission->queue_record->index, ++clocks->count};
    execution_clock_copy(&batch->clock, &clocks->builds);
    execution_clock_add(&clocks->builds, batch->timestamp);
    execution_clock_add(&clocks->all, batch->timestamp);
    execution_clock_add(&clocks->behind, batch->timestamp);
    execution_clock_copy(&batch->behind, &clocks->behind);
    if (open)
        add_open(submission, clocks);
    batch->predecessors_known = !submission->may_follow_held &&
                                !(submission->order->has_open && follows_open(batch, clocks));

    signal_after_commands(batch, clocks);
}

static void resolve_host(struct order_batch *batch)
{
    struct submission *submission = batch->submission;
    batch->timestamp = (struct timestamp){EXECUTION_HOST, 0}; /* of host work: set later */
    batch->predecessors_known = !submission->may_follow_held;
    execution_clock_copy(&batch->clock, &submission->host);
    for (uint32_t i = 0; i < batch->operation_count; i++)
        order_batch_set_signal(batch, &submission->operations[batch->first_operation + i],
                               &batch->clock, &batch->clock);
}

/* The application may learn without the layer that an exposed batch is complete. */
static void resolve(struct order_batch *batch, struct queue_clocks *clocks)
{
    if (!batch->submission->queue_record)
        resolve_host(batch);
    else if (batch->submission->kind == SUBMIT_BINDINGS)
        order_batch_resolve_bindings(batch, clocks);
    else
        resolve_commands(batch, clocks);
    if (batch->submission->queue_record && batch->submission->signals_foreign_object)
        execution_clock_join(&batch->submission->order->maybe, &clocks->behind);
}

void submission_resolve_ready(struct submission *submission)
{
    struct order_queue *queue = submission->queue_record;
    if (queue && queue->held)
        return;
    if (queue)
        submission->clocks = queue->clocks;
    while (submission->ready_count < submission->batch_count) {
        struct order_batch *batch = &submission->batches[submission->ready_count];
        if (is_held_back(batch))
            break;
        resolve(batch, &submission->clocks);
        submission->ready_count++;
    }
}

/* ---- releasing */

static bool signals(const struct order_batch *batch)
{
    const struct submission *submission = batch->submission;
    bool found = submission->fence;
    for (uint32_t i = 0; i < batch->operation_count && !found; i++)
        found = submission->operations[batch->first_operation + i].is_signal;
    return found;
}

/* Finds the first held batch whose waits are all met and which no earlier held batch blocks.
 * Commands wait for all earlier commands of their queue. Commands and bindings don't wait for each
 * other, and bindings don't wait for bindings; only signals come in submission order. */
static struct order_batch **find_releasable(struct order_queue *queue)
{
    bool behind_commands = false, behind_signals = false;
    for (struct order_batch **link = &queue->held; *link; link = &(*link)->next) {
        bool is_commands = (*link)->submission->kind == SUBMIT_COMMANDS;
        bool has_signals = signals(*link);
        bool is_behind = (is_commands && behind_commands) || (has_signals && behind_signals);
        if (!is_behind && !is_held_back(*link))
            return link;
        behind_commands |= is_commands;
        behind_signals |= has_signals;
        if (behind_commands && !queue->held_bindings)
            break;
    }
    return NULL;
}

static void release_from_queue(struct order_queue *queue, struct order_batch **link)
{
    struct order_batch *batch = *link;
    struct submission *submission = batch->submission;
    struct execution_order *order = submission->order;
    *link = batch->next;
    if (!*link)
        queue->held_end = link;
    order->held_count--;
    if (submission->kind == SUBMIT_BINDINGS)
        queue->held_bindings--;

    resolve(batch, &queue->clocks);
    atomic_store_explicit(&batch->state, BATCH_SUBMITTED, memory_order_release);
    if (submission->kind == SUBMIT_COMMANDS || batch->command_count)
        execution_order_append_run(order, batch);
    publish_batch(batch);
    if (order_batch_is_last(batch))
        give_fence_clock(batch, &queue->clocks);
    if (submission->serial <= queue->idle_serial)
        execution_order_join_idle(order, queue);
    submission_unreference(submission);
}

void execution_order_release_held(struct execution_order *order)
{
    bool released = order->held_count > 0;
    while (released && !unknown_is_set(&order->unknown)) {
        released = false;
        for (uint32_t i = EXECUTION_HOST + 1; i < order->queue_count; i++)
            for (struct order_batch **link; (link = find_releasable(&order->queues[i]));) {
                release_from_queue(&order->queues[i], link);
                released = true;
            }
    }
}
