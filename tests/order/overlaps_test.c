/* SPDX-License-Identifier: Apache-2.0 */
/* Calls that overlap, as those of several threads do, step by step. */
#include "program.h"

PROGRAM_TEST(a_call_under_way_blocks_later_ones)
{
    struct submission *first = PREPARE(p, .queue = 1, .name = 10);
    play(p, "20; ran;");
    submission_finish(first, VK_SUCCESS);
    play(p, "ran 10 20; 10 checked; 20 unchecked;"); /* what came before 20 had not run */
}

PROGRAM_TEST(a_call_that_fails_blocks_no_more)
{
    struct submission *first = PREPARE(p, .queue = 1, .name = 10);
    struct submission *second = PREPARE(p, .queue = 2, .name = 20);
    play(p, "30;");
    submission_finish(second, VK_ERROR_OUT_OF_HOST_MEMORY);
    assert_int_equal(p->drops, 0); /* it was not checked */
    submission_finish(first, VK_ERROR_OUT_OF_HOST_MEMORY);
    assert_int_equal(p->drops, 1);
    play(p, "ran 30; 11;");
    assert_int_equal(find_run(p, 11)->timestamp.count, 1);
}

/* The device may be quicker than the return of the call. */
PROGRAM_TEST(the_host_may_see_a_signal_of_a_call_under_way)
{
    play(p, "timeline S;");
    struct submission *first = PREPARE(p, .queue = 1, .name = 10, .signal = {{S, 3}});
    play(p, "sees S>2; 20; ran;");
    submission_finish(first, VK_SUCCESS);
    play(p, "30; ran 10 20 30; 30 after 10;");
    assert_int_equal(p->losses, 0);
}

PROGRAM_TEST(a_wait_ends_when_the_call_has_returned)
{
    play(p, "timeline S;");
    struct submission *first = PREPARE(p, .queue = 1, .name = 10, .signal = {{S, 1}});
    play(p, "20 waits S=1;");
    submission_finish(first, VK_ERROR_OUT_OF_HOST_MEMORY);
    play(p, "ran; 11 signals S=1; ran 11 20; 20 after 11;");
}

/* 5 is signalled by a call under way, so 10, which is known, is not what ends a wait for 3. */
PROGRAM_TEST(an_unpublished_signal_hides_later_ones)
{
    play(p, "timeline S;");
    struct submission *first = PREPARE(p, .queue = 1, .name = 10, .signal = {{S, 5}});
    play(p, "sees S=5; 20 signals S=10; 30 waits S=3;");
    submission_finish(first, VK_SUCCESS);
    play(p, "ran 10 20 30; 30 after 10; 30 not after 20;");
}

static const char *const seeings[] = {"sees F;", "idle 2;", "sees T=1;"};

/* 20, with the fence F and a signal of T, until S is signalled. */
static void start_with_a_held_batch(struct program *program)
{
    program_start(program);
    play(program, "fence F; timeline S T; 20 waits S=1 signals T=1 fence F;");
}

/* 20 is held, but a call under way releases it. */
TEST(the_host_may_see_a_batch_before_it_is_released)
{
    struct program p;
    for (uint32_t i = 0; i < sizeof(seeings) / sizeof(seeings[0]); i++) {
        start_with_a_held_batch(&p);
        struct submission *first = PREPARE(&p, .queue = 1, .name = 10, .signal = {{S, 1}});
        play(&p, seeings[i]);
        play(&p, "30;");
        submission_finish(first, VK_SUCCESS);
        play(&p, "31;");
        assert_int_equal(p.losses, 0);
        play(&p, "30 unknown; 31 known; 31 after 20 10;"); /* 30 truly follows 20 */
        program_stop(&p);
    }
}

TEST(what_the_host_sees_may_contradict_the_order)
{
    struct program p;
    for (uint32_t i = 0; i < sizeof(seeings) / sizeof(seeings[0]); i++) {
        start_with_a_held_batch(&p);
        assert_int_equal(p.captured, 1);
        play(&p, seeings[i]);
        assert_int_equal(p.losses, 1);
        assert_int_equal(p.unknown_reason, ORDER_UNKNOWN_UNTRACKED_SIGNAL);
        assert_int_equal(p.captured, 0);
        play(&p, "30;");
        play(&p, seeings[i]);
        execution_order_set_unknown(p.order, ORDER_UNKNOWN_DEVICE_LOST);
        assert_int_equal(p.run_count, 0);
        assert_int_equal(p.losses, 1);
        program_stop(&p);
    }
}

/* ---- several threads in the hooks */

static void submit_20(struct program *program)
{
    uint32_t runs = program->run_count;
    SUBMIT(program, .queue = 2, .name = 20);
    assert_int_equal(program->run_count, runs);
}

TEST(one_thread_runs_for_the_others)
{
    struct program p;
    program_start(&p);
    play(&p, "10;");
    p.meanwhile = submit_20; /* inside the check of 11 */
    play(&p, "11; ran 10 11 20; 20 unchecked;");
    program_stop(&p);

    program_start(&p);
    struct submission *call = PREPARE(&p, .queue = 1, .name = 10);
    p.meanwhile = submit_20; /* inside the run of 10 */
    submission_finish(call, VK_SUCCESS);
    play(&p, "ran 10 20; 20 unchecked;");
    program_stop(&p);
}

static void lose_it(struct program *program)
{
    execution_order_set_unknown(program->order, ORDER_UNKNOWN_DEVICE_LOST);
    assert_int_equal(program->losses, 0); /* the other thread has to leave its hook first */
}

PROGRAM_TEST(the_order_may_be_lost_during_a_check)
{
    p->meanwhile = lose_it;
    play(p, "10;");
    assert_int_equal(p->losses, 1);
    play(p, "ran;");
    assert_int_equal(p->captured, 0);
}

static struct submission *begin_work(struct program *program, uint32_t name)
{
    struct submission *work = submission_begin(program->order, SUBMIT_HOST_WORK, VK_NULL_HANDLE);
    call_add_batch(work, &(struct call){.name = name});
    assert_false(submission_prepare(work));
    return work;
}

PROGRAM_TEST(host_work_under_way_blocks_nothing)
{
    struct submission *work = begin_work(p, 90);
    play(p, "10;");
    submission_finish(work, VK_SUCCESS);
    play(p,
         "11; ran 10 90 11; 10 checked; 90 checked;"
         "10 not after 90; 90 not after 10; 11 after 90;");
}

/* 91 ends first, though 90 began before it; 92 fails. */
PROGRAM_TEST(host_work_may_overlap)
{
    struct submission *first = begin_work(p, 90), *second = begin_work(p, 91);
    submission_finish(second, VK_SUCCESS);
    play(p, "10;");
    struct submission *third = begin_work(p, 92);
    submission_finish(first, VK_SUCCESS);
    play(p, "11;");
    submission_finish(third, VK_ERROR_OUT_OF_HOST_MEMORY);
    struct submission *fourth = begin_work(p, 93);
    submission_finish(fourth, VK_SUCCESS);
    play(p,
         "12; ran 91 10 90 11 93 12; 91 not after 90; 90 not after 91; 10 not after 90;"
         "10 after 91; 11 after 90 91; 93 after 90; 12 after 93;"
         "91 checked; 90 checked; 93 checked;");
}

/* What host work follows may still be waiting for its turn: then it is checked when it runs. */
PROGRAM_TEST(host_work_is_not_checked_before_others_have_run)
{
    struct submission *call = PREPARE(p, .queue = 1, .name = 10);
    struct submission *work = begin_work(p, 90);
    submission_finish_silently(work, VK_SUCCESS);
    assert_int_equal(p->run_count + p->begins, 0);
    submission_finish_silently(call, VK_ERROR_OUT_OF_HOST_MEMORY);
    assert_int_equal(p->drops, 1);
    play(p, "ran;");
    execution_order_run(p->order);
    play(p, "ran 90; 90 unchecked;");
}

/* Elsewhere something may be about to tell what came before the host's command. */
static void expect_no_turn(struct program *program)
{
    struct execution_clock clock;
    assert_false(execution_order_host_is_current(program->order, &clock));
}

PROGRAM_TEST(the_host_has_its_turn_when_nothing_is_left_to_be_told)
{
    struct execution_clock clock;
    play(p, "10; idle 1;");
    assert_true(execution_order_host_is_current(p->order, &clock));
    assert_true(execution_clock_has(&clock, find_run(p, 10)->timestamp));
    struct submission *call = PREPARE(p, .queue = 1, .name = 11);
    expect_no_turn(p);
    p->meanwhile = expect_no_turn; /* inside the run of 11 */
    submission_finish(call, VK_SUCCESS);
    assert_true(execution_order_host_is_current(p->order, &clock));
    assert_false(execution_clock_has(&clock, find_run(p, 11)->timestamp));
    execution_order_set_unknown(p->order, ORDER_UNKNOWN_DEVICE_LOST);
    expect_no_turn(p);
}

PROGRAM_TEST(host_work_that_fails_drops_nothing)
{
    struct submission *work = begin_work(p, 90);
    struct submission *call = PREPARE(p, .queue = 1, .name = 10);
    submission_finish(work, VK_ERROR_OUT_OF_HOST_MEMORY);
    assert_int_equal(p->drops, 0);
    submission_finish(call, VK_SUCCESS);
    play(p, "ran 10; 10 checked;");
    assert_int_equal(p->begins, 1);
    assert_int_equal(p->failures, 1);
    p->skip_name = 91;
    work = submission_begin(p->order, SUBMIT_HOST_WORK, VK_NULL_HANDLE);
    call_add_batch(work, &(struct call){.name = 91});
    assert_true(submission_prepare(work));
    work = submission_begin(p->order, SUBMIT_HOST_WORK, VK_NULL_HANDLE);
    call_add_batch(work, &(struct call){.name = 92});
    submission_set_skip(work);
    assert_true(submission_prepare(work));
    assert_int_equal(p->checks, 4);
    assert_int_equal(p->drops, 0);
    assert_int_equal(p->begins, 1);
    play(p, "ran 10;");
}
