/* SPDX-License-Identifier: Apache-2.0 */
/* Programs of submits whose order is plain to see. Batches have names of two digits; queues and
 * semaphores have one. */
#include "program.h"

enum { S = 1, T = 2, U = 3, F = 4, G = 5 }; /* semaphores and fences */

PROGRAM_TEST(a_queue_executes_in_submission_order)
{
    SUBMIT(p, .queue = 1, .name = 10);
    SUBMIT(p, .queue = 1, .name = 11);
    assert_true(follows(p, 11, 10));
    assert_false(follows(p, 10, 11));
    assert_false(follows(p, 10, 10));
    assert_true(p->runs[0].checked && p->runs[0].predecessors_known);
    assert_ptr_equal(p->runs[0].queue, QUEUE(1));
    assert_int_equal(p->runs[0].command_count, 1);
}

PROGRAM_TEST(two_queues_have_no_order)
{
    SUBMIT(p, .queue = 1, .name = 10);
    SUBMIT(p, .queue = 2, .name = 20);
    SUBMIT(p, .queue = 1, .name = 11);
    assert_false(follows(p, 20, 10));
    assert_false(follows(p, 10, 20));
    assert_false(follows(p, 11, 20));
}

PROGRAM_TEST(a_binary_semaphore_orders)
{
    create_binary(p, S);
    SUBMIT(p, .queue = 1, .name = 10);
    SUBMIT(p, .queue = 1, .name = 11, .signal = {{S}});
    SUBMIT(p, .queue = 1, .name = 12);
    SUBMIT(p, .queue = 2, .name = 20);
    SUBMIT(p, .queue = 2, .name = 21, .wait = {{S}});
    SUBMIT(p, .queue = 2, .name = 22);
    assert_true(follows(p, 21, 11) && follows(p, 21, 10) && follows(p, 22, 11));
    assert_false(follows(p, 21, 12));
    assert_false(follows(p, 20, 10));
}

/* Each wait consumes one signal; one that has none is taken for someone else's. */

PROGRAM_TEST(a_wait_consumes_the_signal)
{
    create_binary(p, S);
    SUBMIT(p, .queue = 1, .name = 10, .signal = {{S}});
    SUBMIT(p, .queue = 2, .name = 20, .wait = {{S}});
    SUBMIT(p, .queue = 3, .name = 30, .wait = {{S}});
    assert_true(follows(p, 20, 10));
    assert_false(follows(p, 30, 10));
    SUBMIT(p, .queue = 3, .name = 31, .signal = {{S}});
    SUBMIT(p, .queue = 4, .name = 40, .wait = {{S}});
    assert_true(follows(p, 40, 31) && follows(p, 40, 30));
    assert_false(follows(p, 40, 10));
}

PROGRAM_TEST(presentation_and_acquisition_bring_no_order)
{
    create_binary(p, S);
    SUBMIT(p, .queue = 1, .name = 10, .signal = {{S}});
    execution_order_forget_signal(p->order, SEMAPHORE(S)); /* presented */
    execution_order_forget_signal(p->order, SEMAPHORE(S)); /* acquired */
    SUBMIT(p, .queue = 2, .name = 20, .wait = {{S}});
    assert_false(follows(p, 20, 10));
    assert_true(find_run(p, 20)->predecessors_known);
}

PROGRAM_TEST(unknown_semaphores_bring_no_order)
{
    SUBMIT(p, .queue = 1, .name = 10, .signal = {{S}});
    SUBMIT(p, .queue = 2, .name = 20, .wait = {{S}, {T, 7}});
    assert_false(follows(p, 20, 10));
}

PROGRAM_TEST(order_is_transitive_over_three_queues)
{
    create_binary(p, S);
    create_binary(p, T);
    SUBMIT(p, .queue = 1, .name = 10, .signal = {{S}});
    SUBMIT(p, .queue = 2, .name = 20, .wait = {{S}}, .signal = {{T}});
    SUBMIT(p, .queue = 3, .name = 30, .wait = {{T}});
    assert_true(follows(p, 30, 20) && follows(p, 30, 10));
}

/* The earliest signal that reaches the value, not the last one. */

PROGRAM_TEST(a_timeline_wait_follows_the_earliest_signal)
{
    create_timeline(p, S, 3);
    SUBMIT(p, .queue = 1, .name = 10, .signal = {{S, 5}});
    SUBMIT(p, .queue = 1, .name = 11, .signal = {{S, 8}});
    SUBMIT(p, .queue = 2, .name = 20, .wait = {{S, 3}});
    SUBMIT(p, .queue = 3, .name = 30, .wait = {{S, 4}});
    SUBMIT(p, .queue = 4, .name = 40, .wait = {{S, 6}});
    assert_false(follows(p, 20, 10));
    assert_true(follows(p, 30, 10));
    assert_false(follows(p, 30, 11));
    assert_true(follows(p, 40, 11) && follows(p, 40, 10));
}

PROGRAM_TEST(a_wait_before_its_signal_holds_the_queue_back)
{
    create_timeline(p, S, 0);
    SUBMIT(p, .queue = 2, .name = 20, .wait = {{S, 1}});
    SUBMIT(p, .queue = 2, .name = 21);
    assert_int_equal(p->run_count, 0);
    SUBMIT(p, .queue = 1, .name = 10);
    assert_int_equal(p->run_count, 1);
    SUBMIT(p, .queue = 1, .name = 11, .signal = {{S, 1}});
    assert_int_equal(p->run_count, 4);
    assert_int_equal(p->runs[1].name, 11);
    assert_int_equal(p->runs[2].name, 20);
    assert_int_equal(p->runs[3].name, 21);
    assert_true(follows(p, 20, 11) && follows(p, 21, 10));
    assert_false(find_run(p, 20)->checked);
    assert_true(find_run(p, 20)->predecessors_known && find_run(p, 11)->checked);
}

/* What one release signals releases more: 3 waits for 2, which waits for 1. */

PROGRAM_TEST(releases_go_on)
{
    create_timeline(p, S, 0);
    create_timeline(p, T, 0);
    SUBMIT(p, .queue = 3, .name = 30, .wait = {{T, 1}, {S, 1}});
    SUBMIT(p, .queue = 2, .name = 20, .wait = {{S, 1}}, .signal = {{T, 1}});
    SUBMIT(p, .queue = 1, .name = 10, .signal = {{S, 1}});
    assert_int_equal(p->run_count, 3);
    assert_true(follows(p, 30, 20) && follows(p, 30, 10) && follows(p, 20, 10));
}

/* vkQueueSubmit(queue, 0, NULL, fence). */

/* A wait for 2 has seen the signal of 3, no more; the counter says what it says. */

/* Waits and signals at stages that do no work on acceleration structures. */

PROGRAM_TEST(stages_limit_what_a_semaphore_orders)
{
    for (uint32_t i = S; i <= G; i++)
        create_binary(p, i);
    SUBMIT(p, .queue = 1, .name = 10, .signal = {{S}, {T, .reach = REACH_NOTHING}});
    SUBMIT(p, .queue = 2, .name = 20, .wait = {{S, .reach = REACH_NOTHING}},
           .signal = {{U}, {F, .reach = REACH_BUILDS}});
    SUBMIT(p, .queue = 3, .name = 30, .wait = {{T}});
    SUBMIT(p, .queue = 4, .name = 40, .wait = {{U}});
    SUBMIT(p, .queue = 5, .name = 50, .wait = {{F, .reach = REACH_BUILDS}});
    assert_false(follows(p, 20, 10)); /* it may begin before the wait is over */
    assert_false(follows(p, 30, 10)); /* the signal may come before it ends */
    assert_true(follows(p, 40, 20));
    assert_true(follows(p, 40, 10)); /* all of 20 has executed, its wait too */
    assert_true(follows(p, 50, 20));
    assert_false(follows(p, 50, 10)); /* only its builds have */
}

PROGRAM_TEST(batches_of_one_call_may_use_each_other)
{
    create_binary(p, S);
    create_timeline(p, T, 0);
    struct submission *call = submission_begin(p->order, SUBMIT_COMMANDS, QUEUE(1));
    call_add_batch(call, &(struct call){.name = 10, .signal = {{S}, {T, 1}}});
    call_add_batch(call, &(struct call){.name = 11, .wait = {{S}, {T, 1}}, .signal = {{S}}});
    call_add_batch(call, &(struct call){.name = 12, .wait = {{S}}});
    assert_true(finish_batches(call, 0, VK_SUCCESS));
    assert_int_equal(p->run_count, 3);
    assert_int_equal(p->checks, 3);
    assert_true(follows(p, 12, 10) && follows(p, 12, 11));
}

PROGRAM_TEST(handles_are_reused)
{
    create_timeline(p, S, 0);
    SUBMIT(p, .queue = 1, .name = 10, .signal = {{S, 5}});
    execution_order_remove_semaphore(p->order, SEMAPHORE(S));
    create_timeline(p, S, 0);
    SUBMIT(p, .queue = 2, .name = 20, .wait = {{S, 5}});
    assert_int_equal(p->run_count, 1);
    SUBMIT(p, .queue = 3, .name = 30, .signal = {{S, 5}});
    assert_true(follows(p, 20, 30));
    assert_false(follows(p, 20, 10));

    execution_order_remove_semaphore(p->order, SEMAPHORE(S));
    create_binary(p, S);
    SUBMIT(p, .queue = 4, .name = 40, .wait = {{S}});
    assert_false(follows(p, 40, 30));
}
