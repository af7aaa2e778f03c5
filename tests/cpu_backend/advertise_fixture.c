/* SPDX-License-Identifier: Apache-2.0 */
/* A platform and a kit on backend cpu for each test. */
#include "tests/cpu_backend/advertise_fixture.h"

struct platform platform;
struct instance_fixture fixture;

int offer_open(void **state)
{
    static const struct instance_fixture_setup on_cpu = {0};
    instance_fixture_open(&fixture, &platform, &on_cpu);
    return 0;
}

int offer_close(void **state)
{
    instance_fixture_close(&fixture);
    return 0;
}

static const char *open(const char *name)
{
    return platform_open(&platform, name);
}

int offer_main(int argc, char **argv, const struct CMUnitTest *tests, size_t count)
{
    return tests_run(argc, argv, NULL, open, NULL, tests, count);
}
