/* SPDX-License-Identifier: Apache-2.0 */
/* Shared by the intercepts that record commands in journals. */
#ifndef ASSAY_LAYER_INTERCEPTS_JOURNAL_ACCESS_H
#define ASSAY_LAYER_INTERCEPTS_JOURNAL_ACCESS_H

#include "layer/layer.h"

/* The id of a structure in journals; 0 if it is unknown. */
uint64_t layer_accel_id(const struct layer_device *device, VkAccelerationStructureKHR handle);

/* The bytes from an address to the end of its VkBuffer; 0: unknown. */
VkDeviceSize layer_bytes_at(const struct layer_device *device, VkDeviceAddress address);

/* The command buffer, if its commands are recorded in a journal. Returns NULL otherwise. */
struct command_buffer *layer_find_recording(const struct layer_device *device,
                                            VkCommandBuffer handle);

/* Records what a command that builds no structures does, and validates it as far as the command
 * buffer knows its sources. Returns whether to skip the call. */
bool layer_record(struct layer_device *device, VkCommandBuffer handle,
                  struct journal_entry *entries, uint32_t count);

/* Places a host command in execution order among the batches. Takes ownership of the journal. If
 * that is NULL, because memory ran out, the order becomes unknown. */
void layer_run_host_command(struct layer_device *device, struct journal *journal);

#endif
