/* SPDX-License-Identifier: Apache-2.0 */
/* Reads what builds of clusters and of partitioned structures have read. */
#ifndef ASSAY_CHECK_CONTENT_CLUSTERS_H
#define ASSAY_CHECK_CONTENT_CLUSTERS_H

#include "src/check/walk/walk.h"
#include "src/model/clusters.h"
#include "src/snapshots/memory.h"

/* What a build of a command buffer has read. `memory` has copies of its arrays: what is missing is
 * not validated. */
struct addressed_read {
    const struct addressed_build *build;
    const struct input_memory *memory;
    uint64_t place;  /* see places_execute() */
    uint32_t number; /* of the build in its command buffer */
};

/* Evaluates the rules of level CONTENT about a build. */
void content_check_addressed(struct walk *walk, const struct call_view *call,
                             const struct addressed_read *read);

#endif
