/* SPDX-License-Identifier: Apache-2.0 */
/* Several threads submit, build on the host, and join what it deferred; run under the thread
 * sanitizer, too. Each has structures of its own, and plants a mistake now and then. */
#include <pthread.h>
#include <sched.h>
#include <stdatomic.h>
#include <stdlib.h>

#include "tests/player/play.h"
#include "tests/unit/unit_test.h"

enum { ROUNDS = 400, MISTAKES = 5 /* one in so many rounds */, JOINERS = 2, RUNNERS = 3 };

static struct platform platform;
/* The device, which the runners share. Each plays lines of its own. */
static struct play shared;
static struct program setup;
static struct runner {
    struct play play;
    struct program program;
} runners[RUNNERS];
static atomic_uint signalled; /* the value of the first runner's timeline */
static atomic_bool working;

#define RUN(number, ...) play_text(&runners[number].play, &runners[number].program, __VA_ARGS__)

/* What a source is built with: a mistake is one more vertex than its update has. */
static const char *shape_of(uint32_t round)
{
    return round % MISTAKES == MISTAKES - 1 ? "max 6" : "";
}

/* ---- submitting, each thread to a queue of its own */

static void *submit_to_first(void *unused)
{
    for (uint32_t i = 0; i < ROUNDS; i++) {
        RUN(0, "c0: build B0 %s", shape_of(i));
        RUN(0, "c1: build B1 update src B0");
        RUN(0, "submit1 c0; submit1 c1 signal t0=%u", i + 1);
        atomic_store(&signalled, i + 1);
        RUN(0, "host wait q0; reset c0; reset c1");
    }
    return NULL;
}

static void *submit_to_second(void *unused)
{
    for (uint32_t i = 0; i < ROUNDS; i++) {
        RUN(1, "c0 for q2: build B0 %s", shape_of(i));
        RUN(1, "c1 for q2: build B1 update src B0");
        RUN(1, "submit1 q2 c0; submit1 q2 c1; host wait q2; reset c0; reset c1");
    }
    return NULL;
}

/* Some of its batches wait for what the other thread signals next. */
static void *wait_for_first(void *unused)
{
    for (uint32_t i = 0; i < ROUNDS; i++) {
        const uint32_t value = atomic_load(&signalled) + i % 2;
        RUN(1, "c0 for q2: build B0 %s", shape_of(i));
        RUN(1, "c1 for q2: build B1 update src B0");
        RUN(1, "submit1 q2 c0; submit q2 c1 wait t0=%u", value < ROUNDS ? value : ROUNDS);
        while (atomic_load(&signalled) < value && atomic_load(&signalled) < ROUNDS)
            sched_yield();
        RUN(1, "host wait q2; reset c0; reset c1");
    }
    return NULL;
}

/* ---- on the host */

static VkDeferredOperationKHR operation(void)
{
    return play_object(&runners[2].play, "d1")->operation;
}

/* A thread that knows that the operation is complete can rely on what it has built. */
static void *build_on_host(void *unused)
{
    for (uint32_t i = 0; i < ROUNDS; i++) {
        RUN(2, "host build B2; host build B3 update src B2; host clone B2 > B3");
        RUN(2, "host build B0 %s deferred d1", shape_of(i));
        while (shared.vk.GetDeferredOperationResultKHR(shared.device, operation()) == VK_NOT_READY)
            continue;
        RUN(2, "host build B1 update src B0");
    }
    atomic_store(&working, false);
    return NULL;
}

static void *join(void *deferred)
{
    while (atomic_load(&working))
        shared.vk.DeferredOperationJoinKHR(shared.device, deferred);
    return NULL;
}

/* ---- the tests */

static pthread_t start(void *(*run)(void *argument), void *argument)
{
    pthread_t thread;
    assert_int_equal(pthread_create(&thread, NULL, run, argument), 0);
    return thread;
}

/* Lines of runners are judged together, by count_messages(). */
static void open_runners(void)
{
    setenv("VK_ASSAY_VALIDATION_ENABLE_MESSAGE_LIMIT", "false", 1);
    if (platform.name == NULL)
        assert_null(platform_open(&platform, "null"));
    shared = (struct play){.platform = &platform};
    assert_true(play_begin(&shared, &setup));
    for (unsigned i = 0; i < RUNNERS; i++) {
        struct runner *runner = &runners[i];
        runner->play = shared;
        runner->play.program = &runner->program;
        runner->program.expected[0] = (struct expectation){"", "", -1, true};
        runner->program.expected_count = 1;
        play_create_objects(&runner->play);
    }
    atomic_store(&signalled, 0);
    atomic_store(&working, true);
}

/* Closes all. Every message is about a planted mistake. */
static uint32_t count_messages(void)
{
    const uint32_t count = shared.fixture.messages.count;
    const uint32_t of_device = messages_count(
        &shared.fixture.messages, "VUID-vkCmdBuildAccelerationStructuresKHR-pInfos-03764", NULL);
    const uint32_t of_host = messages_count(
        &shared.fixture.messages, "VUID-vkBuildAccelerationStructuresKHR-pInfos-03764", NULL);
    print_message("%u by the device, %u by the host\n", of_device, of_host);
    assert_int_equal(of_device + of_host, count);
    for (unsigned i = 0; i < RUNNERS; i++) {
        assert_int_equal(runners[i].play.report.outcome, OUTCOME_PASSED);
        play_destroy_objects(&runners[i].play);
        play_free_blocks(&runners[i].play);
    }
    play_end(&shared);
    play_close(&shared);
    return count;
}

TEST(threads_submit_and_build_at_once)
{
    open_runners();
    const VkDeferredOperationKHR deferred = operation();
    pthread_t threads[3 + JOINERS] = {start(submit_to_first, NULL), start(submit_to_second, NULL),
                                      start(build_on_host, NULL)};
    for (uint32_t i = 0; i < JOINERS; i++)
        threads[3 + i] = start(join, deferred);
    for (uint32_t i = 0; i < 3 + JOINERS; i++)
        pthread_join(threads[i], NULL);
    assert_int_equal(count_messages(), 3 * ROUNDS / MISTAKES);
}

/* Where calls under way may release others, the layer rather says nothing. */
TEST(threads_wait_for_each_other)
{
    open_runners();
    struct play_object *timeline = play_object(&runners[1].play, "t0");
    play_destroy_object(&runners[1].play, timeline);
    timeline->semaphore = play_object(&runners[0].play, "t0")->semaphore;
    pthread_t threads[] = {start(submit_to_first, NULL), start(wait_for_first, NULL)};
    for (uint32_t i = 0; i < sizeof(threads) / sizeof(threads[0]); i++)
        pthread_join(threads[i], NULL);
    timeline->semaphore = VK_NULL_HANDLE;
    const uint32_t count = count_messages();
    print_message("%u of %u mistakes told\n", count, 2 * ROUNDS / MISTAKES);
    assert_in_range(count, 1, 2 * ROUNDS / MISTAKES);
}
