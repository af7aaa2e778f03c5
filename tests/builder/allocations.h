/* SPDX-License-Identifier: Apache-2.0 */
/* How many blocks of memory the program holds, so that a test sees a leak without a sanitizer. The
 * program links with allocations_count() of tests/CMakeLists.txt, or with scarce_memory.c. The main
 * function of unit_test.c fails if blocks are left after the tests. */
#ifndef ASSAY_TESTS_BUILDER_ALLOCATIONS_H
#define ASSAY_TESTS_BUILDER_ALLOCATIONS_H

int allocations_now(void);

#endif
