/* SPDX-License-Identifier: Apache-2.0 */
/* Snapshots of the instances to which an array of pointers points: a compute shader of the layer's
 * own gathers them at that point of the command buffer. */
#ifndef ASSAY_LAYER_SNAPSHOTS_COPIES_GATHER_H
#define ASSAY_LAYER_SNAPSHOTS_COPIES_GATHER_H

#include "layer/snapshots/recorder.h"

/* Records the gathering of instances from the 64-bit addresses in `addresses`, a snapshot that the
 * recorder has copied. Fills in the rest of `gathering`. Returns false if there are no addresses,
 * without memory, or if the driver cannot create the pipeline. */
bool recorder_gather(struct recorder *recorder, const struct snapshot *addresses,
                     struct gathering *gathering);

/* Updates the list of readable memory ranges before a recording is submitted, because memory was
 * allocated and freed since it was recorded. Call while the device does not execute the recording.
 * Secondaries are not included. */
void gather_renew_ranges(const struct layer_device *device, const struct recording *recording);

/* The size in bytes of a list of memory ranges, with room for later ones. */
uint64_t gather_ranges_size(struct resources *resources);
/* Writes the ranges of memory that are readable now, and fills up the list with ranges behind all
 * addresses. Returns false if they do not fit. */
bool gather_write_ranges(struct resources *resources, unsigned char *bytes, uint64_t size);

#endif
