/* SPDX-License-Identifier: Apache-2.0 */
/* Queue of executions whose snapshots wait to be validated: from their execution point until they
 * are complete. */
#include "layer/execution/input_checks.h"

#include <stdlib.h>

#include "layer/execution/hazards/checks.h"
#include "layer/execution/input_check_run.h"
#include "layer/execution/submitted_builds.h"
#include "layer/snapshots/coverage_warnings.h"
#include "src/platform/clock.h"
#include "src/platform/threads.h"

/* The notes of a batch that was replayed and has not run. */
struct noted_batch {
    struct noted_batch *next;
    struct timestamp timestamp;
    uint32_t count;
    struct input_notes commands[];
};

struct waiting {
    struct waiting *next;
    struct ran_execution ran;
    atomic_bool was_waited_for; /* by the layer itself, until the end */
};

struct input_checks {
    struct layer_device *device;
    struct snapshots_consumer consumer;
    struct noted_batch *noted, **noted_last; /* used by the hooks only */

    /* Guards the members below. Only the thread that set `busy` removes executions from the list.
     * No call or message is made with the lock held. */
    pthread_mutex_t lock;
    struct waiting *waiting, **waiting_last; /* in execution order */
    bool busy, again; /* a thread delivers; another thread requested a delivery meanwhile */
};

VkResult input_checks_create(struct layer_device *device)
{
    if (device->level < LEVEL_CONTENT || !device->snapshots)
        return VK_SUCCESS;
    struct input_checks *input_checks = calloc(1, sizeof(*input_checks));
    if (!input_checks)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    input_checks->device = device;
    input_checks->noted_last = &input_checks->noted;
    input_checks->waiting_last = &input_checks->waiting;
    pthread_mutex_init(&input_checks->lock, NULL);
    device->input_checks = input_checks;
    return VK_SUCCESS;
}

/* Marks inputs as known that will never be read, so that updates which are compared with them do
 * not wait. */
static void mark_inputs_known(const struct input_notes *notes)
{
    for (uint32_t i = 0; i < notes->count; i++)
        build_inputs_mark_known(notes->items[i].inputs);
}

static void free_waiting(struct waiting *waiting)
{
    hazard_checks_settle(waiting->ran.device->hazard_checks, waiting->ran.timestamp);
    mark_inputs_known(&waiting->ran.notes);
    input_notes_release(&waiting->ran.notes);
    execution_release(waiting->ran.execution);
    journal_release(waiting->ran.journal);
    shared_labels_release(waiting->ran.queue_labels);
    free(waiting);
}

void input_checks_destroy(struct input_checks *input_checks)
{
    if (!input_checks)
        return;
    input_checks_drop(input_checks);
    while (input_checks->waiting) {
        struct waiting *first = input_checks->waiting;
        input_checks->waiting = first->next;
        free_waiting(first);
    }
    pthread_mutex_destroy(&input_checks->lock);
    free(input_checks);
}

/* ---- batches */

struct input_notes *input_checks_note_batch(struct input_checks *input_checks,
                                            const struct batch_run *run)
{
    if (!input_checks)
        return NULL;
    size_t size = run->command_count * sizeof(struct input_notes);
    struct noted_batch *batch = calloc(1, sizeof(*batch) + size);
    if (!batch)
        return NULL;
    batch->timestamp = run->timestamp;
    batch->count = run->command_count;
    *input_checks->noted_last = batch;
    input_checks->noted_last = &batch->next;
    return batch->commands;
}

static void drop_first(struct input_checks *input_checks)
{
    struct noted_batch *batch = input_checks->noted;
    input_checks->noted = batch->next;
    if (!input_checks->noted)
        input_checks->noted_last = &input_checks->noted;
    for (uint32_t i = 0; i < batch->count; i++) {
        mark_inputs_known(&batch->commands[i]);
        input_notes_release(&batch->commands[i]);
    }
    free(batch);
}

void input_checks_drop(struct input_checks *input_checks)
{
    while (input_checks && input_checks->noted)
        drop_first(input_checks);
}

static bool is_of(const struct noted_batch *batch, const struct batch_run *run)
{
    return batch && timestamps_are_equal(batch->timestamp, run->timestamp);
}

/* The consumer's `run`. If the order is unknown, the states that builds found are unknown too, and
 * nothing is validated. The snapshots count and report such executions. */
static void run(void *user, const struct submitted_execution *submitted)
{
    struct input_checks *input_checks = user;
    const struct batch_run *batch = submitted->batch;
    if (!batch)
        return;
    struct waiting *waiting = calloc(1, sizeof(*waiting));
    if (!waiting) {
        warn_missed(input_checks->device, &(struct missed_executions){.no_memory = 1});
        return;
    }
    waiting->ran = (struct ran_execution){
        .timestamp = submitted->timestamp,
        .device = input_checks->device,
        .execution = execution_share(submitted->execution),
        .journal = journal_share(batch->commands[submitted->command].captured),
        .queue = batch->queue,
        .submission = batch->submission,
        .queue_labels = shared_labels_share(batch->queue_labels),
    };
    if (is_of(input_checks->noted, batch)) {
        waiting->ran.notes = input_checks->noted->commands[submitted->command];
        input_checks->noted->commands[submitted->command] = (struct input_notes){0};
    }
    for (uint32_t i = 0; i < waiting->ran.notes.count; i++)
        if (waiting->ran.notes.items[i].inputs)
            waiting->ran.notes.items[i].inputs->filler = waiting;
    hazard_checks_expect(input_checks->device->hazard_checks, submitted->timestamp);
    pthread_mutex_lock(&input_checks->lock);
    *input_checks->waiting_last = waiting;
    input_checks->waiting_last = &waiting->next;
    pthread_mutex_unlock(&input_checks->lock);
}

void input_checks_end_batch(struct input_checks *input_checks, const struct batch_run *run)
{
    if (input_checks && is_of(input_checks->noted, run))
        drop_first(input_checks);
}

/* ---- delivery */

/* State of one delivery over the waiting executions. */
struct delivery {
    struct execution_clock seen;
    uint64_t busy_queues; /* bit set by queue index: later batches of the queue are not complete
                             either, or too late to wait for */
};
_Static_assert(EXECUTION_QUEUES <= 64, "each queue has a bit");

/* Whether the end of an execution is no news for a layer below: the application has observed it, or
 * the layer has waited for it, or the device is lost. Only then is its fence queried. A layer below
 * takes that for a wait of the application: the Khronos layer would no longer report hazards with
 * what the submission does, or the destruction of what it uses. */
static bool was_observed(const struct waiting *waiting, bool was_seen)
{
    return was_seen || atomic_load(&waiting->was_waited_for) ||
           atomic_load(&waiting->ran.device->snapshots->device_lost);
}

/* Whether the result of the execution's ticket is known to be final. */
static bool is_complete(struct delivery *delivery, struct waiting *waiting)
{
    struct ticket *ticket = waiting->ran.execution->ticket;
    uint64_t queue = UINT64_C(1) << waiting->ran.timestamp.queue;
    bool was_seen = execution_clock_has(&delivery->seen, waiting->ran.timestamp);
    bool is_busy = delivery->busy_queues & queue;
    VkResult end;
    if (!was_observed(waiting, was_seen) || (is_busy && !was_seen))
        return false;
    if (ticket_has_ended(ticket, was_seen && !is_busy, &end)) {
        waiting->ran.is_complete = end == VK_SUCCESS;
        return true;
    }
    delivery->busy_queues |= queue;
    return false;
}

/* Whether the inputs are known with which the execution's updates are compared, or will be once the
 * execution itself is read. */
static bool has_sources(const struct waiting *waiting)
{
    for (uint32_t i = 0; i < waiting->ran.notes.count; i++) {
        const struct build_inputs *source = waiting->ran.notes.items[i].source.inputs;
        if (source && source->filler != waiting && !atomic_load(&source->is_known))
            return false;
    }
    return true;
}

static struct waiting **next_link(struct input_checks *input_checks, struct waiting **link)
{
    pthread_mutex_lock(&input_checks->lock);
    link = *link ? &(*link)->next : link;
    pthread_mutex_unlock(&input_checks->lock);
    return link;
}

static struct waiting *waiting_at(struct input_checks *input_checks, struct waiting *const *link)
{
    pthread_mutex_lock(&input_checks->lock);
    struct waiting *waiting = *link;
    pthread_mutex_unlock(&input_checks->lock);
    return waiting;
}

static void remove_waiting(struct input_checks *input_checks, struct waiting **link)
{
    pthread_mutex_lock(&input_checks->lock);
    struct waiting *waiting = *link;
    *link = waiting->next;
    if (!waiting->next)
        input_checks->waiting_last = link;
    pthread_mutex_unlock(&input_checks->lock);
}

/* Validates complete executions in execution order. Skips incomplete ones, because executions of
 * other queues may be complete. */
static void deliver(struct input_checks *input_checks)
{
    struct delivery delivery = {0};
    struct missed_executions missed = {0};
    struct waiting **link = &input_checks->waiting;
    execution_order_host_clock(input_checks->device->order, &delivery.seen);
    for (struct waiting *waiting; (waiting = waiting_at(input_checks, link));) {
        if (!is_complete(&delivery, waiting) || !has_sources(waiting)) {
            link = next_link(input_checks, link);
            continue;
        }
        remove_waiting(input_checks, link);
        if (waiting->ran.is_complete)
            submitted_builds_end(waiting->ran.device->submitted_builds, waiting->ran.timestamp);
        input_checks_read(&waiting->ran, NULL, &missed);
        free_waiting(waiting);
    }
    warn_missed(input_checks->device, &missed);
}

/* Whether this thread is to deliver. Returns false if another thread delivers or nothing waits. */
static bool begin_delivery(struct input_checks *input_checks)
{
    pthread_mutex_lock(&input_checks->lock);
    bool is_free = !input_checks->busy && input_checks->waiting;
    input_checks->again |= input_checks->busy;
    input_checks->busy |= is_free;
    pthread_mutex_unlock(&input_checks->lock);
    return is_free;
}

/* Whether another thread requested a delivery meanwhile. */
static bool repeat_delivery(struct input_checks *input_checks)
{
    pthread_mutex_lock(&input_checks->lock);
    bool again = input_checks->again;
    input_checks->again = false;
    input_checks->busy = again;
    pthread_mutex_unlock(&input_checks->lock);
    return again;
}

void input_checks_deliver(struct input_checks *input_checks)
{
    if (!input_checks || !begin_delivery(input_checks))
        return;
    do {
        deliver(input_checks);
    } while (repeat_delivery(input_checks));
}

static bool is_delivering(struct input_checks *input_checks)
{
    pthread_mutex_lock(&input_checks->lock);
    bool is_busy = input_checks->busy;
    pthread_mutex_unlock(&input_checks->lock);
    return is_busy;
}

bool input_checks_read_marked(struct input_checks *input_checks, const char *when)
{
    struct missed_executions missed = {0};
    if (!begin_delivery(input_checks))
        return !is_delivering(input_checks);
    struct waiting *const *link = &input_checks->waiting;
    for (struct waiting *waiting; (waiting = waiting_at(input_checks, link));
         link = next_link(input_checks, (struct waiting **)(uintptr_t)link))
        if (has_sources(waiting))
            input_checks_read(&waiting->ran, when, &missed);
    while (repeat_delivery(input_checks))
        deliver(input_checks);
    return true;
}

struct ticket *input_checks_next_ticket(struct input_checks *input_checks, VkQueue queue,
                                        uint64_t after)
{
    struct ticket *next = NULL;
    pthread_mutex_lock(&input_checks->lock);
    for (const struct waiting *at = input_checks->waiting; at; at = at->next) {
        struct ticket *ticket = at->ran.execution->ticket;
        if (ticket->number > after && (!queue || at->ran.queue == queue) &&
            (!next || ticket->number < next->number))
            next = ticket;
    }
    if (next)
        ticket_share(next);
    pthread_mutex_unlock(&input_checks->lock);
    return next;
}

/* An execution in the list depends on no later submission. But another batch of its submission may,
 * or an event that the host sets. So the wait is limited. */
enum { WAIT_NANOSECONDS = 1000 * 1000 * 1000, PAUSE_NANOSECONDS = 1000 * 1000 };

/* The layer has waited for the end of the executions with this ticket. Returns whether the first
 * execution of the list is one of them. */
static bool note_wait(struct input_checks *input_checks, const struct ticket *ticket)
{
    pthread_mutex_lock(&input_checks->lock);
    struct waiting *first = input_checks->waiting;
    bool is_first = first && first->ran.execution->ticket == ticket;
    for (struct waiting *at = first; at; at = at->next)
        if (at->ran.execution->ticket == ticket)
            atomic_store(&at->was_waited_for, true);
    pthread_mutex_unlock(&input_checks->lock);
    return is_first;
}

/* The consumer's `wait`. Pauses if another thread delivers the first execution. */
static bool wait_for_first(void *user)
{
    struct input_checks *input_checks = user;
    pthread_mutex_lock(&input_checks->lock);
    struct ticket *ticket =
        input_checks->waiting ? ticket_share(input_checks->waiting->ran.execution->ticket) : NULL;
    pthread_mutex_unlock(&input_checks->lock);
    bool is_complete = ticket && ticket_result_is_final(ticket->wait(ticket, WAIT_NANOSECONDS));
    if (is_complete && note_wait(input_checks, ticket)) {
        input_checks_deliver(input_checks);
        if (note_wait(input_checks, ticket))
            clock_sleep(PAUSE_NANOSECONDS);
    }
    ticket_release(ticket);
    return is_complete;
}

/* ---- the consumer */

static void deliver_complete(void *user)
{
    input_checks_deliver(user);
}

struct snapshots_consumer *input_checks_consumer(struct input_checks *input_checks)
{
    input_checks->consumer = (struct snapshots_consumer){
        .user = input_checks, .run = run, .deliver = deliver_complete, .wait = wait_for_first};
    return &input_checks->consumer;
}
