/* SPDX-License-Identifier: Apache-2.0 */
/* Many threads, each with a queue, submit at once and wait for each other's timelines; a consumer
 * plays the device: a batch has executed when it has run. It keeps some batches for a while. */
#include <stdatomic.h>

#include "order.h"
#include "src/platform/clock.h"
#include "src/platform/threads.h"
#include "tests/unit/random.h"

enum { THREADS = 4, CALLS = 1000 };

struct machine {
    struct execution_order *order;
    atomic_uint in_hook, runs, unknown, losses, retired;
    struct order_batch *kept; /* used in hooks only */
    atomic_int captured;
    uint64_t counts[EXECUTION_QUEUES]; /* that have run; used in hooks only */
    atomic_ullong executed[THREADS];   /* calls of each thread */
    uint64_t seed;
};

struct worker {
    struct machine *machine;
    uint32_t index;
};

static void enter(struct machine *machine)
{
    assert_int_equal(atomic_fetch_add(&machine->in_hook, 1), 0);
}

static void leave(struct machine *machine)
{
    atomic_fetch_sub(&machine->in_hook, 1);
}

static void *capture(void *user, VkCommandBuffer command_buffer)
{
    atomic_fetch_add(&((struct machine *)user)->captured, 1);
    return command_buffer;
}

static void release(void *user, void *captured)
{
    atomic_fetch_sub(&((struct machine *)user)->captured, 1);
}

static void expect_predecessors(const struct machine *machine, const struct order_batch *batch)
{
    for (uint32_t i = 0; i < batch->clock.queues; i++)
        if (i != batch->timestamp.queue)
            assert_true(batch->clock.counts[i] <= machine->counts[i]);
}

static void check(void *user, struct order_batch *batch)
{
    struct machine *machine = user;
    enter(machine);
    expect_predecessors(machine, batch);
    leave(machine);
}

static void run(void *user, struct order_batch *batch)
{
    struct machine *machine = user;
    enter(machine);
    expect_predecessors(machine, batch);
    if (batch->work == WORK_BEGINS) {
        leave(machine);
        return;
    }
    assert_int_equal(++machine->counts[batch->timestamp.queue], batch->timestamp.count);
    if (batch->work == WORK_SYNC) {
        leave(machine);
        return;
    }
    atomic_fetch_add(&machine->runs, 1);
    if (!batch->predecessors_known)
        atomic_fetch_add(&machine->unknown, 1);
    if (batch->command_count)
        atomic_fetch_add(&machine->executed[(uintptr_t)batch->commands[0].captured - 1], 1);
    if (machine->kept)
        order_batch_let_go(machine->kept, USES_INPUTS);
    order_batch_keep(batch, USES_INPUTS, NULL);
    machine->kept = batch;
    leave(machine);
}

static void retire(void *user, struct order_batch *batch)
{
    assert_false(order_batch_is_kept(batch, USES_INPUTS));
    atomic_fetch_add(&((struct machine *)user)->retired, 1);
}

static void undo(void *user, struct order_batch *batch)
{
    enter(user);
    leave(user);
}

static void order_unknown(void *user, enum order_unknown_reason why)
{
    atomic_fetch_add(&((struct machine *)user)->losses, 1);
}

/* Its own timeline is signalled by each call; sometimes it waits for another's next value, which
 * may not have been submitted, but never for more than its own: so there is no deadlock. */
static void submit_one(struct machine *machine, struct random *random, uint32_t index,
                       uint64_t value)
{
    struct submission *call = submission_begin(machine->order, SUBMIT_COMMANDS, QUEUE(index + 1));
    submission_add_batch(call);
    uint32_t other = random_below(random, THREADS);
    if (other != index)
        submission_add_wait(call, SEMAPHORE(other + 1), other < index ? value : value - 1,
                            SCOPE_ALL);
    submission_add_commands(call, COMMAND_BUFFER(index + 1));
    submission_add_signal(call, SEMAPHORE(index + 1), value, SCOPE_ALL);
    submission_set_fence(call, FENCE(index + 1));
    bool fails = random_one_in(random, 16);
    assert_false(submission_prepare(call));
    submission_finish(call, fails ? VK_ERROR_OUT_OF_HOST_MEMORY : VK_SUCCESS);
    if (fails)
        submit_one(machine, random, index, value);
}

/* What has executed can be seen. */
static void see_one(struct machine *machine, struct random *random, uint32_t index, uint64_t value)
{
    uint32_t other = random_below(random, THREADS);
    uint64_t executed = atomic_load(&machine->executed[other]);
    execution_order_observe_semaphore(machine->order, SEMAPHORE(other + 1), executed, false);
    if (atomic_load(&machine->executed[index]) != value)
        return;
    execution_order_observe_fence(machine->order, FENCE(index + 1));
    struct idle_wait wait;
    execution_order_start_idle(machine->order, QUEUE(index + 1), &wait);
    execution_order_observe_idle(machine->order, &wait);
}

static void work_on_host(struct machine *machine)
{
    struct submission *work = submission_begin(machine->order, SUBMIT_HOST_WORK, VK_NULL_HANDLE);
    submission_add_batch(work);
    finish_batches(work, 0);
}

static void *submit_many(void *context)
{
    const struct worker *worker = context;
    struct machine *machine = worker->machine;
    struct random random = {machine->seed + worker->index};
    for (uint64_t value = 1; value <= CALLS; value++) {
        execution_order_reset_fence(machine->order, FENCE(worker->index + 1));
        submit_one(machine, &random, worker->index, value);
        if (random_one_in(&random, 4))
            see_one(machine, &random, worker->index, value);
        if (random_one_in(&random, 16))
            work_on_host(machine);
    }
    return NULL;
}

TEST(threads_submit_at_once)
{
    static struct machine machine;
    struct worker workers[THREADS];
    machine.seed = random_of("order_threads").state;
    const struct execution_hooks hooks = {
        .user = &machine, .follows_host = true, .capture = capture, .release = release};
    assert_int_equal(execution_order_create(&machine.order, &hooks), VK_SUCCESS);
    execution_order_add_consumer(machine.order,
                                 (struct batch_consumer){.user = &machine,
                                                         .check = check,
                                                         .undo = undo,
                                                         .run = run,
                                                         .retire = retire,
                                                         .order_unknown = order_unknown});
    for (uint32_t i = 1; i <= THREADS; i++) {
        execution_order_add_semaphore(machine.order, SEMAPHORE(i), VK_SEMAPHORE_TYPE_TIMELINE, 0,
                                      false);
        execution_order_add_fence(machine.order, FENCE(i), false, false);
    }
    for (uint32_t i = 0; i < THREADS; i++)
        workers[i] = (struct worker){&machine, i};
    unit_test_run_threads(THREADS, submit_many, workers, sizeof(workers[0]));

    assert_int_equal(atomic_load(&machine.losses), 0);
    for (uint32_t i = 0; i < THREADS; i++)
        assert_int_equal(atomic_load(&machine.executed[i]), CALLS);
    print_message("%u runs, %u with predecessors unknown\n", atomic_load(&machine.runs),
                  atomic_load(&machine.unknown));
    order_batch_let_go(machine.kept, USES_INPUTS);
    execution_order_destroy(machine.order);
    assert_true(atomic_load(&machine.retired) > THREADS * CALLS);
    assert_int_equal(atomic_load(&machine.captured), 0);
}

/* ---- a thread that observes work which another one is about to run */

struct slow_machine {
    struct execution_order *order;
    atomic_bool is_running, was_observed;
    atomic_uint runs;
};

/* The first batch runs until the second one was observed, and for a while after that. */
static void run_slowly(void *user, struct order_batch *batch)
{
    struct slow_machine *machine = user;
    atomic_store(&machine->is_running, true);
    while (!atomic_load(&machine->was_observed))
        clock_yield();
    if (!atomic_load(&machine->runs))
        clock_sleep(20000000);
    if (batch->work == WORK_OF_QUEUE)
        atomic_fetch_add(&machine->runs, 1);
    execution_order_await_observed(machine->order);
}

static void submit_to(struct execution_order *order, uint32_t queue)
{
    struct submission *call = submission_begin(order, SUBMIT_COMMANDS, QUEUE(queue));
    submission_add_batch(call);
    submission_add_commands(call, COMMAND_BUFFER(queue));
    submission_set_fence(call, FENCE(queue));
    assert_false(submission_prepare(call));
    submission_finish(call, VK_SUCCESS);
}

static void *submit_first(void *context)
{
    submit_to(((struct slow_machine *)context)->order, 1);
    return NULL;
}

TEST(observed_work_has_run)
{
    static struct slow_machine machine;
    const struct execution_hooks hooks = {.follows_host = true};
    pthread_t thread;
    assert_int_equal(execution_order_create(&machine.order, &hooks), VK_SUCCESS);
    execution_order_add_consumer(machine.order,
                                 (struct batch_consumer){.user = &machine, .run = run_slowly});
    execution_order_add_fence(machine.order, FENCE(2), false, false);
    assert_int_equal(pthread_create(&thread, NULL, submit_first, &machine), 0);
    while (!atomic_load(&machine.is_running))
        clock_yield();
    submit_to(machine.order, 2);
    assert_int_equal(atomic_load(&machine.runs), 0);
    execution_order_observe_fence(machine.order, FENCE(2));
    atomic_store(&machine.was_observed, true);
    execution_order_await_observed(machine.order);
    assert_int_equal(atomic_load(&machine.runs), 2);
    pthread_join(thread, NULL);
    execution_order_destroy(machine.order);
}
