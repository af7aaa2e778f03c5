/* SPDX-License-Identifier: Apache-2.0 */
/* Random programs, and programs in which one bit of a dependency is missing. */
#ifndef ASSAY_TESTS_HAZARDS_GENERATOR_H
#define ASSAY_TESTS_HAZARDS_GENERATOR_H

#include "program.h"

/* The program of a seed: 10 to 40 steps. */
void program_generate(struct program *program, uint64_t seed);

/* What a mutation takes away. */
enum mutated_field {
    MUTATE_SRC_STAGES,
    MUTATE_DST_STAGES,
    MUTATE_SRC_KINDS,
    MUTATE_DST_KINDS,
    MUTATE_BYTES, /* the first, or the last */
    MUTATE_IS_GLOBAL,
    MUTATE_IS_ACQUISITION,
    MUTATE_EVENT_STAGES,
    MUTATE_EVENT_SRC_KINDS,
    MUTATE_EVENT_DST_STAGES,
    MUTATE_EVENT_DST_KINDS,
    MUTATE_SIGNAL_STAGES,
    MUTATE_WAIT_STAGES,
    MUTATE_COMPLETED,
    MUTATE_UNCERTAIN,
    MUTATED_FIELDS,
};

struct mutation {
    enum mutated_field field;
    uint32_t bit; /* a stage, a kind, a queue; else 0 */
};

/* Applies mutation number `index` to the program. Returns false, and leaves the program as it is,
 * if there are fewer. */
bool program_mutate(struct program *program, uint32_t index, struct mutation *mutation);

#endif
