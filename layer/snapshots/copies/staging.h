/* SPDX-License-Identifier: Apache-2.0 */
/* Host-visible memory that the device copies inputs of builds to, and results from. Chunks that
 * come back are kept for the next recording. */
#ifndef ASSAY_LAYER_SNAPSHOTS_COPIES_STAGING_H
#define ASSAY_LAYER_SNAPSHOTS_COPIES_STAGING_H

#include "layer/snapshots/snapshots.h"
#include "src/snapshots/recording.h"

struct staging_chunk {
    struct snapshot_chunk chunk; /* first */
    struct own_buffer buffer;
    struct staging_chunk *next;
};

/* `budget`: bytes that all chunks have at most, those kept for later too. */
VkResult staging_create(struct layer_device *device, uint64_t budget, struct staging **staging);
void staging_destroy(struct staging *staging); /* NULL: nothing */

/* A chunk of at least `size` bytes, nothing of it used: VK_NOT_READY where that is beyond the
 * budget as long as others have theirs, else an error without memory of either kind. From any
 * thread, as is giving it back. */
VkResult staging_take(struct staging *staging, uint64_t size, struct staging_chunk **chunk);
void staging_give_back(struct staging *staging, struct staging_chunk *chunk);

#endif
