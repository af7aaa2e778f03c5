/* SPDX-License-Identifier: Apache-2.0 */
/* execution_model_test [--programs N] [--seed S] [--only N]
 *
 * Random programs on the null driver. A program depends on the seed and its own number alone, so
 * that
 * --only plays it again. */
#include "random_test.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static struct platform platform;

static void play_random(struct random_test *test, uint64_t number)
{
    struct program *program = &test->program;
    const uint64_t findings = test->findings;
    program->line_count = program->expected_count = 0;
    program->used = 0;
    test->played = 0;
    snprintf(program->name, sizeof(program->name), "program %" PRIu64, number);
    test->play.program = program;
    add_line(test, "driver recycles");
    random_start(test);
    for (uint32_t i = 4 + below(test, 24); i > 0; i--)
        random_step(test);
    random_finish(test);
    test->silent_programs += test->findings == findings;
}

/* The layer lets held batches of the queue go first that it got to know first. */
static void open_play(struct random_test *test)
{
    static struct program program = {.name = "the queues"};
    test->play = (struct play){.platform = &platform};
    program_add(&program, "driver recycles", 1);
    program_add(&program, "submit q0; submit q2; host wait idle", 2);
    if (!play_begin(&test->play, &program) || !play_line(&test->play, 1))
        exit(1);
}

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
    static struct random_test test;
    const uint64_t programs = read_number(argc, argv, "--programs", PROGRAMS);
    const uint64_t seed = read_number(argc, argv, "--seed", random_seed(20261121));
    const uint64_t only = read_number(argc, argv, "--only", UINT64_MAX);
    setenv("VK_ASSAY_VALIDATION_ENABLE_MESSAGE_LIMIT", "false", 1);
    const char *missing = platform_open(&platform, "null");
    if (missing != NULL) {
        printf("%s\n", missing);
        return 1;
    }
    differences_fill();
    open_play(&test);
    for (uint64_t i = 0; i < programs && test.play.report.outcome == OUTCOME_PASSED; i++) {
        if (only != UINT64_MAX && i != only)
            continue;
        test.random.state = seed + (i << 32);
        play_random(&test, i);
        if (test.play.report.outcome != OUTCOME_PASSED)
            printf("%s\nseed %" PRIu64 "\n", test.play.report.text, seed);
    }
    printf("seed %" PRIu64 ": %" PRIu64 " programs, %" PRIu64 " of them silent, %" PRIu64
           " findings\n",
           seed, programs, test.silent_programs, test.findings);
    play_end(&test.play);
    play_close(&test.play);
    return test.play.report.outcome == OUTCOME_PASSED ? 0 : 1;
}
