/* SPDX-License-Identifier: Apache-2.0 */
/* What the order costs: no allocation once warm, bounded memory, few steps a batch; and what
 * happens without memory. */
#include <inttypes.h>

#include "program.h"
#include "src/state/order/records.h"
#include "tests/fixture/scarce_memory.h"
#include "tests/unit/steps.h"

/* A frame as applications make them: a batch, its fence waited for and reset. */
static void frame(struct program *program)
{
    SUBMIT(program, .queue = 1, .name = 10, .fence = F);
    execution_order_observe_fence(program->order, FENCE(F));
    execution_order_reset_fence(program->order, FENCE(F));
    program->run_count = 0;
}

PROGRAM_TEST(a_warm_order_allocates_nothing)
{
    play(p, "fence F; timeline S; binary T;");
    uint64_t value = 0;
    for (int i = 0; i < 200; i++) {
        if (i == 100)
            memory_fail_after(0);
        frame(p);
        SUBMIT(p, .queue = 1, .name = 11, .signal = {{S, ++value}, {T}});
        SUBMIT(p, .queue = 2, .name = 20, .wait = {{S, value + 1}});
        SUBMIT(p, .queue = 1, .name = 12, .wait = {{T}}, .signal = {{S, ++value}});
        wait_idle(p, 2);
        p->run_count = 0;
    }
    assert_false(memory_fail_no_more());
    assert_int_equal(p->losses, 0);
}

static uint32_t signals_kept(const struct program *program, uint32_t semaphore)
{
    return execution_order_semaphore(program->order, SEMAPHORE(semaphore))->count;
}

/* The host sees every frame's fence, but never asks for the semaphore. */
PROGRAM_TEST(signals_that_the_host_saw_are_dropped)
{
    play(p, "fence F; timeline S;");
    for (uint64_t value = 1; value < 1000; value++) {
        SUBMIT(p, .queue = 1, .name = 10, .signal = {{S, value}});
        SUBMIT(p, .queue = 2, .name = 20, .wait = {{S, value}});
        frame(p);
        assert_true(signals_kept(p, S) <= 2);
    }
    play(p, "30 waits S=1; 30 known;");
}

PROGRAM_TEST(unobserved_signals_are_bounded)
{
    create_timeline(p, S, 0);
    for (uint64_t value = 1; value <= 10000; value++) {
        SUBMIT(p, .queue = 1, .name = 10, .signal = {{S, value}});
        p->run_count = 0;
        assert_true(signals_kept(p, S) <= SEMAPHORE_SIGNALS);
    }
    play(p, "20 waits S=10000; 30 waits S=1; 11;");
    const struct timestamp last = {find_run(p, 11)->timestamp.queue, 10000};
    assert_true(execution_clock_has(&find_run(p, 20)->clock, last));
    assert_false(execution_clock_has(&find_run(p, 30)->clock, (struct timestamp){last.queue, 1}));
}

PROGRAM_TEST(binary_semaphores_without_waits_are_bounded)
{
    create_binary(p, S);
    for (int i = 0; i < 1000; i++) {
        play(p, "10 signals S;");
        p->run_count = 0;
    }
    assert_true(signals_kept(p, S) <= SEMAPHORE_SIGNALS);
}

PROGRAM_TEST(held_batches_are_bounded)
{
    create_timeline(p, S, 0);
    for (int i = 0; i < EXECUTION_HELD_BATCHES; i++)
        play(p, "10 waits S=1;");
    play(p, "losses 0; 10 waits S=1; losses 1; captured 0;");
    assert_int_equal(p->unknown_reason, ORDER_UNKNOWN_TOO_MANY_WAITS);
}

static void play_all(struct program *program)
{
    play(program,
         "fence F; timeline S; binary T; 20 waits S=5 signals T fence F; 30 waits T;"
         "10 signals S=1; 10 signals S=2; 10 signals S=3; 10 signals S=4; 10 signals S=5;");
    struct submission *call = submission_begin(program->order, SUBMIT_COMMANDS, QUEUE(1));
    for (uint32_t name = 40; name < 50; name++)
        call_add_batch(call, &(struct call){.name = name, .wait = {{S, 1}, {S, 2}}});
    finish_batches(call, 0, VK_SUCCESS);
    play(program, "sees F; host signals S=6; 60 on 4;");
}

TEST(without_memory_the_order_is_lost)
{
    struct program complete, p;
    program_start(&complete);
    play_all(&complete);
    assert_int_equal(complete.run_count, 18);
    program_stop(&complete);

    bool failed = true;
    for (int count = 0; failed; count++) {
        program_start(&p);
        memory_fail_after(count);
        play_all(&p);
        failed = memory_fail_no_more();
        assert_int_equal(p.losses, failed);
        assert_true(!failed || p.unknown_reason == ORDER_UNKNOWN_OUT_OF_MEMORY);
        assert_true(failed ? p.run_count < complete.run_count : p.run_count == complete.run_count);
        for (uint32_t i = 0; i < p.run_count; i++)
            assert_int_equal(p.runs[i].name, complete.runs[i].name);
        program_stop(&p);
    }
    memory_fail_after(0);
    struct execution_order *none;
    const struct execution_hooks hooks = {0};
    assert_int_equal(execution_order_create(&none, &hooks), VK_ERROR_OUT_OF_HOST_MEMORY);
    assert_true(memory_fail_no_more());
    assert_null(none);
}

enum { CALLS = 2000, ROUNDS = 5 };

/* Steps of a call, hooks included. */
static uint64_t steps_of_calls(struct program *program, void (*call)(struct program *, uint64_t),
                               uint64_t *value)
{
    uint64_t start = steps_so_far();
    for (int i = 0; i < CALLS; i++) {
        call(program, ++*value);
        program->run_count = 0;
    }
    return (steps_so_far() - start) / CALLS;
}

static void one_batch(struct program *program, uint64_t value)
{
    SUBMIT(program, .queue = 1, .name = 10, .fence = F);
}

static void with_semaphores(struct program *program, uint64_t value)
{
    SUBMIT(program, .queue = 1, .name = 10, .signal = {{S, value}, {T}});
    SUBMIT(program, .queue = 2, .name = 20, .wait = {{T}, {S, value}}, .fence = F);
}

static void many_batches(struct program *program, uint64_t value)
{
    struct submission *call = submission_begin(program->order, SUBMIT_COMMANDS, QUEUE(1));
    for (uint32_t i = 0; i < 100; i++)
        call_add_batch(call, &(struct call){.name = 10});
    finish_batches(call, F, VK_SUCCESS);
}

/* However many came before. */
static void assert_cost(struct program *program, const char *name,
                        void (*call)(struct program *, uint64_t), uint64_t batches, uint64_t most)
{
    static uint64_t value;
    for (int round = 0; round < ROUNDS; round++) {
        uint64_t steps = steps_of_calls(program, call, &value) / batches;
        print_message("%s, round %d: %" PRIu64 " steps a batch\n", name, round, steps);
        assert_true(steps > 0);
        assert_true(steps <= most);
    }
}

PROGRAM_TEST(a_batch_costs_few_steps)
{
    play(p, "fence F; timeline S; binary T;");
    assert_cost(p, "alone", one_batch, 1, 600);
    assert_cost(p, "with semaphores", with_semaphores, 2, 1300);
    assert_cost(p, "in calls of 100", many_batches, 100, 300);
}
