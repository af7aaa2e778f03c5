/* SPDX-License-Identifier: Apache-2.0 */
/* Tests (unit_test.h) after which all is freed that the fixture has allocated. */
#ifndef ASSAY_TESTS_BUILDER_SCOPE_TEST_H
#define ASSAY_TESTS_BUILDER_SCOPE_TEST_H

#include "tests/builder/fixture.h"
#include "tests/state/unit_test.h"

#define SCOPE_TEST(name) TEST_BETWEEN(name, fixture_scope_begin, fixture_scope_end)

#endif
