/* SPDX-License-Identifier: Apache-2.0 */
/* Host-visible memory to which the device copies inputs of builds, and from which results are
 * copied. Chunks that are given back are kept for later recordings. */
#ifndef ASSAY_LAYER_SNAPSHOTS_COPIES_STAGING_H
#define ASSAY_LAYER_SNAPSHOTS_COPIES_STAGING_H

#include "layer/snapshots/snapshots.h"
#include "src/snapshots/recording.h"

struct staging_chunk {
    struct snapshot_chunk chunk; /* first */
    struct own_buffer buffer;    /* `address` and `bytes` are those of the chunk */
    uint64_t offset;             /* of the chunk in the VkBuffer */
    struct staging_chunk *next;
    uint64_t given_back;         /* the number of submissions when the chunk was given back */
    struct staging_chunk *whole; /* the chunk that this one is a part of, or NULL */
    uint64_t units; /* one bit for each unit that is taken; of a part: for each that it has */
};

/* `budget`: the most bytes that all chunks may have, including those kept for later. `usage` is
 * that of the chunks' buffers; if they are not mapped, only the device uses them, and `bytes` is
 * NULL. */
VkResult staging_create(struct layer_device *device, uint64_t budget, VkBufferUsageFlags usage,
                        bool is_mapped, struct staging **staging);
void staging_destroy(struct staging *staging); /* accepts NULL */

/* Takes an unused chunk of at least `size` bytes. Returns VK_NOT_READY if the budget has no room
 * now, or an error without host or device memory. These functions may be called from any thread. */
VkResult staging_take(struct staging *staging, uint64_t size, struct staging_chunk **chunk);
/* Takes a chunk that may share its buffer with other chunks. So a small chunk takes little more of
 * the budget than `size`. */
VkResult staging_take_part(struct staging *staging, uint64_t size, struct staging_chunk **chunk);
void staging_give_back(struct staging *staging, struct staging_chunk *chunk);
/* Leaves the chunk's buffer to the device, which may still use it and will be destroyed. */
void staging_leave(struct staging *staging, struct staging_chunk *chunk);

/* Called before each submission: frees kept chunks that have not been taken for long. */
void staging_note_submission(struct staging *staging);

#endif
