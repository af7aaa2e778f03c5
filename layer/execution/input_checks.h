/* SPDX-License-Identifier: Apache-2.0 */
/* Executions whose snapshots wait to be validated: a consumer of snapshots at level CONTENT. */
#ifndef ASSAY_LAYER_EXECUTION_INPUT_CHECKS_H
#define ASSAY_LAYER_EXECUTION_INPUT_CHECKS_H

#include "layer/layer.h"
#include "layer/snapshots/consumers.h"
#include "src/check/replay/update_inputs.h"

struct batch_run;

/* layer_device.contents; NULL below level CONTENT, and for a device without snapshots. */
VkResult input_checks_create(struct layer_device *device);
void input_checks_destroy(struct input_checks *input_checks); /* NULL: nothing */
/* For snapshots_add_consumer(). */
struct snapshots_consumer *input_checks_consumer(struct input_checks *input_checks);

/* These three are called by one thread at a time, with the hooks of the execution order. */

/* A batch is replayed: the notes of its commands, one list each, in the order in which batches run.
 * NULL where nothing is to be noted. */
struct input_notes *input_checks_note_batch(struct input_checks *input_checks,
                                            const struct batch_run *run);
/* Those noted last will not run. */
void input_checks_drop(struct input_checks *input_checks);
/* The batch had its turn. */
void input_checks_end_batch(struct input_checks *input_checks, const struct batch_run *run);

/* Validates the executions that are complete: also before something is destroyed that they may have
 * used. NULL: nothing. */
void input_checks_deliver(struct input_checks *input_checks);

#endif
