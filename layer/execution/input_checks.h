/* SPDX-License-Identifier: Apache-2.0 */
/* Validates the snapshots of executions, at level CONTENT: a consumer that keeps batches from their
 * execution point until they are complete. */
#ifndef ASSAY_LAYER_EXECUTION_INPUT_CHECKS_H
#define ASSAY_LAYER_EXECUTION_INPUT_CHECKS_H

#include "layer/layer.h"
#include "src/check/replay/update_inputs.h"
#include "src/snapshots/recording.h"
#include "src/state/order/batch.h"
#include "src/state/order/order.h"

/* Sets layer_device.input_checks; leaves it NULL below level CONTENT, and for a device without
 * snapshots. */
VkResult input_checks_create(struct layer_device *device);
void input_checks_destroy(struct input_checks *input_checks); /* accepts NULL */
/* Add it once the device has an order. */
struct batch_consumer input_checks_consumer(struct input_checks *input_checks);

/* Called when a batch is replayed: the list of notes of its command buffer at `command`, which the
 * replay fills. Returns NULL if `input_checks` is NULL, or without memory. */
struct input_notes *input_checks_note(struct input_checks *input_checks, struct order_batch *batch,
                                      uint32_t command);

/* Validates the executions whose completion the application has observed. Calls that destroy
 * something do not call this. Accepts NULL. */
void input_checks_deliver(struct input_checks *input_checks);

/* Validates the builds whose inputs have been copied, though their executions are not complete, or
 * the calls that submit them have not returned. `when` says why. Returns false if another thread
 * validates now. Accepts NULL. */
bool input_checks_read_marked(struct input_checks *input_checks, const char *when);

/* The first ticket with a higher number than `after` of an execution that waits to be validated, on
 * a queue or, if that is VK_NULL_HANDLE, on any. The caller releases it. NULL: none. */
struct ticket *input_checks_next_ticket(struct input_checks *input_checks, VkQueue queue,
                                        uint64_t after);

/* ---- one execution */

struct missed_executions;

/* An execution of a command buffer. */
struct ran_execution {
    struct layer_device *device;
    struct order_batch *batch;
    uint32_t command; /* index of the command buffer in the batch */
    struct execution *execution;
    struct input_notes notes;
    bool is_complete; /* false: not yet, or the device was lost */
};

/* Validates the snapshots and reports the findings, with no lock held. Counts in `missed` what
 * could not be validated. `when`: NULL, or why the execution is read before it is complete, for the
 * messages: then only builds are validated whose mark says that their inputs were copied, and each
 * only once. */
void input_checks_read(const struct ran_execution *ran, const char *when,
                       struct missed_executions *missed);

#endif
