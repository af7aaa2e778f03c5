/* SPDX-License-Identifier: Apache-2.0 */
/* Deferred operations of backend cpu: parts that are each done once, by whoever joins. */
#include <pthread.h>
#include <stdatomic.h>

#include "src/cpu/deferred.h"
#include "tests/fixture/objects.h"
#include "tests/state/unit_test.h"

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

struct joined {
    struct cpu_deferred_operations *operations;
    uint64_t operation;
};

static void *join(void *context)
{
    const struct joined *joined = context;
    return (void *)(intptr_t)cpu_deferred_join(joined->operations, joined->operation);
}

static struct joined open_operation(void)
{
    struct joined joined;
    GET(cpu_deferred_operations_create(&joined.operations));
    GET(cpu_deferred_add(joined.operations, &joined.operation));
    return joined;
}

static void expect_done(const struct joined *joined, const struct counted *counted, uint32_t parts,
                        VkResult result)
{
    for (uint32_t i = 0; i < parts; i++)
        assert_int_equal(counted->runs[i], 1);
    assert_int_equal(counted->finishes, 1);
    assert_int_equal(counted->releases, 1);
    assert_int_equal(cpu_deferred_result(joined->operations, joined->operation), result);
    assert_int_equal(cpu_deferred_concurrency(joined->operations, joined->operation), 0);
    GET(cpu_deferred_join(joined->operations, joined->operation));
}

TEST(test_one_thread)
{
    struct joined joined = open_operation();
    GET(cpu_deferred_result(joined.operations, joined.operation));
    assert_int_equal(cpu_deferred_concurrency(joined.operations, joined.operation), 0);
    GET(cpu_deferred_join(joined.operations, joined.operation));
    for (int i = 0; i < 3; i++) { /* an operation is used again */
        struct counted counted = {.failing = i == 1 ? 7 : PARTS};
        struct cpu_work work = work_of(&counted, PARTS);
        assert_int_equal(cpu_deferred_start(joined.operations, joined.operation, &work),
                         VK_OPERATION_DEFERRED_KHR);
        assert_int_equal(cpu_deferred_result(joined.operations, joined.operation), VK_NOT_READY);
        assert_int_equal(cpu_deferred_concurrency(joined.operations, joined.operation), PARTS);
        GET(cpu_deferred_join(joined.operations, joined.operation));
        expect_done(&joined, &counted, PARTS, i == 1 ? VK_ERROR_OUT_OF_HOST_MEMORY : VK_SUCCESS);
    }
    cpu_deferred_operations_destroy(joined.operations);
}

/* All threads get a part before the first is done: the work is spread. */
TEST(test_spread)
{
    struct joined joined = open_operation();
    struct counted counted = {.failing = PARTS, .gate = THREADS};
    struct cpu_work work = work_of(&counted, PARTS);
    cpu_deferred_start(joined.operations, joined.operation, &work);
    pthread_t threads[THREADS];
    int successes = 0;
    for (int i = 0; i < THREADS; i++)
        pthread_create(&threads[i], NULL, join, &joined);
    for (int i = 0; i < THREADS; i++) {
        void *result;
        pthread_join(threads[i], &result);
        assert_true((intptr_t)result == VK_SUCCESS || (intptr_t)result == VK_THREAD_DONE_KHR);
        successes += (intptr_t)result == VK_SUCCESS;
    }
    assert_true(successes >= 1);
    expect_done(&joined, &counted, PARTS, VK_SUCCESS);
    cpu_deferred_operations_destroy(joined.operations);
}

/* Threads that find no part left take part in those that run. */
TEST(test_help)
{
    struct joined joined = open_operation();
    struct counted counted = {.failing = PARTS, .gate = THREADS};
    struct cpu_work work = work_of(&counted, 1);
    work.help = help;
    work.concurrency = THREADS;
    cpu_deferred_start(joined.operations, joined.operation, &work);
    assert_int_equal(cpu_deferred_concurrency(joined.operations, joined.operation), THREADS);
    pthread_t threads[THREADS];
    for (int i = 0; i < THREADS; i++)
        pthread_create(&threads[i], NULL, join, &joined);
    for (int i = 0; i < THREADS; i++) {
        void *result;
        pthread_join(threads[i], &result);
        GET((intptr_t)result);
    }
    assert_int_equal(counted.helps, THREADS - 1);
    expect_done(&joined, &counted, 1, VK_SUCCESS);
    cpu_deferred_operations_destroy(joined.operations);
}

static void look_in(void *context)
{
    atomic_fetch_add(&((struct counted *)context)->helps, 1);
}

/* A thread that finds nothing to help with goes, but may find something later. */
TEST(test_nothing_to_do_for_now)
{
    struct joined joined = open_operation();
    struct counted counted = {.failing = PARTS, .gate = 2};
    struct cpu_work work = work_of(&counted, 1);
    work.help = look_in;
    cpu_deferred_start(joined.operations, joined.operation, &work);
    pthread_t thread;
    pthread_create(&thread, NULL, join, &joined);
    while (!atomic_load(&counted.arrived))
        sched_yield();
    for (int i = 0; i < 3; i++)
        assert_int_equal(cpu_deferred_join(joined.operations, joined.operation),
                         VK_THREAD_IDLE_KHR);
    assert_int_equal(counted.helps, 3);
    atomic_fetch_add(&counted.arrived, 1);
    void *result;
    pthread_join(thread, &result);
    GET((intptr_t)result);
    expect_done(&joined, &counted, 1, VK_SUCCESS);
    cpu_deferred_operations_destroy(joined.operations);
}

TEST(test_mistakes)
{
    struct joined joined = open_operation();
    struct counted pending = {.failing = PARTS}, late = {.failing = PARTS}, wild = late;
    struct cpu_work work = work_of(&pending, 2);
    cpu_deferred_start(joined.operations, joined.operation, &work);
    work = work_of(&late, 2);
    REFUSED(cpu_deferred_start(joined.operations, joined.operation, &work));
    assert_int_equal(late.releases, 1);
    assert_int_equal(pending.releases, 0);
    cpu_deferred_remove(joined.operations, joined.operation); /* destroyed while pending */
    assert_int_equal(pending.releases, 1);
    assert_int_equal(pending.runs[0], 0);

    work = work_of(&wild, 2);
    REFUSED(cpu_deferred_start(joined.operations, joined.operation, &work));
    assert_int_equal(wild.releases, 1);
    REFUSED(cpu_deferred_join(joined.operations, joined.operation));
    REFUSED(cpu_deferred_result(joined.operations, 42));
    assert_int_equal(cpu_deferred_concurrency(joined.operations, 42), 0);
    cpu_deferred_remove(joined.operations, joined.operation);
    cpu_deferred_operations_destroy(joined.operations);
}

/* An operation that is destroyed while threads are in it, and one that goes with its device. */
TEST(test_destroyed_in_use)
{
    struct joined joined = open_operation();
    struct counted counted = {.failing = PARTS, .gate = 2};
    struct cpu_work work = work_of(&counted, 1);
    cpu_deferred_start(joined.operations, joined.operation, &work);
    pthread_t thread;
    pthread_create(&thread, NULL, join, &joined);
    while (!atomic_load(&counted.arrived))
        sched_yield();
    cpu_deferred_remove(joined.operations, joined.operation);
    assert_int_equal(counted.releases, 0);
    atomic_fetch_add(&counted.arrived, 1);
    pthread_join(thread, NULL);
    assert_int_equal(counted.releases, 1);

    struct counted left = {.failing = PARTS};
    work = work_of(&left, 1);
    GET(cpu_deferred_add(joined.operations, &joined.operation));
    cpu_deferred_start(joined.operations, joined.operation, &work);
    cpu_deferred_operations_destroy(joined.operations);
    assert_int_equal(left.releases, 1);
}
