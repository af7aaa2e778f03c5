/* SPDX-License-Identifier: Apache-2.0 */
/* What guarded builds may refer to, in execution order. */
#ifndef ASSAY_LAYER_SNAPSHOTS_GUARD_EXECUTION_H
#define ASSAY_LAYER_SNAPSHOTS_GUARD_EXECUTION_H

#include "layer/layer.h"
#include "src/state/order/order.h"

/* Called when a submission of the calling thread begins. Its builds have no limits until its
 * batches are checked: if a batch is not checked before the call goes down, its place in execution
 * order is unknown, and each live structure counts as built. */
void guard_begin_submission(void);
/* How many batches of the calling thread's submission have limits, from the first on. */
uint32_t guard_limited_batches(void);

/* Sets the limits of the builds of a batch that is checked before its call goes down. Add it only
 * if the device has a guard. */
struct batch_consumer guard_consumer(struct layer_device *device);

#endif
