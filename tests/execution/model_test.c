/* SPDX-License-Identifier: Apache-2.0 */
/* execution_model_test [--programs N] [--seed S] [--only N]
 *
 * Random programs on the null driver, through the loader and the layer, against the model. A
 * program depends on the seed and its own number alone, so that --only plays it again. */
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "random_test.h"

enum { PROGRAMS = 100000 };

static uint64_t read_number(int argc, char **argv, const char *name, uint64_t otherwise)
{
    for (int i = 1; i + 1 < argc; i += 2)
        if (strcmp(argv[i], name) == 0)
            return strtoull(argv[i + 1], NULL, 0);
    return otherwise;
}

int main(int argc, char **argv)
{
    static struct platform platform;
    static struct random_test test;
    const uint64_t programs = read_number(argc, argv, "--programs", PROGRAMS);
    const uint64_t seed = read_number(argc, argv, "--seed", random_seed(20261121));
    const uint64_t only = read_number(argc, argv, "--only", UINT64_MAX);
    const char *missing = platform_open(&platform, "null");
    if (missing != NULL) {
        printf("%s\n", missing);
        return 1;
    }
    differences_fill();
    random_test_open(&test, &platform);
    for (uint64_t i = 0; i < programs && !test.failed; i++) {
        if (only != UINT64_MAX && i != only)
            continue;
        test.random.state = seed + (i << 32);
        random_test_play(&test);
        if (test.failed)
            printf("program %" PRIu64 " of seed %" PRIu64 " differs\n", i, seed);
    }
    printf("seed %" PRIu64 ": %" PRIu64 " programs, %" PRIu64 " of them silent, %" PRIu64
           " findings\n",
           seed, programs, test.silent_programs, test.findings);
    machine_close(&test.machine);
    fixture_close(&test.fixture);
    return test.failed ? 1 : 0;
}
