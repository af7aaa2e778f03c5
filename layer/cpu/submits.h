/* SPDX-License-Identifier: Apache-2.0 */
/* What backend cpu is told of submissions: when the turn of each execution comes, and when the
 * application may learn that some are complete. */
#ifndef ASSAY_LAYER_CPU_SUBMITS_H
#define ASSAY_LAYER_CPU_SUBMITS_H

#include "layer/cpu/overlay.h"

/* The turn of an execution, in a batch that executes at `moment`. */
void cpu_overlay_run(const struct layer_device *device, struct execution *execution,
                     struct timestamp timestamp);

/* Writes the results of complete submissions to their buffers. */
void cpu_overlay_deliver(struct layer_device *device);
/* Says once each if something was built of what an execution no longer had, and if something could
 * not be built because the driver has not executed the copies. */
void cpu_overlay_warn_overwritten(const struct layer_device *device);

#endif
