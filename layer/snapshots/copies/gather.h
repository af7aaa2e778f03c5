/* SPDX-License-Identifier: Apache-2.0 */
/* Snapshots of what arrays of pointers point to: a compute shader of the layer's own gathers it
 * at that point of the command buffer. */
#ifndef ASSAY_LAYER_SNAPSHOTS_COPIES_GATHER_H
#define ASSAY_LAYER_SNAPSHOTS_COPIES_GATHER_H

#include "layer/snapshots/recorder.h"

/* Records the gathering of instances, from where the 64-bit addresses in `addresses` point to,
 * which is a snapshot that the recorder has copied, and fills in the rest of `gathering`. False
 * where there are none, without memory, or where the driver makes no such pipeline. */
bool recorder_gather(struct recorder *recorder, const struct snapshot *addresses,
                     struct gathering *gathering);

/* Before a recording is submitted, and while the device doesn't execute it: memory has come and
 * gone since it was recorded. Not of its secondaries. */
void gather_renew_ranges(const struct layer_device *device, const struct recording *recording);

#endif
