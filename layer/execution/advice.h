/* SPDX-License-Identifier: Apache-2.0 */
/* Setting advice: follows what becomes of each structure, judges it when it is destroyed, or the
 * device or the instance is, and lists what it is advised (src/report/advice_list.h). Silent from
 * when the order of submissions is unknown. */
#ifndef ASSAY_LAYER_EXECUTION_ADVICE_H
#define ASSAY_LAYER_EXECUTION_ADVICE_H

#include "layer/layer.h"

struct advice_list;
struct instance_uses;
struct refit;

/* Does nothing if the setting is off. Call once the device has an order. */
VkResult advice_create(struct layer_device *device);
void advice_destroy(struct device_advice *advice); /* accepts NULL */

/* Notes in execution order what batches do with structures. */
struct batch_consumer advice_consumer(struct device_advice *advice);

/* Call before the structure and its name are forgotten. `advice` may be NULL. */
void advice_judge_destroyed(struct device_advice *advice, VkAccelerationStructureKHR accel);

/* Judges the structures that are alive, and sends the list. Call when the work of the device is
 * complete and its input data was read, and without a lock: the device is destroyed (`is_end`), or
 * its instance, and the application has left the device behind. `advice` may be NULL. */
void advice_send(struct device_advice *advice, bool is_end);

/* Sends what is certain by now. Call without a lock. `advice` may be NULL. */
void advice_send_certain(const struct device_advice *advice);

/* Adds an advice about a live object to the list, with its name. Any thread. */
void advice_add(struct device_advice *advice, enum advice id, VkObjectType type, uint64_t object,
                const struct finding *finding, uint64_t weight);

/* Has the tree of an update compared with a new one. `id`: of the structure. Any thread. */
void advice_add_refit(struct device_advice *advice, uint64_t id, VkAccelerationStructureKHR accel,
                      const struct refit *refit);

/* The layer knows all structures that one executed build of a top-level structure refers to, and
 * has noted that. Any thread. */
void advice_note_references(struct device_advice *advice, const struct instance_uses *uses);

#endif
