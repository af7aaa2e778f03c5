/* SPDX-License-Identifier: Apache-2.0 */
/* The tests of a program, and its main function. */
#define _GNU_SOURCE /* program_invocation_short_name */
#include "tests/unit/unit_test.h"
#include "tests/fixture/scarce_memory.h"

#include <errno.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MOST = 64 }; /* tests, or threads */

static const struct unit_test *tests[MOST];
static size_t count;
char **unit_test_arguments;

void unit_test_register(const struct unit_test *test)
{
    if (count == MOST)
        abort();
    size_t at = count++;
    for (; at && tests[at - 1]->line > test->line; at--)
        tests[at] = tests[at - 1];
    tests[at] = test;
}

void assert_has(const char *text, const char *part)
{
    if (!strstr(text, part))
        fail_msg("%s is not in: %s", part, text);
}

void assert_lacks(const char *text, const char *part)
{
    if (strstr(text, part))
        fail_msg("%s is in: %s", part, text);
}

void assert_parts(const char *text, const char *parts)
{
    while (*parts) {
        const char *next = strstr(parts, "...");
        char part[512];
        snprintf(part, sizeof(part), "%.*s", next ? (int)(next - parts) : (int)strlen(parts),
                 parts);
        assert_has(text, part);
        text = strstr(text, part) + strlen(part);
        parts += strlen(part) + (next ? 3 : 0);
    }
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

#pragma weak allocations_now /* not every program counts them */

int main(int argc, char **argv)
{
    struct CMUnitTest wanted[MOST];
    size_t wanted_count = 0;
    unit_test_arguments = argv + 1;
    const char *reason = unit_test_open ? unit_test_open(argc > 1 ? argv[1] : NULL) : NULL;
    if (reason) {
        printf("skipped: %s\n", reason);
        return 77;
    }
    for (size_t i = 0; i < count; i++)
        if (!tests[i]->is_wanted || tests[i]->is_wanted())
            wanted[wanted_count++] = tests[i]->test;
    if (wanted_count == 0)
        return 1; /* a program without tests does not pass */
    const int before = allocations_now ? allocations_now() : 0;
    int failed =
        _cmocka_run_group_tests(program_invocation_short_name, wanted, wanted_count, NULL, NULL);
    if (unit_test_close)
        unit_test_close();
    const bool keeps_memory = unit_test_keeps_memory && unit_test_keeps_memory();
    if (allocations_now && !keeps_memory && !failed && allocations_now() > before) {
        printf("%d blocks of memory are left\n", allocations_now() - before);
        failed = 1;
    }
    return failed;
}
