/* SPDX-License-Identifier: Apache-2.0 */
/* A model of the hazard check, as close to the specification's definitions as can be (chapter
 * Synchronization and Cache Control, Execution and Memory Dependencies).
 *
 * It lists all accesses and all dependencies. For each byte of each access it computes which
 * dependencies the access happens before, by the definition of execution dependency chains, and
 * whether it is available there. It judges one byte at a time, so a buffer barrier is a barrier
 * with access scopes for some bytes and without for others. */
#ifndef ASSAY_TESTS_HAZARDS_MODEL_H
#define ASSAY_TESTS_HAZARDS_MODEL_H

#include "program.h"

/* What the program's hazards are. The result is sorted. */
void model_play(const struct program *program, struct findings *findings);

#endif
