/* SPDX-License-Identifier: Apache-2.0 */
/* Random programs, played on the layer and on the model at once. */
#ifndef EXECUTION_RANDOM_TEST_H
#define EXECUTION_RANDOM_TEST_H

#include "machine.h"
#include "model.h"
#include "tests/state/random.h"

enum { STEPS_MAX = 512 };

struct random_test {
    struct fixture fixture;
    struct machine machine;
    struct model model;
    struct random random;
    bool executable[COMMAND_BUFFERS], pending[COMMAND_BUFFERS], uses[COMMAND_BUFFERS][STRUCTURES];
    bool executes[COMMAND_BUFFERS][COMMAND_BUFFERS];
    uint32_t values[QUEUES];       /* of the timelines, as submitted */
    uint32_t first_values[QUEUES]; /* when the program began */
    uint32_t awaited;              /* of the leader's timeline, by the other queue */
    int binary_signal[SEMAPHORES]; /* the batch that has signalled it; -1: none */
    struct {
        struct operation operation;
        uint32_t batch;
        bool is_deferred, fails;
    } works[DEFERRED_OPERATIONS + 1]; /* of the host, by the operation that they are deferred to */
    uint32_t leader;                  /* the queue whose future signals the other may wait for */
    struct step steps[STEPS_MAX];
    uint32_t step_count;
    uint64_t findings, silent_programs;
    bool failed;
};

/* ---- dice, steps, and the comparison with the model (random_steps.c) */

uint32_t below(struct random_test *test, uint32_t bound);
bool chance(struct random_test *test, uint32_t percent);
struct shape random_shape(struct random_test *test);

void take_step(struct random_test *test, struct step step);
/* Ends a group of steps whose findings the model knows by now. */
void settle(struct random_test *test);
bool has_findings(const struct model *model);

/* random_host.c: a command of the host; and the completion of an operation, if it has work. */
void work_on_host(struct random_test *test);
void join(struct random_test *test, uint32_t operation);

#endif
