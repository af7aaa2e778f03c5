/* SPDX-License-Identifier: Apache-2.0 */
/* Small programs of batches, accesses and dependencies for src/hazards/hazards.h, and what is found
 * in them. A program is an array of steps, so that a test can remove one and play the rest. */
#ifndef ASSAY_TESTS_HAZARDS_PROGRAM_H
#define ASSAY_TESTS_HAZARDS_PROGRAM_H

#include <stdbool.h>
#include <stdint.h>

#include "src/hazards/hazards.h"

enum {
    PROGRAM_QUEUES = 4, /* the host, and three queues */
    PROGRAM_STEPS = 64,
    PROGRAM_BARRIERS = 3, /* of one command */
    PROGRAM_BYTES = 4,    /* of each memory */
    PROGRAM_SEMAPHORES = 2,
    PROGRAM_EVENTS = 2,
    PROGRAM_FINDINGS = 2048,
};

/* A prune and STEP_FORGET_MEMORY end the batch; all others but STEP_BATCH belong to it. */
enum step_type {
    STEP_BATCH,
    STEP_WAIT,
    STEP_SIGNAL,
    STEP_ACCESS,
    STEP_BARRIERS,
    STEP_SET_EVENT,
    STEP_RESET_EVENT,
    STEP_WAIT_EVENT,
    STEP_PRUNE,
    STEP_FORGET_MEMORY,
};

struct step {
    enum step_type type;
    /* STEP_BATCH, and `completed` of STEP_PRUNE: as in struct hazard_batch */
    uint32_t queue;
    uint64_t number, completed[PROGRAM_QUEUES], before[PROGRAM_QUEUES];
    bool is_certain;
    /* a semaphore, an event or a memory; the value of a semaphore */
    uint64_t object, value;
    struct dependency dependency; /* dst of a wait; src of a signal and of a set event */
    struct hazard_access access;
    uint32_t command; /* of the access; the next number begins a command */
    struct hazard_barrier barriers[PROGRAM_BARRIERS];
    uint32_t barrier_count;
};

struct program {
    uint64_t seed;
    struct step steps[PROGRAM_STEPS];
    uint32_t count;
};

/* One byte of one hazard. Accesses are named by the index of their step. */
struct finding {
    uint8_t earlier, later, memory, byte, type, is_racing, is_ordered, is_available;
};

struct findings {
    struct finding rows[PROGRAM_FINDINGS];
    uint32_t count;
};

/* Adds a finding for each of the bytes. */
void findings_add(struct findings *findings, const struct finding *first, uint64_t end);
/* Sorts, and drops duplicates. */
void findings_sort(struct findings *findings);
bool findings_equal(const struct findings *a, const struct findings *b);
void findings_print(const char *title, const struct findings *findings);

/* What the hazard check finds. The result is sorted. */
void program_play(const struct program *program, struct findings *findings);
void program_print(const struct program *program);
/* Removes a step. With a batch, all its steps go. */
void program_remove(struct program *program, uint32_t step);

/* ---- the model (model.c) */

/* What the program's hazards are. The result is sorted. */
void model_play(const struct program *program, struct findings *findings);

/* ---- random programs (generator.c) */

/* The program of a seed: 10 to 40 steps. */
void program_generate(struct program *program, uint64_t seed);

#endif
