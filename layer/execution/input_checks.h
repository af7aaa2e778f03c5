/* SPDX-License-Identifier: Apache-2.0 */
/* What builds of command buffers have read, put to the rules about it once they have executed; at
 * level CONTENT. */
#ifndef ASSAY_LAYER_EXECUTION_INPUT_CHECKS_H
#define ASSAY_LAYER_EXECUTION_INPUT_CHECKS_H

#include "layer/layer.h"
#include "src/check/replay/update_inputs.h"
#include "src/snapshots/recording.h"

struct batch_run;

/* layer_device.contents; NULL below level CONTENT, and where nothing keeps snapshots. */
VkResult input_checks_create(struct layer_device *device);
void input_checks_destroy(struct input_checks *input_checks); /* NULL: nothing */

/* These four are called by one thread at a time, with the hooks of the execution order. */

/* A batch is replayed: the notes of its commands, one list each, in the order in which batches run.
 * NULL where nothing is to be noted. */
struct input_notes *input_checks_note_batch(struct input_checks *input_checks,
                                            const struct batch_run *run);
/* Those noted last will not run. */
void input_checks_drop(struct input_checks *input_checks);
/* The turn of a batch's command, whose snapshots the execution has; shares that. */
void input_checks_run(struct input_checks *input_checks, const struct batch_run *run,
                      uint32_t command, struct execution *execution);
/* The batch had its turn. */
void input_checks_end_batch(struct input_checks *input_checks, const struct batch_run *run);

/* Reports on the executions that are complete: also before something is destroyed that they may
 * have used. */
void input_checks_deliver(struct input_checks *input_checks);
/* The same, once the first of those that wait is complete; false where none is in a while. */
bool input_checks_wait(struct input_checks *input_checks);

/* ---- for input_checks_read.c */

/* An execution that had its turn. */
struct ran_execution {
    struct layer_device *device;
    struct execution *execution;
    struct journal *journal;
    VkQueue queue;
    struct input_notes notes;
};
/* Counts it as missed where not all of it could be. */
struct missed_executions;
void input_checks_read(const struct ran_execution *ran, struct missed_executions *missed);

#endif
