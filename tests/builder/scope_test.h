/* SPDX-License-Identifier: Apache-2.0 */
/* Tests (unit_test.h) after which all is freed that the fixture has allocated. */
#ifndef ASSAY_TESTS_BUILDER_SCOPE_TEST_H
#define ASSAY_TESTS_BUILDER_SCOPE_TEST_H

#include "tests/builder/fixture.h"
#include "tests/state/unit_test.h"

#define SCOPE_TEST(name_)                                                                          \
    static void name_(void);                                                                       \
    static void run_##name_(void **state)                                                          \
    {                                                                                              \
        (void)state;                                                                               \
        name_();                                                                                   \
    }                                                                                              \
    UNIT_TEST_REGISTER(name_, fixture_setup, fixture_teardown)                                     \
    static void name_(void)

#endif
