/* SPDX-License-Identifier: Apache-2.0 */
/* Queries of the layer's own for the compacted size of the source of a compacting copy, just before
 * the copy. The pools belong to the recording, and the entry of the copy names the query. */
#ifndef ASSAY_LAYER_SNAPSHOTS_SIZE_QUERIES_H
#define ASSAY_LAYER_SNAPSHOTS_SIZE_QUERIES_H

#include "layer/snapshots/snapshots.h"

/* Whether the copy compacts a live structure into one that is smaller, and so may be too small, or
 * that may overlap it. */
bool size_query_is_needed(const struct layer_device *device,
                          const VkCopyAccelerationStructureInfoKHR *info);

/* Returns what the query of the copy `entry` has found in the submission of `ticket`, which is
 * complete, in bytes. Returns 0 if that is unknown. */
VkDeviceSize size_query_read(const struct layer_device *device, const struct journal *journal,
                             const struct journal_entry *entry, const struct ticket *ticket);

#endif
