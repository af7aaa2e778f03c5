/* SPDX-License-Identifier: Apache-2.0 */
/* The tests of a program, and its main function. */
#define _GNU_SOURCE /* program_invocation_short_name */
#include "tests/state/unit_test.h"

#include <errno.h>
#include <stdlib.h>

enum { MOST = 64 };

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

int main(void)
{
    struct CMUnitTest in_order[MOST];
    for (size_t i = 0; i < count; i++)
        in_order[i] = tests[i]->test;
    return _cmocka_run_group_tests(program_invocation_short_name, in_order, count, NULL, NULL);
}
