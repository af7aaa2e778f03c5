/* SPDX-License-Identifier: Apache-2.0 */
/* A platform and a kit on backend cpu for each test. */
#include "offer_stage.h"

#include <stdio.h>

struct platform platform;
struct kit kit;

int offer_open(void **state)
{
    static const struct kit_setup on_cpu = {0};
    (void)state;
    kit_open(&kit, &platform, &on_cpu);
    return 0;
}

int offer_close(void **state)
{
    (void)state;
    kit_close(&kit);
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
