/* SPDX-License-Identifier: Apache-2.0 */
/* What submitted command buffers do to acceleration structures: replays their journals in execution
 * order against the last build of each structure. */
#ifndef ASSAY_LAYER_EXECUTION_SUBMISSIONS_H
#define ASSAY_LAYER_EXECUTION_SUBMISSIONS_H

#include "src/state/order/order.h"

struct layer_device;
struct submissions;

VkResult submissions_create(struct layer_device *device, struct submissions **submissions);
void submissions_destroy(struct submissions *submissions);

/* The hooks through which the execution order gets journals, and the consumer that replays them. It
 * sets order_batch.is_replayed and comes before consumers that read this. */
struct execution_hooks submissions_hooks(struct submissions *submissions);
struct batch_consumer submissions_consumer(struct submissions *submissions);

#endif
