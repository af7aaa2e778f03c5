/* SPDX-License-Identifier: Apache-2.0 */
/* Queue of executions whose snapshots wait to be validated: a consumer of snapshots at level
 * CONTENT. */
#ifndef ASSAY_LAYER_EXECUTION_INPUT_CHECKS_H
#define ASSAY_LAYER_EXECUTION_INPUT_CHECKS_H

#include "layer/layer.h"
#include "layer/snapshots/consumers.h"
#include "src/check/replay/update_inputs.h"

struct batch_run;

/* Sets layer_device.input_checks; leaves it NULL below level CONTENT, and for a device without
 * snapshots. */
VkResult input_checks_create(struct layer_device *device);
void input_checks_destroy(struct input_checks *input_checks); /* accepts NULL */
/* The consumer, for snapshots_add_consumer(). It lives as long as `input_checks`. */
struct snapshots_consumer *input_checks_consumer(struct input_checks *input_checks);

/* The hooks of the execution order call these three functions, one thread at a time. */

/* Called when a batch is replayed. Returns one list of notes for each of its commands, which the
 * replay fills. Lists are kept in the order in which batches run. Returns NULL if `input_checks` is
 * NULL, or without memory. */
struct input_notes *input_checks_note_batch(struct input_checks *input_checks,
                                            const struct batch_run *run);
/* Drops all lists that were returned for batches which have not run: their submission failed. */
void input_checks_drop(struct input_checks *input_checks);
/* Called when the batch has run. */
void input_checks_end_batch(struct input_checks *input_checks, const struct batch_run *run);

/* Validates the executions whose completion the application has observed. Calls that destroy
 * something do not call this. Accepts NULL. */
void input_checks_deliver(struct input_checks *input_checks);

/* Validates the builds whose inputs have been copied, though their executions are not complete.
 * `when` says why. Returns false if another thread validates now. */
bool input_checks_read_marked(struct input_checks *input_checks, const char *when);

/* The first ticket with a higher number than `after` of an execution that waits to be validated, on
 * a queue or, if that is VK_NULL_HANDLE, on any. The caller releases it. NULL: none. */
struct ticket *input_checks_next_ticket(struct input_checks *input_checks, VkQueue queue,
                                        uint64_t after);

#endif
