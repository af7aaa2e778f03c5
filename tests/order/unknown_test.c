/* SPDX-License-Identifier: Apache-2.0 */
/* What makes the order partly or wholly unknown. */
#include "program.h"

enum { S = 1, T = 2, F = 4, G = 5 }; /* semaphores and fences */

/* ---- losing the order */

PROGRAM_TEST(a_lost_device_loses_the_order)
{
    create_timeline(p, S, 0);
    SUBMIT(p, .queue = 1, .name = 10);
    SUBMIT(p, .queue = 2, .name = 20, .wait = {{S, 1}});
    struct submission *under_way = PREPARE(p, .queue = 3, .name = 30);
    SUBMIT(p, .queue = 1, .name = 11, .result = VK_ERROR_DEVICE_LOST);
    assert_int_equal(p->losses, 1);
    assert_int_equal(p->unknown_reason, ORDER_UNKNOWN_DEVICE_LOST);
    submission_finish(under_way, VK_SUCCESS);
    assert_int_equal(p->captured, 0);
    assert_null(submission_begin(p->order, SUBMIT_COMMANDS, QUEUE(1)));
    SUBMIT(p, .queue = 1, .name = 12);
    signal_on_host(p, S, 1);
    wait_idle(p, 0);
    EXPECT_RUNS(p, 10);
}

PROGRAM_TEST(two_calls_on_one_queue_lose_the_order)
{
    struct submission *first = PREPARE(p, .queue = 1, .name = 10);
    struct submission *second = PREPARE(p, .queue = 1, .name = 11);
    submission_finish(second, VK_SUCCESS);
    submission_finish(first, VK_SUCCESS);
    assert_int_equal(p->losses, 1);
    assert_int_equal(p->unknown_reason, ORDER_UNKNOWN_RACING_THREADS);
    assert_int_equal(p->run_count, 0);
}

PROGRAM_TEST(too_many_queues_lose_the_order)
{
    for (uint32_t queue = 1; queue < EXECUTION_QUEUES; queue++)
        SUBMIT(p, .queue = queue, .name = queue);
    assert_int_equal(p->losses, 0);
    assert_int_equal(p->run_count, EXECUTION_QUEUES - 1);
    SUBMIT(p, .queue = EXECUTION_QUEUES, .name = 99);
    assert_int_equal(p->losses, 1);
    assert_int_equal(p->unknown_reason, ORDER_UNKNOWN_TOO_MANY_QUEUES);
}

TEST(a_missing_order_is_accepted)
{
    struct execution_clock clock;
    struct program p = {0};
    create_timeline(&p, S, 0);
    SUBMIT(&p, .queue = 1, .name = 10, .wait = {{S, 1}}, .fence = F);
    execution_order_observe_fence(p.order, FENCE(F));
    wait_idle(&p, 0);
    execution_order_reset_fence(p.order, FENCE(F));
    execution_order_run(p.order);
    execution_order_host_clock(p.order, &clock);
    assert_int_equal(clock.queues, 0);
    program_stop(&p);
}

/* ---- what others signal */

PROGRAM_TEST(a_foreign_timeline_leaves_predecessors_unknown)
{
    execution_order_add_fence(p->order, FENCE(F), false);
    execution_order_add_semaphore(p->order, SEMAPHORE(S), VK_SEMAPHORE_TYPE_TIMELINE, 0, true);
    create_binary(p, T);
    SUBMIT(p, .queue = 1, .name = 10, .signal = {{S, 1}});
    SUBMIT(p, .queue = 2, .name = 20);
    SUBMIT(p, .queue = 2, .name = 21, .wait = {{S, 1}}, .signal = {{T}}, .fence = F);
    SUBMIT(p, .queue = 2, .name = 22);
    SUBMIT(p, .queue = 3, .name = 30, .wait = {{T}});
    SUBMIT(p, .queue = 4, .name = 40);
    assert_false(follows(p, 21, 10)); /* anybody may have signalled */
    assert_true(find_run(p, 20)->predecessors_known && find_run(p, 40)->predecessors_known);
    assert_false(find_run(p, 21)->predecessors_known || find_run(p, 22)->predecessors_known);
    assert_false(find_run(p, 30)->predecessors_known);
    execution_order_observe_fence(p->order, FENCE(F));
    SUBMIT(p, .queue = 2, .name = 23);
    SUBMIT(p, .queue = 3, .name = 31);
    assert_true(find_run(p, 23)->predecessors_known && find_run(p, 31)->predecessors_known);
    SUBMIT(p, .queue = 2, .name = 24, .wait = {{S, 2}});
    SUBMIT(p, .queue = 3, .name = 32);
    assert_false(find_run(p, 24)->predecessors_known);
    assert_true(find_run(p, 32)->predecessors_known);
}

PROGRAM_TEST(a_foreign_value_that_the_host_saw_is_no_riddle)
{
    create_timeline(p, S, 0);
    SUBMIT(p, .queue = 1, .name = 10, .wait = {{S, 5}});
    assert_int_equal(p->run_count, 0);
    execution_order_observe_semaphore(p->order, SEMAPHORE(S), 4, true); /* nobody signalled it */
    EXPECT_RUNS(p, 10);
    assert_false(find_run(p, 10)->predecessors_known);
    SUBMIT(p, .queue = 2, .name = 20, .wait = {{S, 4}});
    assert_true(find_run(p, 20)->predecessors_known);
    assert_int_equal(p->losses, 0);
}

PROGRAM_TEST(foreign_binary_semaphores_bring_no_order)
{
    create_binary(p, S);
    SUBMIT(p, .queue = 1, .name = 10, .signal = {{S}});
    execution_order_set_semaphore_foreign(p->order, SEMAPHORE(S)); /* imported */
    SUBMIT(p, .queue = 2, .name = 20, .wait = {{S}});
    assert_false(follows(p, 20, 10));
    assert_true(find_run(p, 20)->predecessors_known);
}

PROGRAM_TEST(foreign_fences_show_nothing)
{
    execution_order_add_fence(p->order, FENCE(F), true);
    execution_order_add_fence(p->order, FENCE(G), false);
    SUBMIT(p, .queue = 1, .name = 10, .fence = F);
    SUBMIT(p, .queue = 1, .name = 11, .fence = G);
    execution_order_set_fence_foreign(p->order, FENCE(G));
    execution_order_observe_fence(p->order, FENCE(F));
    execution_order_observe_fence(p->order, FENCE(G));
    SUBMIT(p, .queue = 2, .name = 20);
    assert_false(follows(p, 20, 10));
}

PROGRAM_TEST(bindings_that_wait_for_others_lose_the_order)
{
    execution_order_add_semaphore(p->order, SEMAPHORE(S), VK_SEMAPHORE_TYPE_TIMELINE, 0, true);
    SUBMIT(p, .queue = 1, .kind = SUBMIT_BINDINGS, .wait = {{S, 1}});
    assert_int_equal(p->losses, 1);
    assert_int_equal(p->unknown_reason, ORDER_UNKNOWN_TOO_MANY_WAITS);
}

/* Then the wait is over for a reason that isn't known. */
PROGRAM_TEST(a_semaphore_may_be_destroyed_while_it_is_waited_for)
{
    create_timeline(p, S, 0);
    SUBMIT(p, .queue = 1, .name = 10, .wait = {{S, 1}}, .signal = {{S, 2}});
    execution_order_remove_semaphore(p->order, SEMAPHORE(S));
    EXPECT_RUNS(p, 10);
    assert_false(p->runs[0].predecessors_known);
}
