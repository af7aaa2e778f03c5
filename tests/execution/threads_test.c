/* SPDX-License-Identifier: Apache-2.0 */
/* Several threads submit, build on the host, and join what it deferred; run under the thread
 * sanitizer, too. Over the driver, each has structures of its own, and plants a mistake now and
 * then; at level content, they share what is copied. On backend cpu they share structures, and rays
 * meet them. */
#include <pthread.h>
#include <sched.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#ifndef _WIN32
#include <sys/wait.h>
#include <unistd.h>
#endif

#include "src/platform/clock.h"
#include "tests/fixture/messenger.h"
#include "tests/player/play.h"
#include "tests/unit/unit_test.h"

enum {
    ROUNDS = 400,
    FEW_ROUNDS = 40,
    MISTAKES = 5, /* one in so many rounds */
    JOINERS = 2,
    RUNNERS = 3
};

static struct platform platform;

const char *unit_test_open(const char *name)
{
    return platform_open(&platform, name ? name : "null");
}

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

static void join_threads(const pthread_t *threads, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++)
        pthread_join(threads[i], NULL);
}

/* Lines of runners are judged together, by count_messages(). */
static void open_runners(void)
{
    setenv("VK_ASSAY_VALIDATION_ENABLE_MESSAGE_LIMIT", "false", 1);
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

TEST_IF(threads_submit_and_build_at_once, !platform.is_cpu)
{
    open_runners();
    const VkDeferredOperationKHR deferred = operation();
    pthread_t threads[3 + JOINERS] = {start(submit_to_first, NULL), start(submit_to_second, NULL),
                                      start(build_on_host, NULL)};
    for (uint32_t i = 0; i < JOINERS; i++)
        threads[3 + i] = start(join, deferred);
    join_threads(threads, 3 + JOINERS);
    assert_int_equal(count_messages(), 3 * ROUNDS / MISTAKES);
}

/* Where calls under way may release others, the layer rather says nothing. */
TEST_IF(threads_wait_for_each_other, !platform.is_cpu)
{
    open_runners();
    struct play_object *timeline = play_object(&runners[1].play, "t0");
    play_destroy_object(&runners[1].play, timeline);
    timeline->semaphore = play_object(&runners[0].play, "t0")->semaphore;
    pthread_t threads[] = {start(submit_to_first, NULL), start(wait_for_first, NULL)};
    join_threads(threads, ARRAY_COUNT(threads));
    timeline->semaphore = VK_NULL_HANDLE;
    const uint32_t count = count_messages();
    print_message("%u of %u mistakes told\n", count, 2 * ROUNDS / MISTAKES);
    assert_in_range(count, 1, 2 * ROUNDS / MISTAKES);
}

/* ---- at level content: what an execution copied may have to be kept while the next one copies */

static VkResult results[RUNNERS]; /* of what each has submitted last */

static void open_at_content(const char *setting)
{
    setup.line_count = 0;
    setup.used = 0;
    program_add(&setup, "setting level content", 1);
    program_add(&setup, setting, 2);
    open_runners();
    setup.line_count = 0;
    setup.used = 0;
}

static VkResult submit_c0(unsigned i)
{
    const VkCommandBuffer commands = play_object(&runners[i].play, "c0")->commands;
    const VkResult result = commands_submit(&shared.vk, shared.queues[i], commands, VK_NULL_HANDLE);
    return result == VK_SUCCESS ? shared.vk.QueueWaitIdle(shared.queues[i]) : result;
}

static void *build_boxes(void *number)
{
    const unsigned i = (unsigned)(uintptr_t)number;
    results[i] = VK_SUCCESS;
    for (uint32_t round = 0; round < FEW_ROUNDS && results[i] == VK_SUCCESS; round++) {
        RUN(i, "c0 for q%u: build B0 boxes A0", i);
        for (int again = 0; again < 2 && results[i] == VK_SUCCESS; again++)
            results[i] = submit_c0(i);
        RUN(i, "reset c0");
    }
    return NULL;
}

static void run_builders(void (*meanwhile)(void))
{
    pthread_t threads[RUNNERS];
    open_at_content("setting hazards false");
    for (uintptr_t i = 0; i < RUNNERS; i++)
        threads[i] = start(build_boxes, (void *)i);
    if (meanwhile)
        meanwhile();
    join_threads(threads, RUNNERS);
}

TEST_IF(threads_build_at_level_content, !platform.is_cpu)
{
    run_builders(NULL);
    for (unsigned i = 0; i < RUNNERS; i++)
        GET(results[i]);
    assert_int_equal(count_messages(), 0);
}

/* Forgets the messages, each of which has one of the texts. */
static void expect_only(const char *text, const char *other)
{
    struct messages *messages = &shared.fixture.messages;
    for (uint32_t i = 0; i < messages_kept(messages); i++)
        if (!strstr(messages->items[i].text, text) && !strstr(messages->items[i].text, other))
            fail_msg("%s", messages->items[i].text);
    messages_clear(messages);
}

static void lose_device(void)
{
    platform.null_driver.set_device_lost(true);
}

/* The layer reports only that these builds may not have executed, and no thread hangs. A thread
 * that does not know of the loss yet may submit a command buffer again before the layer has seen it
 * complete. */
TEST_IF(a_device_is_lost_while_threads_build, !platform.is_cpu)
{
    run_builders(lose_device);
    for (unsigned i = 0; i < RUNNERS; i++)
        assert_true(results[i] == VK_SUCCESS || results[i] == VK_ERROR_DEVICE_LOST);
    platform.null_driver.set_device_lost(false);
    expect_only(" lost", "submitted again before");
    count_messages();
}

static void *execute_shared(void *number)
{
    const unsigned i = (unsigned)(uintptr_t)number;
    RUN(i, "c0 for q%u: execute c1", i);
    results[i] = VK_SUCCESS;
    for (uint32_t round = 0; round < FEW_ROUNDS && results[i] == VK_SUCCESS; round++)
        results[i] = submit_c0(i);
    return NULL;
}

/* Two threads submit primaries to queues of their own, which execute the same secondary, c1. */
static void run_shared_secondary(void)
{
    struct play_object *c1 = play_object(&runners[1].play, "c1");
    const VkCommandBuffer own = c1->commands;
    c1->commands = play_object(&runners[0].play, "c1")->commands;
    c1->is_secondary = true;
    const pthread_t thread = start(execute_shared, (void *)(uintptr_t)1);
    execute_shared(NULL);
    pthread_join(thread, NULL);
    c1->commands = own;
    GET(results[0]);
    GET(results[1]);
}

/* Nothing orders the two queues: the null driver builds nothing. The layer says at most that it
 * does not validate what executes twice at once. */
TEST_IF(threads_share_a_secondary, !platform.is_cpu)
{
    open_at_content("setting hazards false");
    RUN(0, "c1 secondary simultaneous: build B0 boxes A0");
    run_shared_secondary();
    expect_only("submitted again before", "submitted again before");
    count_messages();
}

/* If both threads submit at the same time, the order is unknown to one of them, which lets each
 * live structure count as built for the guard. B1 is never built. The null driver reads the table
 * of live structures on the thread that submits, while the other one changes it as it may for a
 * GPU: a race for the thread sanitizer. */
TEST_IF(threads_share_a_guarded_secondary, !platform.is_cpu && !HAS_THREAD_SANITIZER)
{
    uint64_t read[4 * FEW_ROUNDS], references[2];
    open_at_content("setting guard references");
    RUN(0, "build B0 boxes A0; submit; host wait idle; init N0 instances B0 B1");
    references[0] = play_reference_to(&shared, play_object(&runners[0].play, "B0"));
    references[1] = play_reference_to(&shared, play_object(&runners[0].play, "B1"));
    platform.null_driver.set_reads_instances(true);
    RUN(0, "c1 secondary simultaneous: top T0 instances N0 primitives 2");
    run_shared_secondary();
    assert_int_equal(platform.null_driver.take_references(read, 4 * FEW_ROUNDS), 4 * FEW_ROUNDS);
    platform.null_driver.set_reads_instances(false);
    for (int i = 0; i < 4 * FEW_ROUNDS; i += 2) {
        assert_int_equal(read[i], references[0]);
        assert_true(read[i + 1] == references[1] || !read[i + 1]);
    }
    messages_clear(&shared.fixture.messages); /* about the structure that is not built */
    count_messages();
}

/* One report at most. tests/programs/postmortem/hang.cases has the waits of one thread. */
static void *wait_for_fence(void *result)
{
    *(VkResult *)result =
        shared.vk.WaitForFences(shared.device, 1, &runners[0].play.fence, VK_TRUE, UINT64_MAX);
    return NULL;
}

TEST_IF(threads_wait_while_the_device_hangs, !platform.is_cpu)
{
    enum { WAITERS = 4 };
    VkResult waits[WAITERS];
    pthread_t threads[WAITERS];
    open_at_content("setting hang_seconds 1");
    struct messages *messages = &shared.fixture.messages;
    RUN(0, "init A0 box; fault hang at build; build B0 boxes A0 primitives 1; submit fence");
    assert_int_equal(messages->count, 0);
    for (int i = 0; i < WAITERS; i++)
        threads[i] = start(wait_for_fence, &waits[i]);
    clock_sleep(1500000000);
    platform.null_driver.end_hang();
    join_threads(threads, WAITERS);
    for (int i = 0; i < WAITERS; i++)
        GET(waits[i]);
    GET(shared.vk.DeviceWaitIdle(shared.device));
    const uint32_t hangs = messages_count(messages, "ASSAY-hang", NULL);
    assert_true(hangs <= 1);
    assert_int_equal(messages->count, hangs + 1); /* the box is upside down */
    messages_clear(messages);
    count_messages();
}

#ifndef _WIN32
/* The loader unloads the layer with the instance. Its thread, which compares trees for setting
 * advice, would crash then. */
static void leave_device_behind(void)
{
    setenv("VK_ASSAY_VALIDATION_ADVICE_LIMITS", "submissions=1000,refit_percent=1", 1);
    open_at_content("setting advice true");
    RUN(0, "create B0 fitting vertices V0 primitives 3000");
    for (unsigned i = 0; i < 64; i++) {
        RUN(0, "init V0 soup 3000 %u", i + 1);
        RUN(0, "build B0 %s vertices V0 primitives 3000; submit; host wait idle",
            i ? "update" : "");
    }
    if (runners[0].play.report.outcome != OUTCOME_PASSED)
        _exit(1);
    instance_fixture_close(&shared.fixture);
    clock_sleep(500000000);
    _exit(0);
}

TEST_IF(a_device_is_left_behind, !platform.is_cpu)
{
    int status = -1;
    const pid_t child = fork();
    if (!child)
        leave_device_behind();
    assert_true(child > 0 && waitpid(child, &status, 0) == child);
    assert_int_equal(status, 0);
}
#endif

/* ---- on backend cpu */

/* The host rebuilds the BLAS that all TLASes refer to, and rays meet it meanwhile. */
static void *build_query_and_trace(void *number)
{
    static pthread_mutex_t rebuilding = PTHREAD_MUTEX_INITIALIZER;
    const unsigned i = (unsigned)(uintptr_t)number;
    for (uint32_t round = 0; round < FEW_ROUNDS; round++) {
        RUN(i,
            "c0 for q%u: build B0; barrier all:memory_write > all:memory_read|memory_write; "
            "top T0 instances N0 primitives 2; reset P0; query B0 > P0; results P0 > G0",
            i);
        for (int again = 0; again < 2; again++)
            RUN(i, "submit q%u c0; host wait q%u", i, i);
        pthread_mutex_lock(&rebuilding);
        RUN(i, "host build B1");
        pthread_mutex_unlock(&rebuilding);
        RUN(i, "probe T0; host read P0 64; reset c0");
    }
    return NULL;
}

TEST_IF(threads_build_query_and_trace, platform.is_cpu)
{
    pthread_t threads[RUNNERS];
    struct play_object *blas[RUNNERS];
    open_runners();
    for (unsigned i = 0; i < RUNNERS; i++) {
        blas[i] = play_object(&runners[i].play, "B1");
        if (i) {
            play_destroy_object(&runners[i].play, blas[i]);
            blas[i]->structure = blas[0]->structure;
        }
        RUN(i, "init N0 instances B0 B1");
    }
    for (uintptr_t i = 0; i < RUNNERS; i++)
        threads[i] = start(build_query_and_trace, (void *)i);
    join_threads(threads, RUNNERS);
    for (unsigned i = 1; i < RUNNERS; i++)
        blas[i]->structure = VK_NULL_HANDLE;
    assert_int_equal(count_messages(), 0);
}

static void *complete(void *deferred)
{
    while (shared.vk.DeferredOperationJoinKHR(shared.device, deferred) == VK_THREAD_IDLE_KHR)
        continue;
    return NULL;
}

/* The parameters of the call that has deferred the work may be gone by then. */
static void complete_together(void)
{
    pthread_t threads[JOINERS];
    play_free_blocks(&runners[2].play);
    assert_in_range(shared.vk.GetDeferredOperationMaxConcurrencyKHR(shared.device, operation()), 1,
                    16);
    for (uint32_t i = 0; i < JOINERS; i++)
        threads[i] = start(complete, operation());
    join_threads(threads, JOINERS);
    RUN(2, "host result d1");
}

/* The bytes are the same, whoever built them. */
TEST_IF(threads_share_what_is_deferred, platform.is_cpu)
{
    static const char *const qualities[] = {"none", "fast_build", "fast_trace"};
    open_runners();
    RUN(2, "init W0 soup 5000; init V0 floats 0 0 0 0 1 0 0 0 1");
    for (size_t i = 0; i < ARRAY_COUNT(qualities); i++) {
        char shape[128];
        snprintf(shape, sizeof(shape), "vertices W0 primitives 5000 flags update|%s", qualities[i]);
        RUN(2, "create B0 fitting %s; create B1 fitting %s", shape, shape);
        RUN(2, "host build B0 %s; host build B1 %s deferred d1", shape, shape);
        complete_together();
        RUN(2, "host serialize B0 > W1; host serialize B1 > W2; same W1 W2 200000");
        RUN(2, "host build B1 update %s deferred d1", shape);
        complete_together();
        RUN(2, "host serialize B1 > W2; same W1 W2 200000");
    }
    RUN(2, "host build B2 and B3 and B4 and B5 and B6 and B7 and B8 and B9 deferred d1");
    complete_together();
    RUN(2, "host top T0 B2 B3 B4 B5 B6 B7 B8 B9 deferred d1");
    complete_together();
    RUN(2, "probe B2 hits t 1; probe B9 hits t 1; probe T0 hits t 1");
    RUN(2, "host serialize T0 > W1 deferred d1");
    complete_together();
    RUN(2, "host deserialize W1 > T1 deferred d1");
    complete_together();
    RUN(2, "probe T1 hits t 1");
    assert_int_equal(count_messages(), 0);
}

static atomic_bool is_checking, is_waiting;

MESSENGER_CALLBACK(pause_in_message)
{
    atomic_store(&is_checking, true);
    while (!atomic_load(&is_waiting))
        clock_yield();
    clock_sleep(20000000);
    return VK_FALSE;
}

static void *submit_mistake(void *unused)
{
    RUN(0, "submit q0 c0");
    return NULL;
}

/* The batch of the other thread is still being checked when the host waits for one behind it. */
TEST_IF(results_behind_work_of_another_thread, platform.is_cpu)
{
    const STRUCT(VkDebugUtilsMessengerCreateInfoEXT, info,
                 .messageSeverity = VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT,
                 .messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT,
                 .pfnUserCallback = pause_in_message);
    VkDebugUtilsMessengerEXT messenger;
    open_runners();
    const struct instance_fixture *instance = &shared.fixture;
    RUN(1, "host build B0");
    RUN(1, "c0 for q1: reset P0; query B0 > P0");
    RUN(0, "c0: build B0 update src B1"); /* never built */
    GET(instance->vk.CreateDebugUtilsMessengerEXT(instance->instance, &info, NULL, &messenger));
    const pthread_t thread = start(submit_mistake, NULL);
    while (!atomic_load(&is_checking))
        clock_yield();
    RUN(1, "submit q1 c0 fence");
    atomic_store(&is_waiting, true);
    RUN(1, "host wait fence; host query B0; host read P0 64 gives size");
    pthread_join(thread, NULL);
    instance->vk.DestroyDebugUtilsMessengerEXT(instance->instance, messenger, NULL);
    messages_clear(&shared.fixture.messages);
    count_messages();
}

static void *signal_later(void *timeline)
{
    clock_sleep(20000000);
    GET(shared.vk.SignalSemaphore(shared.device,
                                  &MAKE(VkSemaphoreSignalInfo, .semaphore = timeline, .value = 1)));
    return NULL;
}

TEST_IF(a_query_that_waits_for_another_thread, platform.is_cpu)
{
    open_runners();
    RUN(0, "host build B0; host query B0");
    RUN(0, "c0: reset P0; query B0 > P0");
    RUN(0, "submit1 c0 wait t0=1");
    const pthread_t thread = start(signal_later, play_object(&runners[0].play, "t0")->semaphore);
    RUN(0, "host read P0 64 wait gives size");
    pthread_join(thread, NULL);
    assert_int_equal(count_messages(), 0);
}
