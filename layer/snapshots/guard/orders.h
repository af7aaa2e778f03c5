/* SPDX-License-Identifier: Apache-2.0 */
/* The orders of guarded builds: written before each submission, read when it has completed. */
#ifndef ASSAY_LAYER_SNAPSHOTS_GUARD_ORDERS_H
#define ASSAY_LAYER_SNAPSHOTS_GUARD_ORDERS_H

#include "layer/snapshots/snapshots.h"

/* Writes the orders of a recording that is about to be submitted. `has_limits`: its builds have
 * limits; else each live structure counts as built. `is_pending`: the device still executes an
 * earlier submission, which reads the same orders: they stay as they are, but a higher limit counts
 * for both from now on. Secondaries are not included. The lock of executions is held. */
void guard_renew(const struct layer_device *device, const struct recording *recording,
                 const struct execution_clock *seen, bool is_pending, bool has_limits);

#endif
