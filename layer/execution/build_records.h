/* SPDX-License-Identifier: Apache-2.0 */
/* Setting record_builds: logs the submissions, builds and copies that a batch executes, and the
 * structures that are destroyed. */
#ifndef ASSAY_LAYER_EXECUTION_BUILD_RECORDS_H
#define ASSAY_LAYER_EXECUTION_BUILD_RECORDS_H

#include "src/state/order/order.h"

struct instance_uses;
struct layer_device;

/* Logs each batch at its execution point. Add it only if the setting is on. */
struct batch_consumer build_records_consumer(struct layer_device *device);

/* Logs a compacted size that the application has read. */
void build_records_add_size(const struct layer_device *device, VkAccelerationStructureKHR structure,
                            VkDeviceSize compacted_size);

/* A build whose instances were read at level content. */
struct recorded_instances {
    const struct layer_device *device;
    const struct order_batch *batch;
    VkCommandBuffer command_buffer;
    uint32_t position;
    VkAccelerationStructureKHR dst;
};

/* Logs what the instances refer to: the first structures, and how many there are. The lock of an
 * execution may be held: the log calls no callback. */
void build_records_add_instances(const struct recorded_instances *instances,
                                 const struct instance_uses *uses);

/* Logs that the application destroys a structure, if the setting is on. Ignores 0. */
void build_records_add_destroyed(const struct layer_device *device, VkObjectType type,
                                 uint64_t structure);

#endif
