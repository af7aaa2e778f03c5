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

/* Ends the program where there is no null driver. */
void random_test_open(struct random_test *test, const struct platform *platform);

/* Plays one program, which depends on test->random alone; sets test->failed where layer and model
 * differ, and prints how. */
void random_test_play(struct random_test *test);

#endif
