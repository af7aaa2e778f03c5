/* SPDX-License-Identifier: Apache-2.0 */
/* Counts the steps that sources of the layer take, so that a test can bound what a call costs
 * without a clock. A step is a basic block. steps_count() of CMake names the sources, which are
 * compiled into the test once more and call the counter in each basic block. One source of the test
 * includes this file. */
#ifndef ASSAY_TESTS_UNIT_STEPS_H
#define ASSAY_TESTS_UNIT_STEPS_H

#include <stdint.h>

static uint64_t steps_so_far; /* of all threads, so count with one thread only */

/* The name is the compiler's: -fsanitize-coverage=trace-pc calls it. */
void __sanitizer_cov_trace_pc(void);

void __sanitizer_cov_trace_pc(void)
{
    steps_so_far++;
}

#endif
