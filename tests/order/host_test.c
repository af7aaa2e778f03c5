/* SPDX-License-Identifier: Apache-2.0 */
/* Programs of submits in which the host takes part: what it sees complete, what it signals, works
 * on, and what doesn't happen. */
#include "program.h"

SCRIPT_TEST(the_host_signals,
            "timeline S; 20 waits S=1; 10; idle 1; 11; host signals S=1;"
            "20 after 10; 20 not after 11;")

SCRIPT_TEST(a_fence_seen_orders_what_is_submitted_later,
            "fence F; 10 fence F; 11; 20; sees F; 21;"
            "20 not after 10; 21 after 10; 21 not after 11;")

/* The fence is first seen signalled by what isn't known. */
SCRIPT_TEST(fences_are_reset_and_reused,
            "fence F; 10 fence F; resets F; sees F; 20; 20 not after 10;"
            "11 fence F; sees F; 21; 21 after 11 10;"
            "destroys F; fence F; 12; sees F; 22; 22 not after 12;")

PROGRAM_TEST(a_fence_without_batches_follows_what_was_submitted)
{
    play(p, "fence F; 10;");
    struct submission *empty = submission_begin(p->order, SUBMIT_COMMANDS, QUEUE(1));
    assert_true(finish_batches(empty, F, VK_SUCCESS));
    play(p, "sees F; 20; 20 after 10;");
}

SCRIPT_TEST(
    the_fence_of_a_held_batch_gets_its_clock_later,
    "fence F; timeline S; 10 waits S=1 fence F; 20 signals S=1; sees F; 30; 30 after 10 20;")

SCRIPT_TEST(idle_queues_are_seen,
            "10; 20; idle 1; 30; 30 after 10; 30 not after 20; idle; 31; 31 after 20;")

SCRIPT_TEST(the_host_sees_timelines,
            "timeline S; 10 signals S=3; 11 signals S=5; 12 signals S=7;"
            "sees S=0; 20; 20 not after 10; sees S>2; 21; 21 after 10; 21 not after 11;"
            "sees S=5; 22; 22 after 11; 22 not after 12;")

SCRIPT_TEST(a_failed_call_has_not_happened,
            "fence F; binary S U; timeline T; 10 signals S; 20 waits T=1;"
            "30 waits S signals T=1 U fence F fails; ran 10; drops 1; sees F;"
            "30 waits S signals T=1 U fence F; ran 10 30 20;"
            "30 after 10; 20 after 30; 40 waits U; 40 after 30;")

PROGRAM_TEST(a_check_may_ask_to_skip)
{
    p->skip_name = 11;
    play(p, "binary S; 10 signals S;");
    struct submission *call = submission_begin(p->order, SUBMIT_COMMANDS, QUEUE(2));
    call_add_batch(call, &(struct call){.name = 20, .wait = {{S}}});
    call_add_batch(call, &(struct call){.name = 11});
    call_add_batch(call, &(struct call){.name = 21});
    assert_false(finish_batches(call, 0, VK_SUCCESS));
    /* The others are checked all the same. */
    play(p, "checks 4; drops 3; ran 10; captured 0; 20 waits S; 20 after 10;");
}

PROGRAM_TEST(host_work_has_its_place)
{
    struct execution_clock before, after;
    play(p, "10; 20; idle 1;");
    struct submission *work = submission_begin(p->order, SUBMIT_HOST_WORK, VK_NULL_HANDLE);
    submission_add_batch(work);
    submission_add_work(work, COMMAND_BUFFER(90));
    p->captured++;
    execution_order_host_clock(p->order, &before);
    assert_true(finish_batches(work, 0, VK_OPERATION_NOT_DEFERRED_KHR));
    execution_order_host_clock(p->order, &after);
    play(p, "21;");
    assert_null(find_run(p, 90)->queue);
    play(p, "90 checked; 90 after 10; 21 after 90; 90 not after 20; 20 not after 90;");
    assert_false(execution_clock_has(&before, find_run(p, 90)->timestamp));
    assert_true(execution_clock_has(&after, find_run(p, 90)->timestamp));
}

/* ---- what the host waits for and signals, as batches */

struct sync_run {
    uint64_t value;  /* of its semaphore operation; 0: it has none */
    uint64_t signal; /* likewise */
    bool is_signal, is_known, signals_foreign_object;
    enum work_phase work;
    struct timestamp timestamp;
    struct execution_clock host;
};

struct sync_runs {
    struct sync_run items[16];
    uint32_t count;
};

static void note_run(void *user, struct order_batch *batch)
{
    struct sync_runs *runs = user;
    struct sync_run *run = &runs->items[runs->count++];
    *run = (struct sync_run){.is_known = batch->predecessors_known,
                             .signals_foreign_object = batch->signals_foreign_object,
                             .work = batch->work,
                             .timestamp = batch->timestamp};
    if (batch->operation_count) {
        run->value = batch->operations[0].value;
        run->signal = batch->operations[0].signal;
        run->is_signal = batch->operations[0].is_signal;
        assert_int_not_equal(batch->operations[0].id, 0);
    }
    execution_clock_copy(&run->host, batch->host);
}

static void signal_on(struct execution_order *order, enum submission_kind kind, VkSemaphore handle,
                      uint64_t value, VkFence fence)
{
    struct submission *submission =
        submission_begin(order, kind, kind == SUBMIT_COMMANDS ? QUEUE(1) : VK_NULL_HANDLE);
    submission_add_batch(submission);
    submission_add_signal(submission, handle, value, SCOPE_NOTHING);
    assert_true(finish_batches(submission, (uint32_t)(uintptr_t)fence, VK_SUCCESS));
}

/* Each follows the one before, and the batches that come later follow it. */
TEST(waits_and_signals_of_the_host_are_batches)
{
    struct sync_runs runs = {.count = 0};
    struct execution_order *order;
    const struct execution_hooks hooks = {.follows_host = true};
    assert_int_equal(execution_order_create(&order, &hooks), VK_SUCCESS);
    execution_order_add_consumer(order, (struct batch_consumer){.user = &runs, .run = note_run});
    execution_order_add_semaphore(order, SEMAPHORE(S), VK_SEMAPHORE_TYPE_TIMELINE, 3, false);
    execution_order_observe_semaphore(order, SEMAPHORE(S), 3, true); /* from the start */
    assert_int_equal(runs.count, 0);
    signal_on(order, SUBMIT_HOST_SIGNAL, SEMAPHORE(S), 4, VK_NULL_HANDLE);
    signal_on(order, SUBMIT_COMMANDS, SEMAPHORE(S), 5, VK_NULL_HANDLE);
    execution_order_observe_semaphore(order, SEMAPHORE(S), 5, false);
    execution_order_observe_semaphore(order, SEMAPHORE(S), 5, true); /* nothing new */
    execution_order_observe_unknown(order, NULL);
    signal_on(order, SUBMIT_COMMANDS, SEMAPHORE(S), 6, VK_NULL_HANDLE);
    static const struct sync_run expected[] = {
        {4, 1, true, true, false, WORK_SYNC, {0}, {0}},
        {5, 2, true, true, false, WORK_OF_QUEUE, {0}, {0}},
        {5, 2, false, true, false, WORK_SYNC, {0}, {0}},
        {0, 0, false, false, false, WORK_SYNC, {0}, {0}},
        {6, 3, true, true, false, WORK_OF_QUEUE, {0}, {0}},
    };
    assert_int_equal(runs.count, sizeof(expected) / sizeof(expected[0]));
    for (uint32_t i = 0; i < runs.count; i++) {
        const struct sync_run *run = &runs.items[i];
        assert_int_equal(run->value, expected[i].value);
        assert_int_equal(run->signal, expected[i].signal);
        assert_int_equal(run->is_signal, expected[i].is_signal);
        assert_int_equal(run->is_known, expected[i].is_known);
        assert_int_equal(run->work, expected[i].work);
        for (uint32_t j = 0; j < i; j++)
            if (runs.items[j].work == WORK_SYNC)
                assert_true(execution_clock_has(&run->host, runs.items[j].timestamp));
    }
    execution_order_destroy(order);
}

TEST(a_queue_is_held_until_the_signal_is_submitted)
{
    struct execution_order *order;
    assert_int_equal(execution_order_create(&order, &(struct execution_hooks){0}), VK_SUCCESS);
    execution_order_add_semaphore(order, SEMAPHORE(S), VK_SEMAPHORE_TYPE_TIMELINE, 0, false);
    assert_false(execution_order_holds_queue(order, QUEUE(1)));
    struct submission *submission = submission_begin(order, SUBMIT_COMMANDS, QUEUE(1));
    submission_add_batch(submission);
    submission_add_wait(submission, SEMAPHORE(S), 1, SCOPE_ALL);
    submission_prepare(submission);
    submission_finish(submission, VK_SUCCESS);
    assert_true(execution_order_holds_queue(order, QUEUE(1)));
    assert_false(execution_order_holds_queue(order, QUEUE(2)));
    signal_on(order, SUBMIT_HOST_SIGNAL, SEMAPHORE(S), 1, VK_NULL_HANDLE);
    assert_false(execution_order_holds_queue(order, QUEUE(1)));
    execution_order_set_unknown(order, ORDER_UNKNOWN_DEVICE_LOST);
    assert_false(execution_order_holds_queue(order, QUEUE(1)));
    assert_false(execution_order_holds_queue(NULL, QUEUE(1)));
    execution_order_end(order);
    execution_order_destroy(order);
}

TEST(there_is_no_limit_of_consumers)
{
    struct execution_order *order;
    assert_int_equal(execution_order_create(&order, &(struct execution_hooks){0}), VK_SUCCESS);
    for (int i = 0; i < 100; i++)
        assert_true(execution_order_add_consumer(order, (struct batch_consumer){0}));
    execution_order_end(order);
    execution_order_destroy(order);
}

/* If others may signal an object, its state shows nothing certain, and the application may observe
 * it without the layer. */
TEST(exported_objects_may_show_anything)
{
    struct sync_runs runs = {.count = 0};
    struct execution_order *order;
    const struct execution_hooks hooks = {.follows_host = true};
    assert_int_equal(execution_order_create(&order, &hooks), VK_SUCCESS);
    execution_order_add_consumer(order, (struct batch_consumer){.user = &runs, .run = note_run});
    execution_order_add_semaphore(order, SEMAPHORE(S), VK_SEMAPHORE_TYPE_TIMELINE, 0, false);
    execution_order_add_semaphore(order, SEMAPHORE(T), VK_SEMAPHORE_TYPE_TIMELINE, 0, true);
    execution_order_add_fence(order, FENCE(F), true, false);
    execution_order_add_fence(order, FENCE(G), false, true);
    execution_order_observe_fence(order, FENCE(G)); /* signaled from the start */
    signal_on(order, SUBMIT_COMMANDS, SEMAPHORE(S), 1, VK_NULL_HANDLE);
    signal_on(order, SUBMIT_COMMANDS, SEMAPHORE(T), 1, VK_NULL_HANDLE);
    signal_on(order, SUBMIT_COMMANDS, SEMAPHORE(S), 2, FENCE(F));
    assert_int_equal(runs.count, 3);
    assert_false(runs.items[0].signals_foreign_object);
    assert_true(runs.items[1].signals_foreign_object);
    assert_true(runs.items[2].signals_foreign_object);
    execution_order_observe_fence(order, FENCE(F));
    execution_order_observe_fence(order, FENCE(F)); /* nothing new */
    execution_order_observe_semaphore(order, SEMAPHORE(T), 1, true);
    assert_int_equal(runs.count, 5);
    for (uint32_t i = 3; i < 5; i++) {
        assert_int_equal(runs.items[i].work, WORK_SYNC);
        assert_false(runs.items[i].is_known);
    }
    execution_order_destroy(order);
}

/* A batch that signals an exported object may be known to be complete as soon as it is submitted,
 * and so may what it follows; later batches are pending. An imported fence may show anything. */
TEST(exported_objects_show_the_batches_that_signal_them)
{
    struct sync_runs runs = {.count = 0};
    struct execution_order *order;
    struct execution_clock seen;
    uint64_t before, after;
    assert_int_equal(execution_order_create(&order, &(struct execution_hooks){0}), VK_SUCCESS);
    execution_order_add_consumer(order, (struct batch_consumer){.user = &runs, .run = note_run});
    execution_order_add_semaphore(order, SEMAPHORE(S), VK_SEMAPHORE_TYPE_TIMELINE, 0, false);
    execution_order_add_fence(order, FENCE(F), true, false);
    signal_on(order, SUBMIT_COMMANDS, SEMAPHORE(S), 1, VK_NULL_HANDLE);
    signal_on(order, SUBMIT_COMMANDS, SEMAPHORE(S), 2, FENCE(F));
    signal_on(order, SUBMIT_COMMANDS, SEMAPHORE(S), 3, VK_NULL_HANDLE);
    assert_true(execution_order_find_observed(order, &seen, &before));
    assert_true(execution_clock_has(&seen, runs.items[0].timestamp));
    assert_true(execution_clock_has(&seen, runs.items[1].timestamp));
    assert_false(execution_clock_has(&seen, runs.items[2].timestamp));
    execution_order_observe_fence(order, FENCE(F));
    execution_order_observe_any_fence(order, 1, (const VkFence[]){FENCE(F)});
    assert_true(execution_order_find_observed(order, &seen, &after));
    assert_int_equal(before, after);
    assert_false(execution_clock_has(&seen, runs.items[2].timestamp));
    execution_order_reset_fence(order, FENCE(F));
    execution_order_set_fence_foreign(order, FENCE(F));
    execution_order_observe_fence(order, FENCE(F));
    assert_true(execution_order_find_observed(order, &seen, &after));
    assert_int_not_equal(before, after);
    execution_order_destroy(order);
}
