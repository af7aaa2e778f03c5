/* SPDX-License-Identifier: Apache-2.0 */
/* Validates the snapshots of one execution. */
#ifndef ASSAY_LAYER_EXECUTION_INPUT_CHECK_RUN_H
#define ASSAY_LAYER_EXECUTION_INPUT_CHECK_RUN_H

#include "layer/layer.h"
#include "src/check/replay/update_inputs.h"
#include "src/snapshots/recording.h"
#include "src/state/order/batch.h"

struct missed_executions;

/* A complete execution of a command buffer. */
struct ran_execution {
    struct layer_device *device;
    struct order_batch *batch;
    const struct journal *journal; /* of the command buffer; belongs to the batch */
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
