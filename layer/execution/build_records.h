/* SPDX-License-Identifier: Apache-2.0 */
/* Setting record_builds: logs the submissions, builds and copies that a batch executes, and the
 * structures that are destroyed. */
#ifndef ASSAY_LAYER_EXECUTION_BUILD_RECORDS_H
#define ASSAY_LAYER_EXECUTION_BUILD_RECORDS_H

#include "src/state/order/order.h"

struct layer_device;

/* Logs each batch at its execution point. Add it only if the setting is on. */
struct batch_consumer build_records_consumer(struct layer_device *device);

/* Logs a compacted size that the application has read. */
void build_records_add_size(const struct layer_device *device, VkAccelerationStructureKHR structure,
                            VkDeviceSize compacted_size);

/* Logs that the application destroys a structure, if the setting is on. Ignores 0. */
void build_records_add_destroyed(const struct layer_device *device, VkObjectType type,
                                 uint64_t structure);

#endif
