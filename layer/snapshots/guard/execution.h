/* SPDX-License-Identifier: Apache-2.0 */
/* What guarded builds may refer to, in execution order. */
#ifndef ASSAY_LAYER_SNAPSHOTS_GUARD_EXECUTION_H
#define ASSAY_LAYER_SNAPSHOTS_GUARD_EXECUTION_H

#include "layer/layer.h"
#include "layer/snapshots/copies/copies.h"
#include "layer/snapshots/snapshots.h"
#include "src/snapshots/recorded_build.h"
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

/* ---- the orders of guarded builds: written before each submission, read when it has completed */

/* The order of a guarded build, in the memory that the device reads. */
static inline struct guard_order *guard_order_of(const struct recording *recording,
                                                 const struct build_guard *guard)
{
    return (void *)snapshot_bytes(recording, &guard->order);
}

/* The size in bytes of a list of ranges with structures that have no handle, with room for later
 * ones. 0: such structures may be anywhere, or the device has none. */
uint64_t guard_places_size(const struct layer_device *device);

/* Writes the orders of a recording that is about to be submitted. `has_limits`: its builds have
 * limits; else each live structure counts as built. `is_pending`: the device still executes an
 * earlier submission, which reads the same orders. They stay as they are, but for three members,
 * which count for both submissions from now on: a higher limit; structures without a handle may be
 * anywhere; and all memory is readable, if the list of readable memory has changed. Does not
 * include secondaries. Call with the lock of executions. */
void guard_renew(const struct layer_device *device, const struct recording *recording,
                 const struct execution_clock *seen, bool is_pending, bool has_limits);

/* ---- what the guard replaced in the builds of one execution */

/* Zero-initialized is empty. */
struct guard_results {
    struct guard_result {
        const struct journal *journal;
        uint32_t position;   /* of the build in the command buffer */
        bool is_partitioned; /* then it has none */
        uint32_t replaced, first_replaced, unreadable;
        bool is_reported;
    } * items;
    uint32_t count, capacity;
};

/* Adds the result of a build if the guard replaced something. `bases` points to the bytes of each
 * chunk of the recording. Without memory the result is missing. */
void guard_results_add(struct guard_results *results, const struct journal *journal,
                       const struct recorded_build *build, unsigned char *const *bases);

/* Returns the number of references of the build that were replaced, if a finding of the rule
 * explains that; else 0. */
uint32_t guard_results_explain(struct guard_results *results, const struct journal *journal,
                               uint32_t position, enum rule rule);

/* Warns of the replacements that no finding explains, and empties the results. */
void guard_results_end(struct guard_results *results, const struct layer_device *device);

#endif
