/* SPDX-License-Identifier: Apache-2.0 */
/* What tests of backend cpu's offer share: a physical device without a device yet. */
#ifndef ASSAY_TESTS_CPU_BACKEND_ADVERTISE_FIXTURE_H
#define ASSAY_TESTS_CPU_BACKEND_ADVERTISE_FIXTURE_H

#include "tests/cpu_backend/instance_fixture.h"
#include "tests/state/unit_test.h"

extern struct platform platform;
extern struct instance_fixture fixture; /* of an OFFER_TEST */

void offer_open(void);
void offer_close(void);
#define OFFER_TEST(name) TEST_BETWEEN(name, offer_open, offer_close)

#endif
