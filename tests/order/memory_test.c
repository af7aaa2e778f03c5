/* SPDX-License-Identifier: Apache-2.0 */
/* What the order costs: no allocation once warm, bounded memory, few steps a batch; and what
 * happens without memory. */
#include <inttypes.h>

#include "order.h"
#include "src/state/order/records.h"
#include "tests/fixture/scarce_memory.h"
#include "tests/unit/steps.h"

enum { RUNS = 512, OPERATIONS = 2 };
enum { S = 1, T = 2, F = 3 }; /* a timeline, a binary semaphore, a fence */

/* A consumer of the order, which keeps what has run. */
struct program {
    struct execution_order *order;
    struct run {
        uint32_t name; /* number of its command buffer */
        struct timestamp timestamp;
        struct execution_clock clock;
        bool predecessors_known;
    } runs[RUNS];
    uint32_t run_count, losses, captured; /* captured and not released */
    enum order_unknown_reason unknown_reason;
};

static void *capture(void *user, VkCommandBuffer command_buffer)
{
    ((struct program *)user)->captured++;
    return command_buffer;
}

static void release(void *user, void *captured)
{
    ((struct program *)user)->captured--;
}

static void run(void *user, struct order_batch *batch)
{
    struct program *program = user;
    assert_true(program->run_count < RUNS);
    struct run *added = &program->runs[program->run_count++];
    *added = (struct run){.timestamp = batch->timestamp,
                          .predecessors_known = batch->predecessors_known};
    if (batch->command_count)
        added->name = (uint32_t)(uintptr_t)batch->commands[0].captured;
    execution_clock_copy(&added->clock, &batch->clock);
}

static void order_unknown(void *user, enum order_unknown_reason why)
{
    struct program *program = user;
    program->losses++;
    program->unknown_reason = why;
}

static void program_start(struct program *program)
{
    *program = (struct program){0};
    const struct execution_hooks hooks = {.user = program, .capture = capture, .release = release};
    assert_int_equal(execution_order_create(&program->order, &hooks), VK_SUCCESS);
    execution_order_add_consumer(
        program->order,
        (struct batch_consumer){.user = program, .run = run, .order_unknown = order_unknown});
    execution_order_add_semaphore(program->order, SEMAPHORE(S), VK_SEMAPHORE_TYPE_TIMELINE, 0,
                                  false);
    execution_order_add_semaphore(program->order, SEMAPHORE(T), VK_SEMAPHORE_TYPE_BINARY, 0, false);
    execution_order_add_fence(program->order, FENCE(F), false, false);
}

static void program_stop(struct program *program)
{
    execution_order_destroy(program->order);
    assert_int_equal(program->captured, 0);
}

static struct program *program_open(void)
{
    static struct program program;
    program_start(&program);
    return &program;
}

/* A test of `p`, a program that has started; it stops after the test. */
#define PROGRAM_TEST(name) TEST_WITH(name, struct program *p, program_open, program_stop)

/* A call that submits one batch. Semaphores are numbers, 0 for none; the value counts for S. */
struct call {
    uint32_t queue, name, fence; /* name: of its command buffer */
    struct operation {
        uint32_t semaphore;
        uint64_t value;
    } wait[OPERATIONS], signal[OPERATIONS];
};

static void call_add_batch(struct submission *submission, const struct call *call)
{
    submission_add_batch(submission);
    for (uint32_t i = 0; i < OPERATIONS && call->wait[i].semaphore; i++)
        submission_add_wait(submission, SEMAPHORE(call->wait[i].semaphore), call->wait[i].value,
                            SCOPE_ALL);
    submission_add_commands(submission, COMMAND_BUFFER(call->name));
    for (uint32_t i = 0; i < OPERATIONS && call->signal[i].semaphore; i++)
        submission_add_signal(submission, SEMAPHORE(call->signal[i].semaphore),
                              call->signal[i].value, SCOPE_ALL);
}

static void submit(struct program *program, const struct call *call)
{
    struct submission *submission =
        submission_begin(program->order, SUBMIT_COMMANDS, QUEUE(call->queue));
    call_add_batch(submission, call);
    finish_batches(submission, call->fence);
}
#define SUBMIT(program, ...) submit(program, &(struct call){__VA_ARGS__})

static void signal_on_host(struct program *program, uint64_t value)
{
    struct submission *submission =
        submission_begin(program->order, SUBMIT_HOST_SIGNAL, VK_NULL_HANDLE);
    submission_add_batch(submission);
    submission_add_signal(submission, SEMAPHORE(S), value, SCOPE_ALL);
    finish_batches(submission, 0);
}

static const struct run *last_run(const struct program *program)
{
    assert_true(program->run_count > 0);
    return &program->runs[program->run_count - 1];
}

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
    uint64_t value = 0;
    for (int i = 0; i < 200; i++) {
        if (i == 100)
            memory_fail_after(0);
        frame(p);
        SUBMIT(p, .queue = 1, .name = 11, .signal = {{S, ++value}, {T}});
        SUBMIT(p, .queue = 2, .name = 20, .wait = {{S, value + 1}});
        SUBMIT(p, .queue = 1, .name = 12, .wait = {{T}}, .signal = {{S, ++value}});
        struct idle_wait wait;
        execution_order_start_idle(p->order, QUEUE(2), &wait);
        execution_order_observe_idle(p->order, &wait);
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
    for (uint64_t value = 1; value < 1000; value++) {
        SUBMIT(p, .queue = 1, .name = 10, .signal = {{S, value}});
        SUBMIT(p, .queue = 2, .name = 20, .wait = {{S, value}});
        frame(p);
        assert_true(signals_kept(p, S) <= 2);
    }
    SUBMIT(p, .queue = 3, .name = 30, .wait = {{S, 1}});
    assert_true(last_run(p)->predecessors_known);
}

PROGRAM_TEST(unobserved_signals_are_bounded)
{
    for (uint64_t value = 1; value <= 10000; value++) {
        SUBMIT(p, .queue = 1, .name = 10, .signal = {{S, value}});
        p->run_count = 0;
        assert_true(signals_kept(p, S) <= SEMAPHORE_SIGNALS);
    }
    SUBMIT(p, .queue = 2, .name = 20, .wait = {{S, 10000}});
    const struct execution_clock late = last_run(p)->clock;
    SUBMIT(p, .queue = 3, .name = 30, .wait = {{S, 1}});
    const struct execution_clock early = last_run(p)->clock;
    SUBMIT(p, .queue = 1, .name = 11);
    const uint32_t queue = last_run(p)->timestamp.queue;
    assert_true(execution_clock_has(&late, (struct timestamp){queue, 10000}));
    assert_false(execution_clock_has(&early, (struct timestamp){queue, 1}));
}

PROGRAM_TEST(binary_semaphores_without_waits_are_bounded)
{
    for (int i = 0; i < 1000; i++) {
        SUBMIT(p, .queue = 1, .name = 10, .signal = {{T}});
        p->run_count = 0;
    }
    assert_true(signals_kept(p, T) <= SEMAPHORE_SIGNALS);
}

PROGRAM_TEST(held_batches_are_bounded)
{
    for (int i = 0; i < EXECUTION_HELD_BATCHES; i++)
        SUBMIT(p, .queue = 1, .name = 10, .wait = {{S, 1}});
    assert_int_equal(p->losses, 0);
    SUBMIT(p, .queue = 1, .name = 10, .wait = {{S, 1}});
    assert_int_equal(p->losses, 1);
    assert_int_equal(p->captured, 0);
    assert_int_equal(p->unknown_reason, ORDER_UNKNOWN_TOO_MANY_WAITS);
}

static void play_all(struct program *program)
{
    SUBMIT(program, .queue = 2, .name = 20, .wait = {{S, 5}}, .signal = {{T}}, .fence = F);
    SUBMIT(program, .queue = 3, .name = 30, .wait = {{T}});
    for (uint64_t value = 1; value <= 5; value++)
        SUBMIT(program, .queue = 1, .name = 10, .signal = {{S, value}});
    struct submission *call = submission_begin(program->order, SUBMIT_COMMANDS, QUEUE(1));
    for (uint32_t name = 40; name < 50; name++)
        call_add_batch(call, &(struct call){.name = name, .wait = {{S, 1}, {S, 2}}});
    finish_batches(call, 0);
    execution_order_observe_fence(program->order, FENCE(F));
    signal_on_host(program, 6);
    SUBMIT(program, .queue = 4, .name = 60);
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
    uint64_t start = steps_so_far;
    for (int i = 0; i < CALLS; i++) {
        call(program, ++*value);
        program->run_count = 0;
    }
    return (steps_so_far - start) / CALLS;
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
    finish_batches(call, F);
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
    assert_cost(p, "alone", one_batch, 1, 600);
    assert_cost(p, "with semaphores", with_semaphores, 2, 1300);
    assert_cost(p, "in calls of 100", many_batches, 100, 300);
}
