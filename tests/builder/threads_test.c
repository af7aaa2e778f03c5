/* SPDX-License-Identifier: Apache-2.0 */
/* Threads: none but the caller's where one was asked for. */
#include <dirent.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>

#include <cmocka.h>

#include "kit.h"

#define INSTANCES 9000u /* more than one thread's portion */

static uint32_t count_threads(void)
{
    DIR *tasks = opendir("/proc/self/task");
    uint32_t count = 0;
    assert_non_null(tasks);
    while (readdir(tasks))
        count++;
    closedir(tasks);
    return count - 2; /* . and .. */
}

/* Called in the midst of a build. */
static uint32_t most_threads;

static const void *count_and_find(void *context, uint64_t reference)
{
    if (reference % 1024 == 1 && __atomic_load_n(&most_threads, __ATOMIC_RELAXED) < 100) {
        uint32_t count = count_threads();
        if (count > __atomic_load_n(&most_threads, __ATOMIC_RELAXED))
            __atomic_store_n(&most_threads, count, __ATOMIC_RELAXED);
    }
    return context;
}

static uint32_t threads_in_build(const void *blas, uint32_t threads)
{
    VkAccelerationStructureInstanceKHR *instances = kit_allocate(INSTANCES * sizeof(*instances));
    struct kit_input input;
    for (uint32_t i = 0; i < INSTANCES; i++) {
        instances[i] = kit_instance(NULL);
        instances[i].accelerationStructureReference = i + 1;
    }
    kit_input_instances(&input, instances, INSTANCES);
    input.input.threads = threads;
    input.input.resolver = (struct builder_resolver){count_and_find, (void *)blas};
    most_threads = 0;
    void *tlas = kit_build(&input.input, NULL);
    assert_non_null(tlas);
    free(tlas);
    free(instances);
    return most_threads;
}

static void test_threads(void **state)
{
    (void)state;
    static const float triangle[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    struct kit_input input;
    kit_input_triangles(&input, triangle, 1);
    void *blas = kit_build(&input.input, NULL);
    uint32_t before = count_threads();
    assert_int_equal(threads_in_build(blas, 0), before);
    assert_int_equal(threads_in_build(blas, 1), before);
    assert_true(threads_in_build(blas, 2) > before);
    free(blas);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_threads)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
