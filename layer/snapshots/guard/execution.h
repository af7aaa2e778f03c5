/* SPDX-License-Identifier: Apache-2.0 */
/* What guarded builds may refer to, in execution order. The hooks of the execution order call these
 * functions, one thread at a time, except guard_forget_limits(). */
#ifndef ASSAY_LAYER_SNAPSHOTS_GUARD_EXECUTION_H
#define ASSAY_LAYER_SNAPSHOTS_GUARD_EXECUTION_H

#include "layer/layer.h"
#include "src/state/order/order.h"

/* Called when a command buffer is submitted, before the batch is checked. Its builds have no limit
 * until then: if the batch is not checked before the call goes down, its place in execution order
 * is unknown, and each live structure counts as built. */
void guard_forget_limits(const struct layer_device *device, const struct journal *journal);

/* Called when a batch is checked before its call goes down: sets the limits of its builds. */
void guard_check(const struct layer_device *device, const struct batch_run *run);
/* Called when a batch runs. */
void guard_run(const struct layer_device *device, const struct batch_run *run);

#endif
