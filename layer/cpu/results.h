/* SPDX-License-Identifier: Apache-2.0 */
/* Backend cpu as a consumer of batches: it executes builds at their point in execution order, and
 * writes results to buffers when the submission is complete. */
#ifndef ASSAY_LAYER_CPU_RESULTS_H
#define ASSAY_LAYER_CPU_RESULTS_H

#include "layer/cpu/overlay.h"

/* For a device with device->cpu. */
struct batch_consumer cpu_overlay_consumer(struct layer_device *device);

/* Called before the device is destroyed: frees copies of results whose end was not observed. What
 * the device may still use stays until it is destroyed. `overlay` may be NULL. */
void cpu_overlay_end_transfers(struct cpu_overlay *overlay);

/* Warns once if something was built from the copies of a later execution, and once if something
 * could not be built because the driver has not executed the copies. */
void cpu_overlay_warn_overwritten(const struct layer_device *device);

#endif
