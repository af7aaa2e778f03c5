/* SPDX-License-Identifier: Apache-2.0 */
/* Validates executions in execution order, once they are complete. */
#include "layer/execution/input_checks.h"

#include <stdlib.h>

#include "layer/consumers.h"
#include "layer/execution/submitted_builds.h"
#include "layer/hazards/executed/checks.h"
#include "layer/snapshots/executions.h"
#include "src/base/drain.h"
#include "src/platform/clock.h"

/* One command buffer of a batch. */
struct input_check {
    struct input_notes notes;
    struct execution *execution; /* it waits to be validated while the command buffer is used */
    atomic_bool was_waited_for;  /* by the layer itself, until the end */
};

/* The slot of a batch, from its replay on. Before the batch is kept, it belongs to the thread that
 * runs batches, then to the thread that delivers. Other threads read it with the lock of the list,
 * for command buffers that are used. */
struct batch_inputs {
    uint32_t waiting; /* checks that have not ended */
    struct input_check commands[];
};

struct input_checks {
    struct layer_device *device;
    struct batch_list *batches;
    struct drain drain; /* guarded by the lock of the list */
};

VkResult input_checks_create(struct layer_device *device)
{
    if (device->level < LEVEL_CONTENT || !device->snapshots)
        return VK_SUCCESS;
    device->input_checks = calloc(1, sizeof(*device->input_checks));
    if (!device->input_checks)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    device->input_checks->device = device;
    return VK_SUCCESS;
}

/* ---- slots */

static struct batch_inputs *inputs_of(const struct order_batch *batch)
{
    return batch->slots[USES_INPUTS];
}

static struct input_check *check_of(const struct batch_cursor *at)
{
    return &inputs_of(at->batch)->commands[at->command];
}

/* A walk over the executions that wait. */
static struct batch_cursor start_batches_read(const struct input_checks *input_checks)
{
    return (struct batch_cursor){
        .list = input_checks->batches, .sequence = IN_EXECUTION_ORDER, .use = USES_INPUTS};
}

/* Marks inputs as known that will never be read, so that updates which are compared with them do
 * not wait. */
static void release_notes(struct input_notes *notes)
{
    for (uint32_t i = 0; i < notes->count; i++)
        build_inputs_mark_known(notes->items[i].inputs);
    input_notes_release(notes);
}

static void free_slot(struct order_batch *batch)
{
    struct batch_inputs *inputs = inputs_of(batch);
    for (uint32_t i = 0; inputs && i < batch->command_count; i++)
        release_notes(&inputs->commands[i].notes);
    free(inputs);
    batch->slots[USES_INPUTS] = NULL;
}

/* Returns NULL without memory. */
static struct batch_inputs *make_slot(struct order_batch *batch)
{
    const size_t size = batch->command_count * sizeof(struct input_check);
    if (!inputs_of(batch))
        batch->slots[USES_INPUTS] = calloc(1, sizeof(struct batch_inputs) + size);
    return inputs_of(batch);
}

/* No other thread finds the execution any more. */
static void take_execution(struct input_checks *input_checks, const struct batch_cursor *at)
{
    pthread_mutex_lock(&input_checks->batches->lock);
    at->batch->commands[at->command].is_used[USES_INPUTS] = false;
    pthread_mutex_unlock(&input_checks->batches->lock);
}

/* Ends the check of an execution that was taken. */
static void end_check(struct input_checks *input_checks, const struct batch_cursor *at)
{
    struct batch_inputs *inputs = inputs_of(at->batch);
    hazard_checks_end_inputs(input_checks->device->hazard_checks, at->batch);
    release_notes(&check_of(at)->notes);
    execution_release(check_of(at)->execution);
    if (--inputs->waiting)
        return;
    order_batch_let_go(at->batch, USES_INPUTS);
    free_slot(at->batch);
}

/* ---- batches */

struct input_notes *input_checks_note(struct input_checks *input_checks, struct order_batch *batch,
                                      uint32_t command)
{
    struct batch_inputs *inputs = input_checks ? make_slot(batch) : NULL;
    return inputs ? &inputs->commands[command].notes : NULL;
}

/* For `retire`, too: a batch that never ran may have notes. */
static void drop_notes(void *user, struct order_batch *batch)
{
    (void)user;
    free_slot(batch);
}

static void wait_for_execution(const struct input_checks *input_checks, struct order_batch *batch,
                               uint32_t i, struct execution *execution)
{
    struct input_check *check = &inputs_of(batch)->commands[i];
    check->execution = execution;
    batch->commands[i].is_used[USES_INPUTS] = true;
    inputs_of(batch)->waiting++;
    for (uint32_t n = 0; n < check->notes.count; n++)
        if (check->notes.items[n].inputs)
            check->notes.items[n].inputs->filler = check;
    hazard_checks_begin_inputs(input_checks->device->hazard_checks, batch);
}

/* Takes the executions of the batch. */
static void input_checks_run(void *user, struct order_batch *batch)
{
    struct input_checks *input_checks = user;
    struct missed_executions missed = {0};
    for (uint32_t i = 0; i < batch->command_count; i++) {
        struct batch_inputs *inputs = inputs_of(batch);
        struct execution *execution = atomic_load(&batch->commands[i].execution);
        if (!execution && inputs)
            release_notes(&inputs->commands[i].notes);
        if (!execution)
            continue;
        missed.no_memory += !make_slot(batch);
        if (inputs_of(batch))
            wait_for_execution(input_checks, batch, i, execution_share(execution));
    }
    warn_missed(input_checks->device, &missed);
    if (inputs_of(batch) && inputs_of(batch)->waiting)
        order_batch_keep(batch, USES_INPUTS, inputs_of(batch));
    else
        free_slot(batch);
}

/* ---- delivery */

/* State of one delivery over the waiting executions. */
struct delivery {
    struct input_checks *input_checks;
    struct execution_clock seen;
    uint64_t busy_queues; /* bit set by queue index: later batches of the queue are not complete
                             either, or too late to wait for */
};
_Static_assert(EXECUTION_QUEUES <= 64, "each queue has a bit");

/* Whether the end of an execution is no news for a layer below: the application has observed it, or
 * the layer has waited for it, or the device is lost. Only then is its fence queried. A layer below
 * takes that for a wait of the application: the Khronos layer would no longer report hazards with
 * what the submission does, or the destruction of what it uses. */
static bool was_observed(const struct delivery *delivery, const struct input_check *check,
                         bool was_seen)
{
    return was_seen || atomic_load(&check->was_waited_for) ||
           atomic_load(&delivery->input_checks->device->snapshots->device_lost);
}

/* Whether the result of the execution's ticket is known to be final, which *end then is. */
static bool has_ended(struct delivery *delivery, const struct order_batch *batch,
                      const struct input_check *check, VkResult *end)
{
    uint64_t queue = UINT64_C(1) << batch->timestamp.queue;
    bool was_seen = execution_clock_has(&delivery->seen, batch->timestamp);
    bool is_busy = delivery->busy_queues & queue;
    if (!was_observed(delivery, check, was_seen) || (is_busy && !was_seen))
        return false;
    if (ticket_has_ended(check->execution->ticket, was_seen && !is_busy, end))
        return true;
    delivery->busy_queues |= queue;
    return false;
}

/* Whether the inputs are known with which the execution's updates are compared, or will be once the
 * execution itself is read. */
static bool has_sources(const struct input_check *check)
{
    for (uint32_t i = 0; i < check->notes.count; i++) {
        const struct build_inputs *source = check->notes.items[i].source.inputs;
        if (source && source->filler != check && !atomic_load(&source->is_known))
            return false;
    }
    return true;
}

static struct ran_execution describe_execution(const struct input_checks *input_checks,
                                               const struct batch_cursor *at, bool is_complete)
{
    return (struct ran_execution){
        .device = input_checks->device,
        .batch = at->batch,
        .command = at->command,
        .execution = check_of(at)->execution,
        .notes = check_of(at)->notes,
        .is_complete = is_complete,
    };
}

/* Validates complete executions in execution order. Skips incomplete ones, because executions of
 * other queues may be complete. */
static void deliver_executions(struct input_checks *input_checks)
{
    struct delivery delivery = {.input_checks = input_checks};
    struct missed_executions missed = {0};
    VkResult end;
    execution_order_host_clock(input_checks->device->order, &delivery.seen);
    for (struct batch_cursor at = start_batches_read(input_checks); batch_cursor_step(&at);) {
        if (!has_ended(&delivery, at.batch, check_of(&at), &end) || !has_sources(check_of(&at)))
            continue;
        const struct ran_execution ran = describe_execution(input_checks, &at, end == VK_SUCCESS);
        take_execution(input_checks, &at);
        if (ran.is_complete)
            submitted_builds_end(input_checks->device->submitted_builds, at.batch);
        input_checks_read(&ran, NULL, &missed);
        end_check(input_checks, &at);
    }
    if (consumers_are_postponed(input_checks->device))
        consumers_run(input_checks->device);
    warn_missed(input_checks->device, &missed);
}

/* Whether this thread is to deliver. Returns false if another thread delivers, which *is_busy then
 * says, or if nothing waits. */
static bool begin_delivery(struct input_checks *input_checks, bool *is_busy)
{
    pthread_mutex_lock(&input_checks->batches->lock);
    *is_busy = input_checks->drain.is_busy;
    struct batch_cursor first = start_batches_read(input_checks);
    bool waits = batch_cursor_next(&first) || consumers_are_postponed(input_checks->device);
    bool begins = (*is_busy || waits) && drain_begin(&input_checks->drain);
    pthread_mutex_unlock(&input_checks->batches->lock);
    return begins;
}

static bool repeat_delivery(struct input_checks *input_checks)
{
    pthread_mutex_lock(&input_checks->batches->lock);
    bool again = drain_repeat(&input_checks->drain);
    pthread_mutex_unlock(&input_checks->batches->lock);
    return again;
}

void input_checks_deliver(struct input_checks *input_checks)
{
    bool is_busy;
    if (!input_checks || !begin_delivery(input_checks, &is_busy))
        return;
    do {
        deliver_executions(input_checks);
    } while (repeat_delivery(input_checks));
}

static bool read_waiting(struct input_checks *input_checks, const char *when)
{
    struct missed_executions missed = {0};
    bool is_busy;
    if (!begin_delivery(input_checks, &is_busy))
        return !is_busy;
    for (struct batch_cursor at = start_batches_read(input_checks); batch_cursor_step(&at);) {
        const struct ran_execution ran = describe_execution(input_checks, &at, false);
        if (has_sources(check_of(&at)))
            input_checks_read(&ran, when, &missed);
    }
    while (repeat_delivery(input_checks))
        deliver_executions(input_checks);
    return true;
}

/* An execution whose batch has not run, for example because the call that submits it has not
 * returned. */
static void read_unrun(struct input_checks *input_checks, const struct batch_cursor *at,
                       const char *when, struct missed_executions *missed)
{
    const struct journal *journal = at->batch->commands[at->command].captured;
    const struct ran_execution ran = {
        .device = input_checks->device,
        .batch = at->batch,
        .command = at->command,
        .execution = journal->work ? recording_share_latest(journal->work) : NULL,
    };
    if (ran.execution)
        input_checks_read(&ran, when, missed);
    execution_release(ran.execution);
}

bool input_checks_read_marked(struct input_checks *input_checks, const char *when)
{
    struct missed_executions missed = {0};
    if (!input_checks)
        return true;
    bool is_free = read_waiting(input_checks, when);
    for (struct batch_cursor at = submitted_builds_start(input_checks->device->submitted_builds);
         at.list && batch_cursor_step(&at);)
        if (!order_batch_has_run(at.batch))
            read_unrun(input_checks, &at, when, &missed);
    return is_free;
}

void input_checks_destroy(struct input_checks *input_checks)
{
    if (!input_checks)
        return;
    for (struct batch_cursor at = start_batches_read(input_checks);
         at.list && batch_cursor_step(&at);) {
        take_execution(input_checks, &at);
        end_check(input_checks, &at);
    }
    free(input_checks);
}

/* ---- tickets. Other threads deliver meanwhile. */

struct ticket *input_checks_next_ticket(struct input_checks *input_checks, VkQueue queue,
                                        uint64_t after)
{
    struct ticket *next = NULL;
    pthread_mutex_lock(&input_checks->batches->lock);
    for (struct batch_cursor at = start_batches_read(input_checks); batch_cursor_next(&at);) {
        struct ticket *ticket = check_of(&at)->execution->ticket;
        if (ticket->number > after && (!queue || at.batch->origin.queue == queue) &&
            (!next || ticket->number < next->number))
            next = ticket;
    }
    if (next)
        ticket_share(next);
    pthread_mutex_unlock(&input_checks->batches->lock);
    return next;
}

/* An execution that waits depends on no later submission. But another batch of its submission may,
 * or an event that the host sets. So the wait is limited. */
enum { WAIT_NANOSECONDS = 1000 * 1000 * 1000, PAUSE_NANOSECONDS = 1000 * 1000 };

static struct ticket *share_first(struct input_checks *input_checks)
{
    struct batch_cursor first = start_batches_read(input_checks);
    pthread_mutex_lock(&input_checks->batches->lock);
    bool found = batch_cursor_next(&first);
    struct ticket *ticket = found ? ticket_share(check_of(&first)->execution->ticket) : NULL;
    pthread_mutex_unlock(&input_checks->batches->lock);
    return ticket;
}

/* The layer has waited for the end of the executions with this ticket. Returns whether the first
 * execution that waits is one of them. */
static bool note_wait(struct input_checks *input_checks, const struct ticket *ticket)
{
    bool is_first = false, has_first = false;
    pthread_mutex_lock(&input_checks->batches->lock);
    for (struct batch_cursor at = start_batches_read(input_checks); batch_cursor_next(&at);
         has_first = true) {
        if (check_of(&at)->execution->ticket != ticket)
            continue;
        is_first |= !has_first;
        atomic_store(&check_of(&at)->was_waited_for, true);
    }
    pthread_mutex_unlock(&input_checks->batches->lock);
    return is_first;
}

/* Pauses if another thread delivers the first execution. */
static bool wait_for_first(void *user)
{
    struct input_checks *input_checks = user;
    struct ticket *ticket = share_first(input_checks);
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

/* If the order is unknown, the states that builds found are unknown too, and nothing is validated.
 * The snapshots count and report such executions. */
struct batch_consumer input_checks_consumer(struct input_checks *input_checks)
{
    input_checks->batches = execution_order_batches(input_checks->device->order);
    return (struct batch_consumer){.user = input_checks,
                                   .undo = drop_notes,
                                   .run = input_checks_run,
                                   .retire = drop_notes,
                                   .deliver = deliver_complete,
                                   .wait = wait_for_first};
}
