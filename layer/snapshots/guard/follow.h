/* SPDX-License-Identifier: Apache-2.0 */
/* Called when what instances may refer to has changed, and before a submission. */
#ifndef ASSAY_LAYER_SNAPSHOTS_GUARD_FOLLOW_H
#define ASSAY_LAYER_SNAPSHOTS_GUARD_FOLLOW_H

#include "layer/snapshots/guard/references.h"
#include "layer/snapshots/snapshots.h"

static inline void guard_follow(const struct layer_device *device)
{
    if (device->snapshots && device->snapshots->guard)
        guard_update(device->snapshots->guard);
}

#endif
