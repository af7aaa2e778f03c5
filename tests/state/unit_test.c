/* SPDX-License-Identifier: Apache-2.0 */
/* The tests of a program, and its main function. */
#define _GNU_SOURCE /* program_invocation_short_name */
#include "tests/state/unit_test.h"

#include <errno.h>
#include <pthread.h>
#include <stdlib.h>

enum { MOST = 64 }; /* tests, or threads */

static const struct unit_test *tests[MOST];
static size_t count;

void unit_test_register(const struct unit_test *test)
{
    if (count == MOST)
        abort();
    size_t at = count++;
    for (; at && tests[at - 1]->line > test->line; at--)
        tests[at] = tests[at - 1];
    tests[at] = test;
}

void unit_test_run_threads(size_t thread_count, void *(*run)(void *element), void *elements,
                           size_t element_size)
{
    pthread_t threads[MOST];
    assert_true(thread_count <= MOST);
    for (size_t i = 0; i < thread_count; i++)
        assert_int_equal(
            pthread_create(&threads[i], NULL, run, (char *)elements + i * element_size), 0);
    for (size_t i = 0; i < thread_count; i++)
        pthread_join(threads[i], NULL);
}

int main(void)
{
    struct CMUnitTest in_order[MOST];
    if (count == 0)
        return 1; /* a program without tests does not pass */
    for (size_t i = 0; i < count; i++)
        in_order[i] = tests[i]->test;
    return _cmocka_run_group_tests(program_invocation_short_name, in_order, count, NULL, NULL);
}
