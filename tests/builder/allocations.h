/* SPDX-License-Identifier: Apache-2.0 */
/* How many blocks of memory the program holds, so that a test sees a leak without a sanitizer. The
 * program links with scarce_memory.c: allocations_count() of tests/CMakeLists.txt. The main
 * function of unit_test.c fails if blocks are left after the tests. */
#ifndef ASSAY_TESTS_BUILDER_ALLOCATIONS_H
#define ASSAY_TESTS_BUILDER_ALLOCATIONS_H

int allocations_now(void);

#endif
