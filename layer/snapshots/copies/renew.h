/* SPDX-License-Identifier: Apache-2.0 */
/* Decides at each submission what a shader of the layer may read. */
#ifndef ASSAY_LAYER_SNAPSHOTS_COPIES_RENEW_H
#define ASSAY_LAYER_SNAPSHOTS_COPIES_RENEW_H

#include "layer/snapshots/snapshots.h"

/* Updates the orders of a recording and of its secondaries before it is submitted with the ticket
 * `next`, because buffers were created and destroyed since it was recorded. Orders that the device
 * still executes stay unchanged, except the limits of guarded builds. `has_limits`: see
 * guard_renew(). The lock of executions is held. */
void copy_orders_renew(const struct layer_device *device, struct recording *recording,
                       const struct ticket *next, bool has_limits);

#endif
