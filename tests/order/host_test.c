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
    play(p, "checks 4; drops 1; ran 10; captured 0; 20 waits S; 20 after 10;");
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
