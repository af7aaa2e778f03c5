/* SPDX-License-Identifier: Apache-2.0 */
/* Executions of batches: that each consumer finds them in its batch, in the order of execution,
 * that they are released behind the last consumer, and that the snapshots need nothing else of
 * whoever consumes them: this test links them without the rest of the layer. */
#include "layer/snapshots/snapshots.h"

#include <string.h>

#include "layer/snapshots/executions.h"
#include "tests/unit/unit_test.h"

enum { CALLS_MAX = 16 };

/* A consumer that logs its calls. */
struct observer {
    bool waits; /* what `wait` returns */
};

static struct call {
    const struct observer *observer;
    char kind; /* 'r'un, 'u'nordered, 'd'eliver or 'w'ait */
    const struct execution *execution;
    uint32_t command;
    struct timestamp timestamp;
    bool is_reached, has_no_snapshots;
} calls[CALLS_MAX];
static uint32_t call_count, unordered_reports;

static struct snapshots snapshots;
static struct layer_device device;
static struct observer first, second;
static struct ticket ticket;
static VkResult ticket_end;
static struct recording *recordings[2];
static struct journal *journals[2];

/* ---- what executions.c calls besides */

void warn_unordered(const struct layer_device *of_device)
{
    unordered_reports++;
}

/* ---- the fixture */

static void note(struct call call)
{
    assert_true(call_count < CALLS_MAX);
    calls[call_count++] = call;
}

static void run(void *user, struct order_batch *batch)
{
    for (uint32_t i = 0; i < batch->command_count; i++) {
        struct execution *execution = atomic_load(&batch->commands[i].execution);
        if (execution)
            note((struct call){user, 'r', execution, i, batch->timestamp,
                               atomic_load(&execution->is_reached), execution->has_no_snapshots});
    }
}

static void run_unordered(void *user, struct execution *execution)
{
    note((struct call){.observer = user, .kind = 'u', .execution = execution});
}

static void deliver(void *user)
{
    note((struct call){.observer = user, .kind = 'd'});
}

static bool wait_for_one(void *user)
{
    note((struct call){.observer = user, .kind = 'w'});
    return ((const struct observer *)user)->waits;
}

static VkResult wait_for_ticket(struct ticket *of_ticket, uint64_t nanoseconds)
{
    return ticket_end;
}

static VkResult other_end;

static VkResult wait_for_other(struct ticket *of_ticket, uint64_t nanoseconds)
{
    return other_end;
}

static void add(struct observer *observer)
{
    *observer = (struct observer){false};
    execution_order_add_consumer(device.order,
                                 (struct batch_consumer){.user = observer,
                                                         .run = run,
                                                         .run_unordered = run_unordered,
                                                         .deliver = deliver,
                                                         .wait = wait_for_one});
}

static void set_up_order(void)
{
    const struct execution_hooks hooks = {0};
    assert_int_equal(execution_order_create(&device.order, &hooks), VK_SUCCESS);
    execution_order_add_consumer(device.order, snapshots_consumer(&snapshots));
}

static void set_up(void)
{
    static const struct recording_memory memory;
    snapshots = (struct snapshots){.device = &device};
    device.snapshots = &snapshots;
    ticket.references = 1; /* the test's */
    ticket.wait = wait_for_ticket;
    atomic_store(&ticket.is_complete, true);
    ticket_end = VK_SUCCESS;
    call_count = unordered_reports = 0;
    for (int i = 0; i < 2; i++) {
        journals[i] = journal_create(VK_NULL_HANDLE);
        recordings[i] = recording_create(journals[i], &memory);
        assert_non_null(recordings[i]);
        recordings[i]->has_commands = true;
    }
    set_up_order();
    add(&first);
    add(&second);
}

static void tear_down(void)
{
    execution_order_end(device.order);
    snapshots_release_held(&snapshots);
    execution_order_destroy(device.order);
    assert_int_equal(atomic_load(&ticket.references), 1);
    for (int i = 0; i < 2; i++)
        journal_release(journals[i]);
}

static void execute(struct journal *primary, struct journal *secondary)
{
    const struct journal_entry entry = {.kind = JOURNAL_EXECUTE,
                                        .secondary = journal_share(secondary)};
    journal_add(primary, &entry);
    primary->secondary_count++;
}

/* A call whose batch has three command buffers: of the first recording, of none, and of the second
 * one. The batch of a call that waits for the semaphore is held. */
enum { SEMAPHORE = 1, COMMANDS = 3 };
struct call_to_submit {
    struct submission *submission;
    struct execution *executions[2]; /* NULL: none */
};

static struct call_to_submit prepare(bool has_first, bool has_second, uint64_t wait)
{
    struct call_to_submit call = {
        submission_begin(device.order, SUBMIT_COMMANDS, (VkQueue)(uintptr_t)1), {NULL}};
    submission_add_batch(call.submission);
    if (wait)
        submission_add_wait(call.submission, (VkSemaphore)(uintptr_t)SEMAPHORE, wait, SCOPE_ALL);
    for (int i = 0; i < COMMANDS; i++)
        submission_add_commands(call.submission, VK_NULL_HANDLE);
    assert_false(submission_prepare(call.submission));
    assert_ptr_equal(execution_order_under_way(device.order, (VkQueue)(uintptr_t)1),
                     call.submission);
    for (uint32_t i = 0; i < 2; i++)
        if (i ? has_second : has_first) {
            call.executions[i] = execution_create(recordings[i], &ticket);
            assert_non_null(call.executions[i]);
            assert_true(submission_set_execution(call.submission, i * 2, call.executions[i]));
        }
    assert_false(submission_set_execution(call.submission, COMMANDS, NULL));
    return call;
}

static void assert_run(uint32_t call, const struct observer *observer,
                       const struct execution *execution, uint32_t command)
{
    assert_true(call < call_count);
    assert_int_equal(calls[call].kind, 'r');
    assert_ptr_equal(calls[call].observer, observer);
    assert_ptr_equal(calls[call].execution, execution);
    assert_int_equal(calls[call].command, command);
}

static void assert_calls(const char *kinds)
{
    assert_int_equal(call_count, strlen(kinds));
    for (uint32_t i = 0; i < call_count; i++)
        assert_int_equal(calls[i].kind, kinds[i]);
}

TEST_BETWEEN(test_batch_runs_each_consumer_in_order, set_up, tear_down)
{
    const struct call_to_submit call = prepare(true, true, 0);
    assert_int_equal(call_count, 0);
    submission_finish(call.submission, VK_SUCCESS);
    assert_int_equal(call_count, 4);
    assert_run(0, &first, call.executions[0], 0);
    assert_run(1, &first, call.executions[1], 2);
    assert_run(2, &second, call.executions[0], 0);
    assert_run(3, &second, call.executions[1], 2);
    assert_true(calls[0].is_reached && calls[1].is_reached);
    assert_false(calls[0].has_no_snapshots || calls[1].has_no_snapshots);
    assert_null(recording_share_latest(recordings[0]));
    assert_null(execution_order_under_way(device.order, (VkQueue)(uintptr_t)1));
}

/* A command buffer that was submitted twice executes twice: each batch has its own execution. */
TEST_BETWEEN(test_each_batch_has_its_execution, set_up, tear_down)
{
    execution_order_add_semaphore(device.order, (VkSemaphore)(uintptr_t)SEMAPHORE,
                                  VK_SEMAPHORE_TYPE_TIMELINE, 0, false);
    const struct call_to_submit held = prepare(true, false, 1);
    submission_finish(held.submission, VK_SUCCESS);
    const struct call_to_submit next = prepare(true, false, 0);
    submission_finish(next.submission, VK_SUCCESS);
    assert_int_equal(call_count, 0); /* the other one follows it on its queue */
    struct submission *signal = submission_begin(device.order, SUBMIT_HOST_SIGNAL, VK_NULL_HANDLE);
    submission_add_batch(signal);
    submission_add_signal(signal, (VkSemaphore)(uintptr_t)SEMAPHORE, 1, SCOPE_ALL);
    assert_false(submission_prepare(signal));
    submission_finish(signal, VK_SUCCESS);
    assert_int_equal(call_count, 4);
    assert_run(0, &first, held.executions[0], 0);
    assert_run(2, &first, next.executions[0], 0);
    assert_true(calls[0].timestamp.count < calls[2].timestamp.count);
}

TEST_BETWEEN(test_executions_that_never_run_are_counted, set_up, tear_down)
{
    execution_order_add_semaphore(device.order, (VkSemaphore)(uintptr_t)SEMAPHORE,
                                  VK_SEMAPHORE_TYPE_TIMELINE, 0, false);
    const struct call_to_submit held = prepare(true, true, 1);
    submission_finish(held.submission, VK_SUCCESS);
    execution_order_end(device.order);
    snapshots_release_held(&snapshots);
    assert_int_equal(snapshots.held, 2);
    assert_int_equal(call_count, 0);
}

TEST_BETWEEN(test_spoiled_recording_has_lost_executions, set_up, tear_down)
{
    const struct call_to_submit call = prepare(true, false, 0);
    atomic_store(&recordings[0]->is_invalidated, true);
    submission_finish(call.submission, VK_SUCCESS);
    assert_int_equal(call_count, 2);
    assert_true(calls[0].has_no_snapshots);
}

/* An execution gives the chunks back, unless the command buffer is recorded further meanwhile. */
TEST_BETWEEN(test_chunks_stay_if_recording_continues, set_up, tear_down)
{
    for (int i = 0; i < 2; i++) {
        recordings[i]->executes_once = true;
        struct execution *execution = execution_create(recordings[i], &ticket);
        assert_non_null(execution);
        if (i == 1)
            recording_continue(recordings[i]);
        execution_release(execution);
        assert_int_equal(recordings[i]->is_spent, i == 0);
    }
}

/* What is not complete is lost, except to the submission that has it. */
TEST_BETWEEN(test_secondaries_lose_snapshots_with_their_primary, set_up, tear_down)
{
    execute(journals[0], journals[1]);
    struct execution *execution = execution_create(recordings[0], &ticket);
    ticket_end = VK_TIMEOUT;
    assert_int_equal(recording_detach(recordings[0], &ticket, 0), 0);
    assert_int_equal(recording_detach(recordings[0], NULL, 0), 2);
    assert_true(execution->children[0]->has_no_snapshots);
    execution_release(execution);
}

/* Two threads may submit a recording at once: each execution counts from its creation until its
 * own ticket has ended, in whatever order the tickets end. */
TEST_BETWEEN(test_each_execution_is_pending_until_its_end, set_up, tear_down)
{
    struct ticket other = {.references = 1, .wait = wait_for_other, .number = 2};
    other_end = VK_TIMEOUT;
    struct execution *older = execution_create(recordings[0], &other);
    struct execution *newer = execution_create(recordings[0], &ticket);
    assert_true(recording_is_pending(recordings[0], NULL));
    assert_true(recording_is_pending(recordings[0], &ticket));
    assert_false(recording_is_pending(recordings[0], &other));
    execution_release(newer);
    assert_true(recording_is_pending(recordings[0], NULL));
    other_end = VK_ERROR_OUT_OF_HOST_MEMORY;
    assert_true(recording_is_pending(recordings[0], NULL));
    other_end = VK_ERROR_DEVICE_LOST;
    assert_false(recording_is_pending(recordings[0], NULL));
    execution_release(older);
    assert_null(recording_share_latest(recordings[0]));
}

/* An execution that another thread made meanwhile is no longer distinct from the coming one. */
TEST_BETWEEN(test_rival_loses_snapshots, set_up, tear_down)
{
    struct ticket other = {.references = 1, .wait = wait_for_other, .number = 2};
    other_end = VK_TIMEOUT;
    struct execution *rival = execution_create(recordings[0], &other);
    struct execution *own = execution_create(recordings[0], &ticket);
    assert_int_equal(recording_detach(recordings[0], &ticket, 0), 1);
    assert_int_equal(recording_detach(recordings[0], &ticket, 0), 0);
    assert_true(rival->has_no_snapshots);
    assert_false(own->has_no_snapshots);
    struct execution *again = execution_create(recordings[0], &other);
    struct execution *third = execution_create(recordings[0], &ticket);
    assert_true(atomic_load(&rival->is_overwritten) && atomic_load(&own->is_overwritten));
    assert_false(atomic_load(&again->is_overwritten) || atomic_load(&third->is_overwritten));
    execution_release(rival);
    execution_release(third);
    execution_release(own);
    execution_release(again);
    assert_null(recording_share_latest(recordings[0]));
}

/* On another queue the device may execute the older one last. */
TEST_BETWEEN(test_queues_contest_snapshots, set_up, tear_down)
{
    struct ticket other = {.references = 1, .wait = wait_for_other, .queue = (VkQueue)(uintptr_t)1};
    ticket.queue = (VkQueue)(uintptr_t)2;
    execute(journals[0], journals[1]);
    other_end = VK_TIMEOUT;
    struct execution *rival = execution_create(recordings[1], &other);
    struct execution *own = execution_create(recordings[0], &ticket);
    assert_int_equal(execution_drop_contested(own), 1);
    assert_false(own->has_no_snapshots);
    assert_true(own->children[0]->has_no_snapshots && own->children[0]->detached);
    execution_release(own);

    own = execution_create(recordings[0], &ticket);
    ticket.queue = other.queue;
    assert_int_equal(execution_drop_contested(own), 0);
    ticket.queue = (VkQueue)(uintptr_t)2;
    other_end = VK_SUCCESS;
    assert_int_equal(execution_drop_contested(own), 0);
    assert_false(own->children[0]->has_no_snapshots);
    execution_release(own);
    execution_release(rival);
}

/* Nothing says when the device has ended. */
TEST_BETWEEN(test_secondaries_are_invalidated_with_their_primary, set_up, tear_down)
{
    execute(journals[0], journals[1]);
    assert_false(recording_is_pending(recordings[1], NULL));
    recording_invalidate(recordings[0]);
    assert_true(recording_is_pending(recordings[1], NULL));

    struct journal *primary = journal_create(VK_NULL_HANDLE);
    execute(primary, journals[1]);
    struct execution *execution =
        execution_create(recording_create(primary, &(struct recording_memory){NULL}), &ticket);
    execution_drop_invalidated(execution);
    assert_false(execution->has_no_snapshots);
    assert_true(execution->children[0]->has_no_snapshots);
    execution_release(execution);
    journal_release(primary);
}

TEST_BETWEEN(test_unknown_order_runs_all_that_is_expected, set_up, tear_down)
{
    execution_order_add_semaphore(device.order, (VkSemaphore)(uintptr_t)SEMAPHORE,
                                  VK_SEMAPHORE_TYPE_TIMELINE, 0, false);
    const struct call_to_submit older = prepare(false, true, 1);
    submission_finish(older.submission, VK_SUCCESS);
    const struct call_to_submit newer = prepare(true, false, 1);
    execution_order_set_unknown(device.order, ORDER_UNKNOWN_TOO_MANY_QUEUES);
    assert_calls("uuuu");
    assert_ptr_equal(calls[0].execution, older.executions[1]);
    assert_ptr_equal(calls[1].observer, &second);
    assert_ptr_equal(calls[2].execution, newer.executions[0]);
    assert_true(unknown_is_set(&snapshots.order_unknown));
    assert_int_equal(atomic_load(&snapshots.unordered), 2);
    assert_int_equal(unordered_reports, 1);
    assert_null(execution_order_under_way(device.order, (VkQueue)(uintptr_t)1));
    submission_finish(newer.submission, VK_SUCCESS);
}

TEST_BETWEEN(test_each_consumer_delivers, set_up, tear_down)
{
    snapshots_deliver(&device);
    assert_calls("dd");
    assert_ptr_equal(calls[0].observer, &first);
    assert_ptr_equal(calls[1].observer, &second);
}

TEST_BETWEEN(test_waiting_ends_with_the_first_that_succeeds, set_up, tear_down)
{
    assert_false(execution_order_wait(device.order));
    assert_calls("ww");
    first.waits = true;
    assert_true(execution_order_wait(device.order));
    assert_calls("www");
    assert_ptr_equal(calls[2].observer, &first);
}

TEST_BETWEEN(test_snapshots_need_no_consumer, set_up, tear_down)
{
    execution_order_destroy(device.order);
    set_up_order();
    const struct call_to_submit call = prepare(true, true, 0);
    submission_finish(call.submission, VK_SUCCESS);
    snapshots_deliver(&device);
    assert_false(execution_order_wait(device.order));
    assert_calls("");
}
