/* SPDX-License-Identifier: Apache-2.0 */
#include "tests/unit/steps.h"

static uint64_t steps;

/* The name is the compiler's: -fsanitize-coverage=trace-pc calls it. */
void __sanitizer_cov_trace_pc(void);

void __sanitizer_cov_trace_pc(void)
{
    steps++;
}

uint64_t steps_so_far(void)
{
    return steps;
}
