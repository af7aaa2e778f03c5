/* SPDX-License-Identifier: Apache-2.0 */
/* A platform and a kit on backend cpu for each test. */
#include "tests/cpu_backend/advertise_fixture.h"

#include <stdio.h>

struct platform platform;
struct instance_fixture instance_fixture;

int offer_open(void **state)
{
    static const struct instance_fixture_setup on_cpu = {0};
    (void)state;
    instance_fixture_open(&instance_fixture, &platform, &on_cpu);
    return 0;
}

int offer_close(void **state)
{
    (void)state;
    instance_fixture_close(&instance_fixture);
    return 0;
}

int offer_main(int argc, char **argv, int (*run_all)(void))
{
    if (argc != 2) {
        fprintf(stderr, "usage: %s null|lavapipe\n", argv[0]);
        return 2;
    }
    const char *missing = platform_open(&platform, argv[1]);
    if (missing) {
        printf("%s: %s\n", argv[1], missing);
        return 77;
    }
    return run_all();
}
