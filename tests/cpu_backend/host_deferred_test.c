/* SPDX-License-Identifier: Apache-2.0 */
/* Deferred operations of backend cpu: parts that are each done once, by whoever joins. */
#include <pthread.h>
#include <stdatomic.h>

#include "src/cpu/deferred.h"
#include "tests/fixture/objects.h"
#include "tests/unit/unit_test.h"

#define REFUSED(call) assert_int_equal(call, VK_ERROR_VALIDATION_FAILED)

enum { PARTS = 200, THREADS = 4 };

/* Work that counts. */
struct counted {
    atomic_int runs[PARTS];
    atomic_int helps, finishes, releases;
    uint32_t failing; /* the part that fails; PARTS: none */
    /* Parts wait here until as many threads as `gate` have come to the work, where it isn't 0. */
    atomic_int arrived;
    int gate;
};

static VkResult run(void *context, uint32_t part)
{
    struct counted *counted = context;
    atomic_fetch_add(&counted->runs[part], 1);
    atomic_fetch_add(&counted->arrived, 1);
    while (atomic_load(&counted->arrived) < counted->gate)
        sched_yield();
    assert_int_equal(counted->releases, 0);
    return part == counted->failing ? VK_ERROR_OUT_OF_HOST_MEMORY : VK_SUCCESS;
}

static void help(void *context)
{
    struct counted *counted = context;
    atomic_fetch_add(&counted->helps, 1);
    atomic_fetch_add(&counted->arrived, 1);
    while (!atomic_load(&counted->finishes))
        sched_yield();
    assert_int_equal(counted->releases, 0);
}

static void finish(void *context)
{
    atomic_fetch_add(&((struct counted *)context)->finishes, 1);
}

static void release(void *context)
{
    atomic_fetch_add(&((struct counted *)context)->releases, 1);
}

static struct cpu_work work_of(struct counted *counted, uint32_t parts)
{
    return (struct cpu_work){parts, parts, run, NULL, finish, release, counted};
}

static struct cpu_deferred_operations *operations;
static uint64_t operation;

static void open_operation(void)
{
    GET(cpu_deferred_operations_create(&operations));
    GET(cpu_deferred_add(operations, &operation));
}

static void close_operations(void)
{
    cpu_deferred_operations_destroy(operations);
    operations = NULL;
}

#define OPERATION_TEST(name) TEST_BETWEEN(name, open_operation, close_operations)

static void start(const struct cpu_work *work)
{
    assert_int_equal(cpu_deferred_start(operations, operation, work), VK_OPERATION_DEFERRED_KHR);
}

static void *join(void *result)
{
    *(VkResult *)result = cpu_deferred_join(operations, operation);
    return NULL;
}

/* A thread that is in the first part, until leave(). */
struct visitor {
    pthread_t thread;
    VkResult result;
};

static void enter(struct visitor *visitor, struct counted *counted)
{
    pthread_create(&visitor->thread, NULL, join, &visitor->result);
    while (!atomic_load(&counted->arrived))
        sched_yield();
}

static void leave(struct visitor *visitor, struct counted *counted)
{
    atomic_fetch_add(&counted->arrived, 1);
    pthread_join(visitor->thread, NULL);
}

static void expect_done(const struct counted *counted, uint32_t parts, VkResult result)
{
    for (uint32_t i = 0; i < parts; i++)
        assert_int_equal(counted->runs[i], 1);
    assert_int_equal(counted->finishes, 1);
    assert_int_equal(counted->releases, 1);
    assert_int_equal(cpu_deferred_result(operations, operation), result);
    assert_int_equal(cpu_deferred_concurrency(operations, operation), 0);
    GET(cpu_deferred_join(operations, operation));
}

OPERATION_TEST(test_one_thread)
{
    GET(cpu_deferred_result(operations, operation));
    assert_int_equal(cpu_deferred_concurrency(operations, operation), 0);
    GET(cpu_deferred_join(operations, operation));
    for (int i = 0; i < 3; i++) { /* an operation is used again */
        struct counted counted = {.failing = i == 1 ? 7 : PARTS};
        struct cpu_work work = work_of(&counted, PARTS);
        start(&work);
        assert_int_equal(cpu_deferred_result(operations, operation), VK_NOT_READY);
        assert_int_equal(cpu_deferred_concurrency(operations, operation), PARTS);
        GET(cpu_deferred_join(operations, operation));
        expect_done(&counted, PARTS, i == 1 ? VK_ERROR_OUT_OF_HOST_MEMORY : VK_SUCCESS);
    }
}

/* All threads get a part before the first is done: the work is spread. */
OPERATION_TEST(test_spread)
{
    struct counted counted = {.failing = PARTS, .gate = THREADS};
    struct cpu_work work = work_of(&counted, PARTS);
    start(&work);
    VkResult results[THREADS];
    int successes = 0;
    unit_test_run_threads(THREADS, join, results, sizeof(results[0]));
    for (int i = 0; i < THREADS; i++) {
        assert_true(results[i] == VK_SUCCESS || results[i] == VK_THREAD_DONE_KHR);
        successes += results[i] == VK_SUCCESS;
    }
    assert_true(successes >= 1);
    expect_done(&counted, PARTS, VK_SUCCESS);
}

/* Threads that find no part left take part in those that run. */
OPERATION_TEST(test_help)
{
    struct counted counted = {.failing = PARTS, .gate = THREADS};
    struct cpu_work work = work_of(&counted, 1);
    work.help = help;
    work.concurrency = THREADS;
    start(&work);
    assert_int_equal(cpu_deferred_concurrency(operations, operation), THREADS);
    VkResult results[THREADS];
    unit_test_run_threads(THREADS, join, results, sizeof(results[0]));
    for (int i = 0; i < THREADS; i++)
        GET(results[i]);
    assert_int_equal(counted.helps, THREADS - 1);
    expect_done(&counted, 1, VK_SUCCESS);
}

static void look_in(void *context)
{
    atomic_fetch_add(&((struct counted *)context)->helps, 1);
}

/* A thread that finds nothing to help with goes, but may find something later. */
OPERATION_TEST(test_nothing_to_do_for_now)
{
    struct counted counted = {.failing = PARTS, .gate = 2};
    struct cpu_work work = work_of(&counted, 1);
    work.help = look_in;
    struct visitor visitor;
    start(&work);
    enter(&visitor, &counted);
    for (int i = 0; i < 3; i++)
        assert_int_equal(cpu_deferred_join(operations, operation), VK_THREAD_IDLE_KHR);
    assert_int_equal(counted.helps, 3);
    leave(&visitor, &counted);
    GET(visitor.result);
    expect_done(&counted, 1, VK_SUCCESS);
}

OPERATION_TEST(test_mistakes)
{
    struct counted pending = {.failing = PARTS}, late = {.failing = PARTS}, wild = late;
    struct cpu_work work = work_of(&pending, 2);
    start(&work);
    work = work_of(&late, 2);
    REFUSED(cpu_deferred_start(operations, operation, &work));
    assert_int_equal(late.releases, 1);
    assert_int_equal(pending.releases, 0);
    cpu_deferred_remove(operations, operation); /* destroyed while pending */
    assert_int_equal(pending.releases, 1);
    assert_int_equal(pending.runs[0], 0);

    work = work_of(&wild, 2);
    REFUSED(cpu_deferred_start(operations, operation, &work));
    assert_int_equal(wild.releases, 1);
    REFUSED(cpu_deferred_join(operations, operation));
    REFUSED(cpu_deferred_result(operations, 42));
    assert_int_equal(cpu_deferred_concurrency(operations, 42), 0);
    cpu_deferred_remove(operations, operation);
}

/* An operation that is destroyed while threads are in it, and one that goes with its device. */
OPERATION_TEST(test_destroyed_in_use)
{
    struct counted counted = {.failing = PARTS, .gate = 2};
    struct cpu_work work = work_of(&counted, 1);
    struct visitor visitor;
    start(&work);
    enter(&visitor, &counted);
    cpu_deferred_remove(operations, operation);
    assert_int_equal(counted.releases, 0);
    leave(&visitor, &counted);
    assert_int_equal(counted.releases, 1);

    struct counted left = {.failing = PARTS};
    work = work_of(&left, 1);
    GET(cpu_deferred_add(operations, &operation));
    start(&work);
    close_operations();
    assert_int_equal(left.releases, 1);
}
