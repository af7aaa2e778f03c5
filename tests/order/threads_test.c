/* SPDX-License-Identifier: Apache-2.0 */
/* A thread that observes work which another one is about to run. Other threads: tests/execution. */
#include <stdatomic.h>

#include "order.h"
#include "src/platform/clock.h"
#include "src/platform/threads.h"

struct slow_machine {
    struct execution_order *order;
    atomic_bool is_running, was_observed;
    atomic_uint runs;
};

/* The first batch runs until the others were observed; each takes a while after that. */
static void run_slowly(void *user, struct order_batch *batch)
{
    struct slow_machine *machine = user;
    atomic_store(&machine->is_running, true);
    while (!atomic_load(&machine->was_observed))
        clock_yield();
    clock_sleep(3000000);
    if (batch->work == WORK_OF_QUEUE)
        atomic_fetch_add(&machine->runs, 1);
    execution_order_await_observed(machine->order);
}

static void submit_to(struct execution_order *order, uint32_t queue)
{
    struct submission *call = submission_begin(order, SUBMIT_COMMANDS, QUEUE(queue));
    submission_add_batch(call);
    submission_add_commands(call, COMMAND_BUFFER(queue));
    finish_batches(call, queue);
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
    for (int i = 1; i < 30; i++) /* more often than the wait has steps */
        submit_to(machine.order, 2);
    assert_int_equal(atomic_load(&machine.runs), 0);
    execution_order_observe_fence(machine.order, FENCE(2));
    atomic_store(&machine.was_observed, true);
    execution_order_await_observed(machine.order);
    assert_int_equal(atomic_load(&machine.runs), 30);
    pthread_join(thread, NULL);
    execution_order_destroy(machine.order);
}
