/* SPDX-License-Identifier: Apache-2.0 */
/* The state of a command buffer that a dispatch of the layer's own disturbs, followed so that it
 * can be restored: what is bound for compute, and push constants. */
#ifndef ASSAY_LAYER_SNAPSHOTS_COMPUTE_STATE_H
#define ASSAY_LAYER_SNAPSHOTS_COMPUTE_STATE_H

#include "snapshots/recorder.h"

void compute_state_restore(const struct recorder *recorder);

#endif
