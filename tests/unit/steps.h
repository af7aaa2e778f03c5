/* SPDX-License-Identifier: Apache-2.0 */
/* Counts the steps that sources of the layer take, so that a test can bound what a call costs
 * without a clock. A step is a basic block. steps_count() of CMake names the sources, which are
 * compiled into the test once more and call the counter in each basic block. */
#ifndef ASSAY_TESTS_UNIT_STEPS_H
#define ASSAY_TESTS_UNIT_STEPS_H

#include <stdint.h>

/* Steps since the program began; of all threads, so count with one thread only. */
uint64_t steps_so_far(void);

#endif
