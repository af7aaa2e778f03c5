/* SPDX-License-Identifier: Apache-2.0 */
/* Tracks the state of a command buffer that a dispatch of the layer's own disturbs, so that it can
 * be restored: compute bindings and push constants. */
#ifndef ASSAY_LAYER_SNAPSHOTS_COPIES_COMPUTE_STATE_H
#define ASSAY_LAYER_SNAPSHOTS_COPIES_COMPUTE_STATE_H

#include "layer/snapshots/recorder.h"

/* The state of a command buffer. Returns NULL if it is not tracked. */
struct compute_state *compute_state_of(const struct layer_device *device, VkCommandBuffer handle);

void compute_state_restore(const struct recorder *recorder);

#endif
