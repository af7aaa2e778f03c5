/* SPDX-License-Identifier: Apache-2.0 */
/* What tests of backend cpu's offer share: a physical device without a device yet. */
#ifndef ASSAY_TESTS_CPU_BACKEND_ADVERTISE_FIXTURE_H
#define ASSAY_TESTS_CPU_BACKEND_ADVERTISE_FIXTURE_H

#include "tests/cpu_backend/instance_fixture.h"

extern struct platform platform;
extern struct instance_fixture fixture; /* between: */
int offer_open(void **state);
int offer_close(void **state);

/* What main() returns: runs the tests on the platform that the arguments name. */
int offer_main(int argc, char **argv, const struct CMUnitTest *tests, size_t count);

#endif
