/* SPDX-License-Identifier: Apache-2.0 */
/* Statements for which there is no memory. The linker sends their allocations to
 * tests/report/scarce_memory.c. */
#ifndef ASSAY_TESTS_STATE_WITHOUT_MEMORY_H
#define ASSAY_TESTS_STATE_WITHOUT_MEMORY_H

#include "../report/scarce_memory.h"

/* The first allocation of the statement fails, and there is one. */
#define WITHOUT_MEMORY(...)                                                                        \
    do {                                                                                           \
        memory_fail_after(0);                                                                      \
        __VA_ARGS__;                                                                               \
        assert_true(memory_fail_no_more());                                                        \
    } while (0)

/* The statement allocates nothing. */
#define ALLOCATES_NOTHING(...)                                                                     \
    do {                                                                                           \
        memory_fail_after(0);                                                                      \
        __VA_ARGS__;                                                                               \
        assert_false(memory_fail_no_more());                                                       \
    } while (0)

#endif
