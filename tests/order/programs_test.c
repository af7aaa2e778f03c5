/* SPDX-License-Identifier: Apache-2.0 */
/* Programs of submits whose order is plain to see. */
#include "program.h"

PROGRAM_TEST(a_queue_executes_in_submission_order)
{
    play(p, "10; 11; 11 after 10; 10 not after 11 10; 10 checked; 10 known;");
    assert_ptr_equal(p->runs[0].queue, QUEUE(1));
    assert_int_equal(p->runs[0].command_count, 1);
}

SCRIPT_TEST(two_queues_have_no_order,
            "10; 20; 11; 20 not after 10; 10 not after 20; 11 not after 20;")

SCRIPT_TEST(a_binary_semaphore_orders,
            "binary S; 10; 11 signals S; 12; 20; 21 waits S; 22;"
            "21 after 11 10; 22 after 11; 21 not after 12; 20 not after 10;")

/* Each wait consumes one signal; one that has none is taken for someone else's. */

SCRIPT_TEST(a_wait_consumes_the_signal,
            "binary S; 10 signals S; 20 waits S; 30 waits S; 20 after 10; 30 not after 10;"
            "31 signals S; 40 waits S; 40 after 31 30; 40 not after 10;")

PROGRAM_TEST(presentation_and_acquisition_bring_no_order)
{
    play(p, "binary S; 10 signals S;");
    execution_order_forget_signal(p->order, SEMAPHORE(S)); /* presented */
    execution_order_forget_signal(p->order, SEMAPHORE(S)); /* acquired */
    play(p, "20 waits S; 20 not after 10; 20 known;");
}

SCRIPT_TEST(unknown_semaphores_bring_no_order, "10 signals S; 20 waits S T=7; 20 not after 10;")

SCRIPT_TEST(order_is_transitive_over_three_queues,
            "binary S T; 10 signals S; 20 waits S signals T; 30 waits T; 30 after 20 10;")

/* The earliest signal that reaches the value, not the last one. */

SCRIPT_TEST(
    a_timeline_wait_follows_the_earliest_signal,
    "timeline S=3; 10 signals S=5; 11 signals S=8; 20 waits S=3; 30 waits S=4; 40 waits S=6;"
    "20 not after 10; 30 after 10; 30 not after 11; 40 after 11 10;")

SCRIPT_TEST(a_wait_before_its_signal_holds_the_queue_back,
            "timeline S; 20 waits S=1; 21; ran; 10; ran 10; 11 signals S=1; ran 10 11 20 21;"
            "20 after 11; 21 after 10; 20 unchecked; 20 known; 11 checked;")

/* What one release signals releases more: 3 waits for 2, which waits for 1. */

SCRIPT_TEST(releases_go_on,
            "timeline S T; 30 waits T=1 S=1; 20 waits S=1 signals T=1;"
            "10 signals S=1; ran 10 20 30; 30 after 20 10; 20 after 10;")

/* Waits and signals at stages that do no work on acceleration structures: 20 may begin before its
 * wait is over, the signal that 30 waits for may come before 10 ends, all of 20 has executed before
 * 40, its wait too, but only its builds before 50. */

SCRIPT_TEST(stages_limit_what_a_semaphore_orders,
            "binary S T U F G; 10 signals S T/nothing; 20 waits S/nothing signals U F/builds;"
            "30 waits T; 40 waits U; 50 waits F/builds; 20 not after 10; 30 not after 10;"
            "40 after 20 10; 50 after 20; 50 not after 10;")

SCRIPT_TEST(batches_of_one_call_may_use_each_other,
            "binary S; timeline T; 10 signals S T=1 then 11 waits S T=1 signals S then 12 waits S;"
            "checks 3; ran 10 11 12; 12 after 10 11;")

SCRIPT_TEST(handles_are_reused,
            "timeline S; 10 signals S=5; destroys S; timeline S; 20 waits S=5; ran 10;"
            "30 signals S=5; 20 after 30; 20 not after 10;"
            "destroys S; binary S; 40 waits S; 40 not after 30;")
