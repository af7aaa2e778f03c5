/* SPDX-License-Identifier: Apache-2.0 */
/* Reads what builds of clusters and of partitioned structures have read. */
#ifndef ASSAY_CHECK_CONTENT_CLUSTERS_H
#define ASSAY_CHECK_CONTENT_CLUSTERS_H

#include "src/check/walk/walk.h"
#include "src/model/clusters.h"
#include "src/snapshots/memory.h"

/* Evaluates the rules of level CONTENT about a build of a command buffer. `memory` has the copies
 * of its arrays; what is missing is not validated. */
void content_check_addressed(struct walk *walk, const struct call_view *call,
                             const struct addressed_build *build,
                             const struct input_memory *memory);

#endif
