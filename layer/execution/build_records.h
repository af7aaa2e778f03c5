/* SPDX-License-Identifier: Apache-2.0 */
/* Setting record_builds: logs the submissions, builds and copies that a batch executes, and the
 * structures that are destroyed. */
#ifndef ASSAY_LAYER_EXECUTION_BUILD_RECORDS_H
#define ASSAY_LAYER_EXECUTION_BUILD_RECORDS_H

#include "src/state/order/order.h"

struct instance_uses;
struct journal;
struct journal_entry;
struct layer_device;
struct log_record;

/* Logs each batch at its execution point. Add it only if the setting is on. */
struct batch_consumer build_records_consumer(struct layer_device *device);

/* What takes the records of a command buffer, one for each entry of its journals that has one. */
struct record_sink {
    void (*add)(void *user, const struct journal *journal, const struct journal_entry *entry,
                const struct log_record *record);
    void *user;
};
/* Gives the sink the records of one command buffer of a batch that runs, also of queries, and of
 * builds that write no structure that is known. */
void build_records_walk(const struct layer_device *device, const struct order_batch *batch,
                        uint32_t command, const struct record_sink *sink);

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
