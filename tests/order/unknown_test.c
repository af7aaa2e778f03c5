/* SPDX-License-Identifier: Apache-2.0 */
/* What makes the order partly or wholly unknown. */
#include "program.h"
#include "src/state/order/records.h"

static void expect_lost(const struct program *p, enum order_unknown_reason reason)
{
    assert_int_equal(p->losses, 1);
    assert_int_equal(p->unknown_reason, reason);
}

PROGRAM_TEST(a_lost_device_loses_the_order)
{
    play(p, "timeline S; 10; 20 waits S=1; 30 begins; 40 begins; 11 loses;");
    expect_lost(p, ORDER_UNKNOWN_DEVICE_LOST);
    play(p, "30 returns;");
    submission_finish(p->under_way[40], VK_ERROR_DEVICE_LOST); /* again: 20 is released once */
    assert_int_equal(p->captured, 0);
    assert_null(submission_begin(p->order, SUBMIT_COMMANDS, QUEUE(1)));
    play(p, "12; host signals S=1; idle; ran 10;");
}

PROGRAM_TEST(two_calls_on_one_queue_lose_the_order)
{
    play(p, "10 begins; 11 begins; 11 returns; 10 returns; ran;");
    expect_lost(p, ORDER_UNKNOWN_RACING_THREADS);
}

PROGRAM_TEST(too_many_queues_lose_the_order)
{
    play(p, "shared S;");
    for (uint32_t queue = 1; queue < EXECUTION_QUEUES; queue++)
        SUBMIT(p, .queue = queue, .name = queue, .wait = {{queue == 1 ? S : 0, 1}});
    assert_int_equal(p->losses, 0);
    play(p, "bind 41;"); /* no number is left for its bindings: their order is unknown */
    assert_int_equal(p->losses, 0);
    assert_int_equal(p->run_count, EXECUTION_QUEUES);
    SUBMIT(p, .queue = EXECUTION_QUEUES, .name = 99);
    expect_lost(p, ORDER_UNKNOWN_TOO_MANY_QUEUES);
}

TEST(a_missing_order_is_accepted)
{
    struct execution_clock clock;
    struct program p = {0};
    play(&p, "timeline S; 10 waits S=1 fence F; sees F; idle; resets F;");
    execution_order_run(p.order);
    execution_order_host_clock(p.order, &clock);
    assert_int_equal(clock.queues, 0);
    program_stop(&p);
}

/* If a semaphore has many signals, the older half counts as over. */
TEST(test_old_signals_are_dropped)
{
    const struct execution_clock none = {0};
    const struct semaphore_signal *signal;
    struct semaphore_clock semaphore = {.timeline = true};
    for (uint64_t value = 1; value <= SEMAPHORE_SIGNALS + 1; value++) {
        assert_true(semaphore_clock_announce(&semaphore, value, value, &none));
        semaphore_clock_set(&semaphore, value, &none, &none, &none, timestamp_never());
        semaphore_clock_publish(&semaphore, value, &none);
    }
    for (uint64_t value = 1; value <= SEMAPHORE_SIGNALS + 1; value++) {
        assert_int_equal(semaphore_clock_wait(&semaphore, value, NULL, &signal), SEMAPHORE_REACHED);
        assert_int_equal(signal != NULL, value > SEMAPHORE_SIGNALS / 2);
    }
    semaphore_clock_release(&semaphore);
}

/* ---- what others signal */

/* Anybody may have signalled what 21 waits for. */
SCRIPT_TEST(a_foreign_timeline_leaves_predecessors_unknown,
            "fence F; shared S; binary T; 10 signals S=1; 20; 21 waits S=1 signals T fence F; 22;"
            "30 waits T; 40; 21 not after 10; 20 known; 40 known; 21 unknown; 22 unknown;"
            "30 unknown; sees F; 23; 31; 23 known; 31 known; 24 waits S=2; 32; 24 unknown;"
            "32 known;")

/* Nothing signalled 4. */
SCRIPT_TEST(a_foreign_value_that_the_host_saw_is_no_riddle,
            "timeline S; 10 waits S=5; ran; sees S=4; ran 10; 10 unknown; 20 waits S=4; 20 known;"
            "losses 0;")

PROGRAM_TEST(foreign_binary_semaphores_bring_no_order)
{
    play(p, "binary S; 10 signals S;");
    execution_order_set_semaphore_foreign(p->order, SEMAPHORE(S)); /* imported */
    play(p, "20 waits S; 20 not after 10; 20 known;");
}

PROGRAM_TEST(foreign_fences_show_nothing)
{
    execution_order_add_fence(p->order, FENCE(F), true, false);
    play(p, "fence G; 10 fence F; 11 fence G;");
    execution_order_set_fence_foreign(p->order, FENCE(G));
    play(p, "sees F; sees G; 20; 20 not after 10;");
}

PROGRAM_TEST(bindings_that_wait_for_others_lose_the_order)
{
    play(p, "shared S; bind 0 on 1 waits S=1;");
    expect_lost(p, ORDER_UNKNOWN_TOO_MANY_WAITS);
}

/* Then the wait is over for a reason that isn't known. */
SCRIPT_TEST(a_semaphore_may_be_destroyed_while_it_is_waited_for,
            "timeline S; 10 waits S=1 signals S=2; destroys S; ran 10; 10 unknown;")
