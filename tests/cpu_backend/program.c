/* SPDX-License-Identifier: Apache-2.0 */
/* The tests of a program on a platform, in the order of the file, and its main function. */
#include "tests/cpu_backend/program.h"

#include <stdlib.h>

#include "tests/fixture/instance.h"

enum { MOST = 16 };

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

int main(int argc, char **argv)
{
    struct CMUnitTest in_order[MOST];
    if (count == 0)
        return 1; /* a program without tests does not pass */
    for (size_t i = 0; i < count; i++)
        in_order[i] = tests[i]->test;
    return tests_run(argc, argv, NULL, program_open, program_close, in_order, count);
}
