/* SPDX-License-Identifier: Apache-2.0 */
/* Tests (unit_test.h) between functions of the program that take nothing: open() prepares what the
 * program's tests share, and close() ends it, even if the test fails. */
#ifndef ASSAY_TESTS_CPU_BACKEND_TEST_BETWEEN_H
#define ASSAY_TESTS_CPU_BACKEND_TEST_BETWEEN_H

#include "tests/state/unit_test.h"

#define TEST_BETWEEN(name_, open_, close_)                                                         \
    static void name_(void);                                                                       \
    static int open_##name_(void **state)                                                          \
    {                                                                                              \
        open_();                                                                                   \
        return 0;                                                                                  \
    }                                                                                              \
    static int close_##name_(void **state)                                                         \
    {                                                                                              \
        close_();                                                                                  \
        return 0;                                                                                  \
    }                                                                                              \
    static void run_##name_(void **state)                                                          \
    {                                                                                              \
        name_();                                                                                   \
    }                                                                                              \
    UNIT_TEST_REGISTER(name_, open_##name_, close_##name_)                                         \
    static void name_(void)

static inline void do_nothing(void) {}

#define TEST_OPENED(name, open) TEST_BETWEEN(name, open, do_nothing)
#define TEST_CLOSED(name, close) TEST_BETWEEN(name, do_nothing, close)

#endif
