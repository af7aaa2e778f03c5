/* SPDX-License-Identifier: Apache-2.0 */
/* Which signal ends a wait, and which one a signal includes, by their numbers. */
#include "program.h"
#include "src/state/order/records.h"

/* The host has observed nothing of 10, whose signal carries nothing. */
SCRIPT_TEST(signals_at_other_stages_are_known,
            "binary S T; fence F; 10 signals S/nothing; 20 waits S; 20 ends 10;"
            "11 signals T/nothing fence F; sees F; 21 waits T; 21 met;")

PROGRAM_TEST(a_value_that_the_host_observed_is_met)
{
    create_timeline(p, S, 0);
    SUBMIT(p, .queue = 1, .name = 10, .signal = {{S, 1, REACH_NOTHING}});
    play(p, "20 waits S=1; 20 ends 10; sees S=1; 21 waits S=1; 21 met;");
}

PROGRAM_TEST(held_batches_follow_the_signal_of_the_host)
{
    play(p, "timeline S; 10; idle; 20 waits S=1; host signals S=1;");
    assert_int_equal(find_operation(p, 20, false)->signal, 1);
    assert_false(find_operation(p, 20, false)->is_met);
}

/* ---- what is unknown */

PROGRAM_TEST(many_signals_leave_old_ones_unknown)
{
    create_timeline(p, S, 1);
    for (uint64_t value = 2; value <= 2 + SEMAPHORE_SIGNALS; value++)
        SUBMIT(p, .queue = 1, .name = (uint32_t)value + 100, .signal = {{S, value}});
    play(p,
         "20 waits S=2; 21 waits S=40; 22 waits S=1; 20 ends nothing; 21 ends 140; 22 met;"
         "140 behind 139; 166 behind 165; idle; 23 waits S=2; 23 met;");
}

PROGRAM_TEST(a_signal_includes_one_that_was_dropped)
{
    create_binary(p, S);
    for (uint32_t i = 0; i <= SEMAPHORE_SIGNALS; i++)
        SUBMIT(p, .queue = 1, .name = 101 + i, .signal = {{S}});
    play(p, "20 waits S; 11 signals S; 20 ends 165; 11 behind 165;");
}

/* Another process may signal it. */
SCRIPT_TEST(shared_semaphores_are_unknown,
            "shared S; 10 signals S=1; 20 waits S=1; 21 waits S=0; 20 ends nothing;"
            "21 ends nothing; 10 behind nothing; sees S=1; 22 waits S=1; 22 ends nothing;")

SCRIPT_TEST(destroyed_semaphores_are_unknown,
            "timeline S; 10 waits S=1; destroys S; 10 ends nothing; 20 waits S=1;"
            "20 ends nothing;")

PROGRAM_TEST(presented_and_acquired_semaphores_are_unknown)
{
    play(p, "binary S; 10 signals S;");
    execution_order_forget_signal(p->order, SEMAPHORE(S)); /* presented */
    execution_order_forget_signal(p->order, SEMAPHORE(S)); /* acquired */
    play(p, "20 waits S; 20 ends nothing; idle; 21 waits S; 21 ends nothing;");
}

/* The order gets no bindings without work, so when they are complete is unknown. */
PROGRAM_TEST(bindings_are_met_once_their_value_is_observed)
{
    play(p, "timeline S; bind 0 on 1 signals S=1; idle; 20 waits S=1; sees S=1; 21 waits S=1;");
    assert_int_equal(find_operation(p, 20, false)->signal, 1);
    play(p, "21 met;");
}

/* ---- calls that fail */

SCRIPT_TEST(signals_of_failed_calls_are_gone,
            "timeline S; binary T; 10 signals S=1 fails; 20 waits S=1; ran; 11 signals S=1;"
            "20 ends 11; 11 behind nothing; 12 signals S=2 fails; 13 signals S=2; 13 behind 11;"
            "14 signals T; 15 waits T fails; 30 waits T; 30 ends 14;")

PROGRAM_TEST(numbers_are_never_reused)
{
    play(p,
         "timeline S T; 10 signals S=1; 11 signals S=2 fails; 20 signals T=1;"
         "destroys S; timeline S; 12 signals S=1;");
    assert_int_equal(find_operation(p, 10, true)->signal, 1);
    assert_int_equal(find_operation(p, 20, true)->signal, 3);
    assert_int_equal(find_operation(p, 12, true)->signal, 4);
}
