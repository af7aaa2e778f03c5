/* SPDX-License-Identifier: Apache-2.0 */
/* What intercepts that note commands in journals share. */
#ifndef ASSAY_LAYER_INTERCEPTS_JOURNAL_ACCESS_H
#define ASSAY_LAYER_INTERCEPTS_JOURNAL_ACCESS_H

#include "layer/layer.h"

/* The id of a structure in journals; 0: not known. */
uint64_t layer_accel_id(const struct layer_device *device, VkAccelerationStructureKHR handle);

/* The command buffer, if what it records is to be noted in its journal; else NULL. */
struct command_buffer *layer_find_recording(const struct layer_device *device,
                                            VkCommandBuffer handle);

/* Lets a command of the host take its turn among the batches; takes over the journal, which may be
 * NULL. */
void layer_carry_out(struct layer_device *device, struct journal *journal);

#endif
