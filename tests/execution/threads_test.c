/* SPDX-License-Identifier: Apache-2.0 */
/* Several threads submit, build on the host, and join what it deferred; run under the thread
 * sanitizer, too. Each has structures of its own, and plants a mistake now and then. */
#include <pthread.h>
#include <sched.h>
#include <stdatomic.h>

#include "machine.h"
#include "tests/state/unit_test.h"

enum { ROUNDS = 400, MISTAKES = 5 /* one in so many rounds */, JOINERS = 2 };

static struct platform platform;
static struct fixture fixture;
static struct machine machines[3];
static atomic_uint signalled; /* the value of the first machine's timeline */
static atomic_bool working;

static void play(struct machine *machine, const struct step *steps)
{
    for (; steps->action != ACTION_END_OF_PROGRAM; steps++)
        machine_step(machine, steps);
}

static enum build_shape shape_of(uint32_t round)
{
    return round % MISTAKES == MISTAKES - 1 ? BAD : GOOD;
}

/* ---- submitting, each thread to a queue of its own */

static void *submit_to_first(void *unused)
{
    for (uint32_t i = 0; i < ROUNDS; i++) {
        play(&machines[0], STEPS(RECORD_BUILD(A, X, shape_of(i)), UPDATE_XY(B), RUN(A), BATCH,
                                 WITH(B), SIGNAL_TO(0, i + 1), SUBMIT(0)));
        atomic_store(&signalled, i + 1);
        play(&machines[0], STEPS(WAIT_QUEUE(0), RESET(A), RESET(B)));
    }
    return NULL;
}

static void *submit_to_second(void *unused)
{
    for (uint32_t i = 0; i < ROUNDS; i++)
        play(&machines[1], STEPS(RECORD_BUILD(P, X, shape_of(i)), UPDATE_XY(R), RUN(P), RUN(R),
                                 WAIT_QUEUE(1), RESET(P), RESET(R)));
    return NULL;
}

/* Some of its batches wait for what the other thread signals next. */
static void *wait_for_first(void *unused)
{
    for (uint32_t i = 0; i < ROUNDS; i++) {
        const uint32_t value = atomic_load(&signalled) + i % 2;
        play(&machines[1],
             STEPS(RECORD_BUILD(P, X, shape_of(i)), UPDATE_XY(R), RUN(P), BATCH, WITH(R),
                   WAIT_FOR(0, value < ROUNDS ? value : ROUNDS), SUBMIT2(1)));
        while (atomic_load(&signalled) < value && atomic_load(&signalled) < ROUNDS)
            sched_yield();
        play(&machines[1], STEPS(WAIT_QUEUE(1), RESET(P), RESET(R)));
    }
    return NULL;
}

/* ---- on the host */

/* Who has learned that the operation is complete can rely on what it has built. */
static void *build_on_host(void *unused)
{
    struct machine *machine = &machines[2];
    for (uint32_t i = 0; i < ROUNDS; i++) {
        play(machine, STEPS(HOST_BUILD(W, GOOD), HOST_UPDATE(W, Z), HOST_CLONE(W, Z),
                            DEFERRED_BUILD(1, X, shape_of(i))));
        do
            play(machine, STEPS(ASK(1)));
        while (machine->result == VK_NOT_READY);
        play(machine, STEPS(HOST_UPDATE_XY));
    }
    atomic_store(&working, false);
    return NULL;
}

static void *join(void *unused)
{
    while (atomic_load(&working))
        fixture.vk.DeferredOperationJoinKHR(fixture.device, machines[2].operations[1]);
    return NULL;
}

/* ---- the tests */

static pthread_t start(void *(*run)(void *unused))
{
    pthread_t thread;
    assert_int_equal(pthread_create(&thread, NULL, run, NULL), 0);
    return thread;
}

static void open_machines(void)
{
    static const struct setup plain;
    if (platform.name == NULL)
        assert_null(platform_open(&platform, "null"));
    assert_null(fixture_open(&fixture, &platform, &plain));
    for (uint32_t i = 0; i < sizeof(machines) / sizeof(machines[0]); i++) {
        machine_open(&machines[i], &fixture, VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR);
        machines[i].good = machines[i].bad = shape_plain();
        machines[i].bad.max_vertex++;
    }
    atomic_store(&signalled, 0);
    atomic_store(&working, true);
}

/* Closes all. Every message is about a planted mistake. */
static uint32_t count_messages(void)
{
    const uint32_t count = fixture.messages.count;
    const uint32_t of_device = messages_count(
        &fixture.messages, "VUID-vkCmdBuildAccelerationStructuresKHR-pInfos-03764", NULL);
    const uint32_t of_host = messages_count(
        &fixture.messages, "VUID-vkBuildAccelerationStructuresKHR-pInfos-03764", NULL);
    print_message("%u by the device, %u by the host\n", of_device, of_host);
    assert_int_equal(of_device + of_host, count);
    for (uint32_t i = 0; i < sizeof(machines) / sizeof(machines[0]); i++)
        machine_close(&machines[i]);
    fixture_close(&fixture);
    return count;
}

TEST(threads_submit_and_build_at_once)
{
    open_machines();
    pthread_t threads[3 + JOINERS] = {start(submit_to_first), start(submit_to_second),
                                      start(build_on_host)};
    for (uint32_t i = 0; i < JOINERS; i++)
        threads[3 + i] = start(join);
    for (uint32_t i = 0; i < 3 + JOINERS; i++)
        pthread_join(threads[i], NULL);
    assert_int_equal(count_messages(), 3 * ROUNDS / MISTAKES);
}

/* Where calls under way may release others, the layer rather says nothing. */
TEST(threads_wait_for_each_other)
{
    open_machines();
    machines[1].timelines[0] = machines[0].timelines[0];
    pthread_t threads[] = {start(submit_to_first), start(wait_for_first)};
    for (uint32_t i = 0; i < sizeof(threads) / sizeof(threads[0]); i++)
        pthread_join(threads[i], NULL);
    const uint32_t count = count_messages();
    print_message("%u of %u mistakes told\n", count, 2 * ROUNDS / MISTAKES);
    assert_in_range(count, 1, 2 * ROUNDS / MISTAKES);
}
