/* SPDX-License-Identifier: Apache-2.0 */
/* What a shader of the layer may read is decided at each submission. */
#ifndef ASSAY_LAYER_SNAPSHOTS_COPIES_RENEW_H
#define ASSAY_LAYER_SNAPSHOTS_COPIES_RENEW_H

#include "layer/snapshots/snapshots.h"

/* Before a recording is submitted with the ticket `next`: buffers have come and gone since it was
 * recorded. What the device still executes stays as it is. Likewise for secondaries. */
void copy_orders_renew(const struct layer_device *device, struct recording *recording,
                       const struct ticket *next);

#endif
