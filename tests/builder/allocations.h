/* SPDX-License-Identifier: Apache-2.0 */
/* How many blocks of memory the program holds, so that a test sees a leak without a sanitizer. The
 * program links with allocations_count() of tests/CMakeLists.txt. */
#ifndef ASSAY_TESTS_BUILDER_ALLOCATIONS_H
#define ASSAY_TESTS_BUILDER_ALLOCATIONS_H

int allocations_now(void);

#endif
