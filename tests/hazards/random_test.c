/* SPDX-License-Identifier: Apache-2.0 */
/* Random programs: the hazard check finds what the model finds, byte by byte. A program that
 * differs is shrunk and printed; ASSAY_TEST_SEED with its seed repeats it. */
#include <inttypes.h>
#include <stdio.h>

#include "program.h"
#include "tests/unit/random.h"
#include "tests/unit/unit_test.h"

static bool differs(const struct program *program, struct findings *model, struct findings *engine)
{
    model_play(program, model);
    program_play(program, engine);
    return !findings_equal(model, engine);
}

/* Removes steps and barriers as long as the program differs. */
static void shrink(struct program *program)
{
    static struct findings model, engine;
    for (uint32_t i = program->count; i--;) {
        struct program smaller = *program;
        program_remove(&smaller, i);
        if (differs(&smaller, &model, &engine)) {
            *program = smaller;
            i = program->count;
            continue;
        }
        smaller = *program;
        if (smaller.steps[i].barrier_count > 1) {
            smaller.steps[i].barrier_count--;
            if (differs(&smaller, &model, &engine))
                *program = smaller;
        }
    }
}

/* Returns the number of findings. */
static uint32_t compare(const struct program *program, struct findings *model)
{
    static struct findings engine;
    if (!differs(program, model, &engine))
        return model->count;
    struct program shrunk = *program;
    shrink(&shrunk);
    differs(&shrunk, model, &engine);
    program_print(&shrunk);
    findings_print("the model finds", model);
    findings_print("the check finds", &engine);
    fail_msg("they differ; ASSAY_TEST_SEED=%" PRIu64 " repeats it", program->seed);
    return 0;
}

TEST(random_programs_agree_with_the_model)
{
    static struct program program;
    static struct findings findings;
    uint64_t seed = random_of("hazards_random").state, count = 0, clean = 0;
    for (uint32_t i = 0; i < HAZARD_PROGRAMS; i++) {
        program_generate(&program, seed + i);
        uint32_t found = compare(&program, &findings);
        count += found;
        clean += !found;
    }
    print_message("%u programs, %" PRIu64 " findings, %" PRIu64 " programs without\n",
                  HAZARD_PROGRAMS, count, clean);
}
