/* SPDX-License-Identifier: Apache-2.0 */
/* What submitted command buffers do to acceleration structures: their journals, replayed in
 * execution order against what each structure was last built with. */
#ifndef ASSAY_LAYER_EXECUTION_SUBMISSIONS_H
#define ASSAY_LAYER_EXECUTION_SUBMISSIONS_H

#include "src/state/order/order.h"

struct layer_device;
struct submissions;

VkResult submissions_create(struct layer_device *device, struct submissions **submissions);
void submissions_destroy(struct submissions *submissions);

/* The order tells `submissions` of each batch through these. */
struct execution_hooks submissions_hooks(struct submissions *submissions);

/* Structures or queries were destroyed: `count` of consecutive ids, as in struct accel_facts and
 * struct query_pool. */
void submissions_forget(struct submissions *submissions, uint64_t first_id, uint32_t count);

#endif
