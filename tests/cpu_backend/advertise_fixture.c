/* SPDX-License-Identifier: Apache-2.0 */
/* A platform and a kit on backend cpu for each test. */
#include "tests/cpu_backend/advertise_fixture.h"

struct platform platform;
struct instance_fixture fixture;

void offer_open(void)
{
    static const struct instance_fixture_setup on_cpu = {0};
    instance_fixture_open(&fixture, &platform, &on_cpu);
}

void offer_close(void)
{
    instance_fixture_close(&fixture);
}

const char *unit_test_open(const char *name)
{
    return platform_open(&platform, name);
}

void unit_test_close(void) {}
