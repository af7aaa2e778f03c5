/* SPDX-License-Identifier: Apache-2.0 */
/* Programs of submits in which the host takes part: what it sees complete, what it signals, works
 * on, and what doesn't happen. */
#include "program.h"

enum { S = 1, T = 2, U = 3, F = 4 }; /* semaphores and fences */

PROGRAM_TEST(the_host_signals)
{
    create_timeline(p, S, 0);
    SUBMIT(p, .queue = 2, .name = 20, .wait = {{S, 1}});
    SUBMIT(p, .queue = 1, .name = 10);
    wait_idle(p, 1);
    SUBMIT(p, .queue = 1, .name = 11);
    signal_on_host(p, S, 1);
    assert_true(follows(p, 20, 10));
    assert_false(follows(p, 20, 11));
}

PROGRAM_TEST(a_fence_seen_orders_what_is_submitted_later)
{
    execution_order_add_fence(p->order, FENCE(F), false);
    SUBMIT(p, .queue = 1, .name = 10, .fence = F);
    SUBMIT(p, .queue = 1, .name = 11);
    SUBMIT(p, .queue = 2, .name = 20);
    execution_order_observe_fence(p->order, FENCE(F));
    SUBMIT(p, .queue = 2, .name = 21);
    assert_false(follows(p, 20, 10));
    assert_true(follows(p, 21, 10));
    assert_false(follows(p, 21, 11));
}

PROGRAM_TEST(fences_are_reset_and_reused)
{
    execution_order_add_fence(p->order, FENCE(F), false);
    SUBMIT(p, .queue = 1, .name = 10, .fence = F);
    execution_order_reset_fence(p->order, FENCE(F));
    execution_order_observe_fence(p->order, FENCE(F)); /* signalled by what isn't known */
    SUBMIT(p, .queue = 2, .name = 20);
    assert_false(follows(p, 20, 10));
    SUBMIT(p, .queue = 1, .name = 11, .fence = F);
    execution_order_observe_fence(p->order, FENCE(F));
    SUBMIT(p, .queue = 2, .name = 21);
    assert_true(follows(p, 21, 11) && follows(p, 21, 10));

    execution_order_remove_fence(p->order, FENCE(F));
    execution_order_add_fence(p->order, FENCE(F), false);
    SUBMIT(p, .queue = 1, .name = 12);
    execution_order_observe_fence(p->order, FENCE(F));
    SUBMIT(p, .queue = 2, .name = 22);
    assert_false(follows(p, 22, 12));
}

PROGRAM_TEST(a_fence_without_batches_follows_what_was_submitted)
{
    execution_order_add_fence(p->order, FENCE(F), false);
    SUBMIT(p, .queue = 1, .name = 10);
    struct submission *empty = submission_begin(p->order, SUBMIT_COMMANDS, QUEUE(1));
    assert_true(finish_batches(empty, F, VK_SUCCESS));
    execution_order_observe_fence(p->order, FENCE(F));
    SUBMIT(p, .queue = 2, .name = 20);
    assert_true(follows(p, 20, 10));
}

PROGRAM_TEST(the_fence_of_a_held_batch_gets_its_clock_later)
{
    execution_order_add_fence(p->order, FENCE(F), false);
    create_timeline(p, S, 0);
    SUBMIT(p, .queue = 1, .name = 10, .wait = {{S, 1}}, .fence = F);
    SUBMIT(p, .queue = 2, .name = 20, .signal = {{S, 1}});
    execution_order_observe_fence(p->order, FENCE(F));
    SUBMIT(p, .queue = 3, .name = 30);
    assert_true(follows(p, 30, 10) && follows(p, 30, 20));
}

PROGRAM_TEST(idle_queues_are_seen)
{
    SUBMIT(p, .queue = 1, .name = 10);
    SUBMIT(p, .queue = 2, .name = 20);
    wait_idle(p, 1);
    SUBMIT(p, .queue = 3, .name = 30);
    assert_true(follows(p, 30, 10));
    assert_false(follows(p, 30, 20));
    wait_idle(p, 0);
    SUBMIT(p, .queue = 3, .name = 31);
    assert_true(follows(p, 31, 20));
}

PROGRAM_TEST(the_host_sees_timelines)
{
    create_timeline(p, S, 0);
    SUBMIT(p, .queue = 1, .name = 10, .signal = {{S, 3}});
    SUBMIT(p, .queue = 1, .name = 11, .signal = {{S, 5}});
    SUBMIT(p, .queue = 1, .name = 12, .signal = {{S, 7}});
    execution_order_observe_semaphore(p->order, SEMAPHORE(S), 0, true);
    SUBMIT(p, .queue = 2, .name = 20);
    assert_false(follows(p, 20, 10));
    execution_order_observe_semaphore(p->order, SEMAPHORE(S), 2, false);
    SUBMIT(p, .queue = 2, .name = 21);
    assert_true(follows(p, 21, 10));
    assert_false(follows(p, 21, 11));
    execution_order_observe_semaphore(p->order, SEMAPHORE(S), 5, true);
    SUBMIT(p, .queue = 2, .name = 22);
    assert_true(follows(p, 22, 11));
    assert_false(follows(p, 22, 12));
}

PROGRAM_TEST(a_failed_call_has_not_happened)
{
    execution_order_add_fence(p->order, FENCE(F), false);
    create_binary(p, S);
    create_binary(p, U);
    create_timeline(p, T, 0);
    SUBMIT(p, .queue = 1, .name = 10, .signal = {{S}});
    SUBMIT(p, .queue = 2, .name = 20, .wait = {{T, 1}});
    const struct call call = {.queue = 3,
                              .name = 30,
                              .wait = {{S}},
                              .signal = {{T, 1}, {U}},
                              .fence = F,
                              .result = VK_ERROR_OUT_OF_DEVICE_MEMORY};
    submit(p, &call);
    assert_int_equal(p->run_count, 1);
    assert_int_equal(p->drops, 1);
    execution_order_observe_fence(p->order, FENCE(F));

    struct call again = call;
    again.result = VK_SUCCESS;
    submit(p, &again);
    assert_int_equal(p->run_count, 3);
    assert_true(follows(p, 30, 10) && follows(p, 20, 30));
    SUBMIT(p, .queue = 4, .name = 40, .wait = {{U}});
    assert_true(follows(p, 40, 30));
}

PROGRAM_TEST(a_check_may_ask_to_skip)
{
    create_binary(p, S);
    p->skip_name = 11;
    SUBMIT(p, .queue = 1, .name = 10, .signal = {{S}});
    struct submission *call = submission_begin(p->order, SUBMIT_COMMANDS, QUEUE(2));
    call_add_batch(call, &(struct call){.name = 20, .wait = {{S}}});
    call_add_batch(call, &(struct call){.name = 11});
    call_add_batch(call, &(struct call){.name = 21});
    assert_false(finish_batches(call, 0, VK_SUCCESS));
    assert_int_equal(p->checks, 4); /* the others are checked all the same */
    assert_int_equal(p->drops, 1);
    assert_int_equal(p->run_count, 1);
    assert_int_equal(p->captured, 0);
    SUBMIT(p, .queue = 2, .name = 20, .wait = {{S}});
    assert_true(follows(p, 20, 10));
}

PROGRAM_TEST(host_work_has_its_place)
{
    struct execution_clock before, after;
    SUBMIT(p, .queue = 1, .name = 10);
    SUBMIT(p, .queue = 2, .name = 20);
    wait_idle(p, 1);
    struct submission *work = submission_begin(p->order, SUBMIT_HOST_WORK, VK_NULL_HANDLE);
    submission_add_batch(work);
    submission_add_work(work, COMMAND_BUFFER(90));
    p->captured++;
    execution_order_host_clock(p->order, &before);
    assert_true(finish_batches(work, 0, VK_OPERATION_NOT_DEFERRED_KHR));
    execution_order_host_clock(p->order, &after);
    SUBMIT(p, .queue = 2, .name = 21);

    assert_null(find_run(p, 90)->queue);
    assert_true(find_run(p, 90)->checked);
    assert_true(follows(p, 90, 10) && follows(p, 21, 90));
    assert_false(follows(p, 90, 20));
    assert_false(follows(p, 20, 90));
    assert_false(execution_clock_has(&before, find_run(p, 90)->timestamp));
    assert_true(execution_clock_has(&after, find_run(p, 90)->timestamp));
}
