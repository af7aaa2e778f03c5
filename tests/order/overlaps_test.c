/* SPDX-License-Identifier: Apache-2.0 */
/* Calls that overlap, as those of several threads do, step by step. */
#include "program.h"

/* What came before 20 had not run. */
SCRIPT_TEST(a_call_under_way_blocks_later_ones,
            "10 begins; 20; ran; 10 returns; ran 10 20; 10 checked; 20 unchecked;")

PROGRAM_TEST(a_call_that_fails_blocks_no_more)
{
    play(p, "10 begins; 20 begins; 30; 20 failed; drops 0; 10 failed; drops 1; ran 30; 11;");
    assert_int_equal(find_run(p, 11)->timestamp.count, 1);
}

/* The device may be quicker than the return of the call. */
SCRIPT_TEST(the_host_may_see_a_signal_of_a_call_under_way,
            "timeline S; 10 begins signals S=3; sees S>2; 20; ran; 10 returns; 30; ran 10 20 30;"
            "30 after 10; losses 0;")

SCRIPT_TEST(a_wait_ends_when_the_call_has_returned,
            "timeline S; 10 begins signals S=1; 20 waits S=1; 10 failed; ran; 11 signals S=1;"
            "ran 11 20; 20 after 11;")

/* 5 is signalled by a call under way, so 10, which is known, is not what ends a wait for 3. */
SCRIPT_TEST(an_unpublished_signal_hides_later_ones,
            "timeline S; 10 begins signals S=5; sees S=5; 20 signals S=10; 30 waits S=3;"
            "10 returns; ran 10 20 30; 30 after 10; 30 not after 20;")

static const char *const seeings[] = {"sees F;", "idle 2;", "sees T=1;"};

/* 20, with the fence F and a signal of T, until S is signalled. */
static void start_with_a_held_batch(struct program *program)
{
    program_start(program);
    play(program, "fence F; timeline S T; 20 waits S=1 signals T=1 fence F;");
}

/* 20 is held, but a call under way releases it. 30 truly follows 20. */
TEST(the_host_may_see_a_batch_before_it_is_released)
{
    struct program p;
    for (uint32_t i = 0; i < sizeof(seeings) / sizeof(seeings[0]); i++) {
        start_with_a_held_batch(&p);
        play(&p, "10 begins signals S=1;");
        play(&p, seeings[i]);
        play(&p, "30; 10 returns; 31; losses 0; 30 unknown; 31 known; 31 after 20 10;");
        program_stop(&p);
    }
}

TEST(what_the_host_sees_may_contradict_the_order)
{
    struct program p;
    for (uint32_t i = 0; i < sizeof(seeings) / sizeof(seeings[0]); i++) {
        start_with_a_held_batch(&p);
        play(&p, "captured 1;");
        play(&p, seeings[i]);
        assert_int_equal(p.unknown_reason, ORDER_UNKNOWN_UNTRACKED_SIGNAL);
        play(&p, "losses 1; captured 0; 30;");
        play(&p, seeings[i]);
        execution_order_set_unknown(p.order, ORDER_UNKNOWN_DEVICE_LOST);
        play(&p, "ran; losses 1;");
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

PROGRAM_TEST(one_thread_runs_for_the_others)
{
    play(p, "10;");
    p->meanwhile = submit_20; /* inside the check of 11 */
    play(p, "11; ran 10 11 20; 20 unchecked;");
}

PROGRAM_TEST(one_thread_runs_what_others_submit)
{
    play(p, "10 begins;");
    p->meanwhile = submit_20; /* inside the run of 10 */
    play(p, "10 returns; ran 10 20; 20 unchecked;");
}

static void lose_it(struct program *program)
{
    execution_order_set_unknown(program->order, ORDER_UNKNOWN_DEVICE_LOST);
    assert_int_equal(program->losses, 0); /* the other thread has to leave its hook first */
}

PROGRAM_TEST(the_order_may_be_lost_during_a_check)
{
    p->meanwhile = lose_it;
    play(p, "10; losses 1; ran; captured 0;");
}

SCRIPT_TEST(host_work_under_way_blocks_nothing,
            "work 90 begins; 10; 90 returns; 11; ran 10 90 11; 10 checked; 90 checked;"
            "10 not after 90; 90 not after 10; 11 after 90;")

/* 91 ends first, though 90 began before it; 92 fails. */
SCRIPT_TEST(host_work_may_overlap,
            "work 90 begins; work 91 begins; 91 returns; 10; work 92 begins; 90 returns; 11;"
            "92 failed; work 93; 12; ran 91 10 90 11 93 12; 91 not after 90; 90 not after 91;"
            "10 not after 90; 10 after 91; 11 after 90 91; 93 after 90; 12 after 93;"
            "91 checked; 90 checked; 93 checked;")

/* What host work follows may still be waiting for its turn: then it is checked when it runs. */
PROGRAM_TEST(host_work_is_not_checked_before_others_have_run)
{
    play(p, "10 begins; work 90 begins;");
    submission_finish_silently(p->under_way[90], VK_SUCCESS);
    play(p, "ran; begun 0;");
    submission_finish_silently(p->under_way[10], VK_ERROR_OUT_OF_HOST_MEMORY);
    play(p, "drops 1; ran;");
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
    play(p, "11 begins;");
    expect_no_turn(p);
    p->meanwhile = expect_no_turn; /* inside the run of 11 */
    play(p, "11 returns;");
    assert_true(execution_order_host_is_current(p->order, &clock));
    assert_false(execution_clock_has(&clock, find_run(p, 11)->timestamp));
    execution_order_set_unknown(p->order, ORDER_UNKNOWN_DEVICE_LOST);
    expect_no_turn(p);
}

PROGRAM_TEST(host_work_that_fails_drops_nothing)
{
    play(p,
         "work 90 begins; 10 begins; 90 failed; drops 0; 10 returns; ran 10; 10 checked; begun 1;"
         "failures 1;");
    p->skip_name = 91;
    struct submission *work = submission_begin(p->order, SUBMIT_HOST_WORK, VK_NULL_HANDLE);
    call_add_batch(work, &(struct call){.name = 91});
    assert_true(submission_prepare(work));
    submission_finish(work, VK_ERROR_VALIDATION_FAILED_EXT);
    work = submission_begin(p->order, SUBMIT_HOST_WORK, VK_NULL_HANDLE);
    call_add_batch(work, &(struct call){.name = 92});
    submission_set_skip(work);
    assert_true(submission_prepare(work));
    submission_finish(work, VK_ERROR_VALIDATION_FAILED_EXT);
    play(p, "checks 4; drops 0; begun 1; ran 10;");
}

/* A caller that goes on with a skipped call still owns the submission: no other call gets it. */
PROGRAM_TEST(a_skipped_submission_lives_until_it_is_finished)
{
    p->skip_name = 91;
    struct submission *skipped = submission_begin(p->order, SUBMIT_HOST_WORK, VK_NULL_HANDLE);
    call_add_batch(skipped, &(struct call){.name = 91});
    assert_true(submission_prepare(skipped));
    struct submission *other = submission_begin(p->order, SUBMIT_COMMANDS, QUEUE(1));
    assert_ptr_not_equal(other, skipped);
    call_add_batch(other, &(struct call){.name = 10});
    assert_false(submission_prepare(other));
    submission_finish(skipped, VK_SUCCESS);
    submission_finish(other, VK_SUCCESS);
    play(p, "ran 10; begun 0; failures 0;");
}
