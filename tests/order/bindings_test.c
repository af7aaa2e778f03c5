/* SPDX-License-Identifier: Apache-2.0 */
/* Sparse bindings, which only semaphores, fences and idle queues put in order. */
#include "program.h"

enum { S = 1, T = 2, U = 3, F = 4 }; /* semaphores and a fence */

#define BIND(program, ...) SUBMIT(program, .kind = SUBMIT_BINDINGS, __VA_ARGS__)

PROGRAM_TEST(a_queue_puts_bindings_in_no_order)
{
    SUBMIT(p, .queue = 1, .name = 10);
    BIND(p, .queue = 1, .name = 11);
    BIND(p, .queue = 1, .name = 12);
    SUBMIT(p, .queue = 1, .name = 13);
    assert_int_equal(p->run_count, 4);
    assert_false(find_run(p, 11)->checked);
    assert_false(follows(p, 11, 10) || follows(p, 12, 10));
    assert_false(follows(p, 12, 11) || follows(p, 13, 11) || follows(p, 13, 12));
    assert_true(follows(p, 13, 10));
}

PROGRAM_TEST(semaphores_put_bindings_in_order)
{
    create_binary(p, S);
    create_binary(p, T);
    create_timeline(p, U, 0);
    SUBMIT(p, .queue = 1, .name = 10, .signal = {{S}});
    BIND(p, .queue = 1, .name = 11, .wait = {{S}}, .signal = {{T}});
    SUBMIT(p, .queue = 2, .name = 20);
    SUBMIT(p, .queue = 2, .name = 21, .wait = {{T}}, .signal = {{U, 1}});
    BIND(p, .queue = 3, .name = 30, .wait = {{U, 1}});
    assert_true(follows(p, 11, 10) && follows(p, 21, 11) && follows(p, 30, 11));
    assert_false(follows(p, 20, 11));
}

/* To follow a binding is to follow all before it, or it is not known to be followed. */
PROGRAM_TEST(a_signal_is_of_its_own_binding)
{
    create_binary(p, S);
    create_binary(p, T);
    BIND(p, .queue = 1, .name = 10, .signal = {{S}});
    BIND(p, .queue = 1, .name = 11);
    BIND(p, .queue = 1, .name = 12, .signal = {{T}});
    SUBMIT(p, .queue = 2, .name = 20, .wait = {{S}});
    SUBMIT(p, .queue = 3, .name = 30, .wait = {{T}});
    assert_true(follows(p, 20, 10));
    assert_false(follows(p, 20, 11));
    assert_false(follows(p, 30, 11));
}

PROGRAM_TEST(a_chain_of_bindings_is_followed)
{
    create_timeline(p, S, 0);
    BIND(p, .queue = 1, .name = 10, .signal = {{S, 1}});
    BIND(p, .queue = 1, .name = 11, .wait = {{S, 1}}, .signal = {{S, 2}});
    BIND(p, .queue = 1, .name = 12, .wait = {{S, 2}}, .signal = {{S, 3}});
    SUBMIT(p, .queue = 1, .name = 13, .wait = {{S, 3}});
    assert_true(follows(p, 11, 10) && follows(p, 12, 11));
    assert_true(follows(p, 13, 10) && follows(p, 13, 11) && follows(p, 13, 12));
}

PROGRAM_TEST(a_fence_covers_all_bindings_of_its_call)
{
    execution_order_add_fence(p->order, FENCE(F), false);
    struct submission *call = submission_begin(p->order, SUBMIT_BINDINGS, QUEUE(1));
    call_add_batch(call, &(struct call){.name = 10});
    call_add_batch(call, &(struct call){.name = 11});
    assert_true(finish_batches(call, F, VK_SUCCESS));
    BIND(p, .queue = 1, .name = 12);
    SUBMIT(p, .queue = 1, .name = 13);
    execution_order_observe_fence(p->order, FENCE(F));
    SUBMIT(p, .queue = 2, .name = 20);
    assert_false(follows(p, 13, 10));
    assert_true(follows(p, 20, 10) && follows(p, 20, 11));
    assert_false(follows(p, 20, 12));
}

PROGRAM_TEST(an_idle_queue_has_bound_all)
{
    BIND(p, .queue = 1, .name = 10);
    BIND(p, .queue = 1, .name = 11);
    BIND(p, .queue = 2, .name = 20);
    wait_idle(p, 1);
    SUBMIT(p, .queue = 3, .name = 30);
    assert_true(follows(p, 30, 10) && follows(p, 30, 11));
    assert_false(follows(p, 30, 20));
    wait_idle(p, 0);
    SUBMIT(p, .queue = 3, .name = 31);
    assert_true(follows(p, 31, 20));
}

/* What the host sees later counts for what a semaphore signals later. */
PROGRAM_TEST(bindings_after_an_idle_wait_are_followed_again)
{
    create_binary(p, S);
    BIND(p, .queue = 1, .name = 10);
    wait_idle(p, 1);
    BIND(p, .queue = 1, .name = 11, .signal = {{S}});
    SUBMIT(p, .queue = 2, .name = 20, .wait = {{S}});
    assert_true(follows(p, 20, 10) && follows(p, 20, 11));
}

PROGRAM_TEST(bindings_that_fail_never_execute)
{
    create_binary(p, S);
    BIND(p, .queue = 1, .name = 10, .result = VK_ERROR_OUT_OF_HOST_MEMORY);
    BIND(p, .queue = 1, .name = 11, .signal = {{S}});
    SUBMIT(p, .queue = 1, .name = 12, .wait = {{S}});
    EXPECT_RUNS(p, 11, 12);
    assert_true(follows(p, 12, 11));
}

PROGRAM_TEST(sparse_bindings_pass_order_on)
{
    execution_order_add_fence(p->order, FENCE(F), false);
    create_binary(p, S);
    create_binary(p, T);
    SUBMIT(p, .queue = 2, .name = 20);
    SUBMIT(p, .queue = 1, .name = 10, .signal = {{S}});
    BIND(p, .queue = 2, .wait = {{S}}, .signal = {{T}}, .fence = F);
    SUBMIT(p, .queue = 2, .name = 21);
    SUBMIT(p, .queue = 3, .name = 30, .wait = {{T}});
    assert_true(follows(p, 30, 10));
    assert_false(follows(p, 30, 20)); /* bindings don't wait for commands before them, */
    assert_false(follows(p, 21, 10)); /* nor do commands for bindings before them */
    execution_order_observe_fence(p->order, FENCE(F));
    SUBMIT(p, .queue = 4, .name = 40);
    assert_true(follows(p, 40, 10));
    assert_false(follows(p, 40, 20));
}

PROGRAM_TEST(bindings_are_held_back_too)
{
    create_timeline(p, S, 0);
    create_binary(p, T);
    BIND(p, .queue = 2, .wait = {{S, 1}}, .signal = {{T}});
    SUBMIT(p, .queue = 3, .name = 30, .wait = {{T}});
    SUBMIT(p, .queue = 1, .name = 10, .signal = {{S, 1}});
    assert_true(follows(p, 30, 10));
}

PROGRAM_TEST(bindings_pass_commands_that_wait_for_them)
{
    create_timeline(p, S, 0);
    SUBMIT(p, .queue = 1, .name = 10, .wait = {{S, 1}});
    SUBMIT(p, .queue = 1, .name = 11);
    BIND(p, .queue = 1, .name = 12, .signal = {{S, 1}});
    EXPECT_RUNS(p, 12, 10, 11);
    assert_true(follows(p, 10, 12) && follows(p, 11, 12));
    wait_idle(p, 0);
    SUBMIT(p, .queue = 2, .name = 20);
    assert_int_equal(p->losses, 0);
    assert_true(follows(p, 20, 11));
}

PROGRAM_TEST(commands_and_bindings_pass_bindings)
{
    create_timeline(p, S, 0);
    BIND(p, .queue = 1, .name = 10, .wait = {{S, 2}});
    BIND(p, .queue = 1, .name = 11, .wait = {{S, 1}});
    SUBMIT(p, .queue = 1, .name = 12, .signal = {{S, 1}});
    EXPECT_RUNS(p, 12, 11);
    BIND(p, .queue = 1, .name = 13, .signal = {{S, 2}});
    EXPECT_RUNS(p, 12, 11, 13, 10);
    assert_true(follows(p, 11, 12));
}

/* Signals of one queue come in the order of submission. */
PROGRAM_TEST(signals_pass_no_signals)
{
    create_timeline(p, S, 0);
    create_timeline(p, T, 0);
    create_timeline(p, U, 0);
    SUBMIT(p, .queue = 1, .name = 10, .wait = {{S, 1}}, .signal = {{T, 1}});
    BIND(p, .queue = 1, .name = 11, .signal = {{U, 1}});
    SUBMIT(p, .queue = 2, .name = 20, .wait = {{U, 1}});
    assert_int_equal(p->run_count, 0);
    SUBMIT(p, .queue = 3, .name = 30, .signal = {{S, 1}});
    EXPECT_RUNS(p, 30, 10, 11, 20);
    assert_true(follows(p, 20, 10) && follows(p, 20, 11));
}
