/* SPDX-License-Identifier: Apache-2.0 */
/* Setting record_builds: logs the submissions, builds and copies that a batch executes. */
#ifndef ASSAY_LAYER_EXECUTION_BUILD_RECORDS_H
#define ASSAY_LAYER_EXECUTION_BUILD_RECORDS_H

#include <vulkan/vulkan_core.h>

struct batch_run;
struct layer_device;

/* Logs a batch at its execution point. Call it without a lock, and only if the setting is on. */
void build_records_add_batch(const struct layer_device *device, const struct batch_run *run);

/* Logs a compacted size that the application has read. */
void build_records_add_size(const struct layer_device *device, VkAccelerationStructureKHR structure,
                            VkDeviceSize compacted_size);

#endif
