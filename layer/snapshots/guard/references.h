/* SPDX-License-Identifier: Apache-2.0 */
/* The references that instances of guarded builds may have: a table in memory that the host writes
 * and guard.comp reads. It has an entry for each live structure, with the count of the build that
 * wrote it first.
 *
 * There is one table for a device, and it always describes the present. So a submission that waits
 * for the host finds the structures that were created meanwhile. What a past submission may refer
 * to is decided by the limit of its order (execution.c): builds are counted in execution order, and
 * a structure counts as built for an order whose limit is not below the structure's count. */
#ifndef ASSAY_LAYER_SNAPSHOTS_GUARD_REFERENCES_H
#define ASSAY_LAYER_SNAPSHOTS_GUARD_REFERENCES_H

#include "layer/layer.h"
#include "layer/snapshots/snapshots.h"
#include "src/state/order/clock.h"

struct guard;
struct staging;

/* Sets *guard to NULL if setting guard is off, or has no effect on this device. `budget`: the most
 * bytes of guarded copies. */
VkResult guard_create(struct layer_device *device, uint64_t budget, struct guard **guard);
void guard_destroy(struct guard *guard); /* accepts NULL */

/* Creates the table on first use. Returns its address, or 0 without memory. */
VkDeviceAddress guard_table(struct guard *guard);
/* The memory of guarded copies. */
struct staging *guard_memory(const struct guard *guard);

/* Takes over what was created and destroyed since the last call. Called after a structure was
 * created, and before each submission. */
void guard_update(struct guard *guard);

/* ---- Only the hooks of the execution order call these, one thread at a time. */

/* The count of the next build. After 2^32 builds it stays at GUARD_UNLIMITED. */
uint32_t guard_next_count(const struct guard *guard);
/* A structure has been built: counts the build, and renews the table if it is the structure's
 * first. `count`: of the build; 0 if the structure counts as built for all orders, because they may
 * follow the build. */
void guard_note_built(struct guard *guard, uint64_t handle, uint64_t id, uint32_t count);

/* The submissions with guarded builds that have limits. */
struct execution_clock *guard_clock(struct guard *guard);

#define GUARD_LACKS_MEMORY "there was no memory for copies of them (content_budget_mib)"
/* Sends one warning for a device: builds are not guarded, for this reason. Accepts NULL. */
void guard_warn_unguarded(struct guard *guard, const char *reason);

/* ---- called when what instances may refer to has changed, and before a submission */

static inline void guard_follow(const struct layer_device *device)
{
    if (device->snapshots && device->snapshots->guard)
        guard_update(device->snapshots->guard);
}

#endif
