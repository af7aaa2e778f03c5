/* SPDX-License-Identifier: Apache-2.0 */
/* What the guard replaced in the builds of one execution. */
#ifndef ASSAY_LAYER_SNAPSHOTS_GUARD_RESULTS_H
#define ASSAY_LAYER_SNAPSHOTS_GUARD_RESULTS_H

#include "layer/layer.h"
#include "src/snapshots/recorded_build.h"

/* Zero-initialized is empty. */
struct guard_results {
    struct guard_result {
        const struct journal *journal;
        uint32_t position; /* of the build in the command buffer */
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
