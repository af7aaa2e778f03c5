/* SPDX-License-Identifier: Apache-2.0 */
/* How inputs of builds are copied: orders and gathering, the dispatches that execute them, and the
 * memory that the copies take.
 *
 * A build resolves device addresses when it executes, and so does the shader that copies
 * (copy.comp). Each submission decides what that shader may read. */
#ifndef ASSAY_LAYER_SNAPSHOTS_COPIES_COPIES_H
#define ASSAY_LAYER_SNAPSHOTS_COPIES_COPIES_H

#include "layer/snapshots/recorder.h"
#include "layer/snapshots/snapshots.h"
#include "src/snapshots/recording.h"

/* ---- orders of copies */

/* Records dispatches for the orders since the last flush. */
void copy_orders_flush(struct recorder *recorder);

/* Records a command that sets the mark of the copies by vkCmdCopyBuffer. */
void copy_orders_mark(const struct recorder *recorder);

/* The orders in the memory that the device reads. */
static inline struct copy_order *copy_orders_at(const struct recording *recording,
                                                const struct copy_orders *orders)
{
    return (struct copy_order *)(recording->chunks[orders->chunk]->bytes + orders->offset);
}

/* The bytes of a copy, or of what was reserved like one, in staging memory. */
static inline unsigned char *snapshot_bytes(const struct recording *recording,
                                            const struct snapshot *snapshot)
{
    return recording->chunks[snapshot->chunk]->bytes + snapshot->offset;
}

/* The device address of a copy, which lies in staging memory. */
uint64_t snapshot_address(const struct recorder *recorder, const struct snapshot *snapshot);

/* ---- Dispatches of the layer's own in the application's command buffers: the compute pipelines,
 * and the state that a dispatch disturbs and that is restored. */

enum own_shader { SHADER_COPY, SHADER_GATHER, SHADER_GUARD, SHADER_COUNT };
enum { SHADER_CONSTANTS_MAX = 64 /* bytes of push constants */ };

/* One for each device; usable from any thread. */
struct own_shaders;

VkResult own_shaders_create(const struct layer_device *device, struct own_shaders **shaders);
void own_shaders_destroy(struct own_shaders *shaders); /* accepts NULL */

/* Whether a dispatch at this point leaves the application's commands unaffected. */
bool dispatches_are_allowed(const struct recorder *recorder);

/* Creates the pipeline of a shader and the recording's gate on first use. Returns false if that
 * fails. */
bool dispatches_prepare(const struct recorder *recorder, enum own_shader shader);

/* Records a dispatch of `groups` workgroups. Call dispatches_prepare() first. */
void dispatches_add(struct recorder *recorder, enum own_shader shader, const void *constants,
                    uint32_t size, uint32_t groups);

/* Called after the last dispatch of a command: restores the application's state. */
void dispatches_end(const struct recorder *recorder);

/* ---- The state of a command buffer that a dispatch of the layer's own disturbs, tracked so that
 * it can be restored: compute bindings and push constants. */

/* The state of a command buffer. Returns NULL if it is not tracked. */
struct compute_state *compute_state_of(const struct layer_device *device, VkCommandBuffer handle);

/* ---- Snapshots of the instances to which an array of pointers points: a compute shader of the
 * layer's own gathers them at that point of the command buffer. */

/* Records the gathering of instances from the 64-bit addresses in `addresses`, a snapshot that the
 * recorder has copied. Fills in the rest of `gathering`. Returns false if there are no addresses,
 * without memory, or if the driver cannot create the pipeline. */
bool recorder_gather(struct recorder *recorder, const struct snapshot *addresses,
                     struct gathering *gathering);

/* Updates the list of readable memory ranges before a recording is submitted, because memory was
 * allocated and freed since it was recorded. Call while the device does not execute the recording.
 * Secondaries are not included. */
void gather_renew_ranges(const struct layer_device *device, const struct recording *recording);

/* The size in bytes of a list of memory ranges, with room for later ones. */
uint64_t gather_ranges_size(struct resources *resources);
/* Writes the ranges of memory that are readable now, and fills up the list with ranges behind all
 * addresses. Returns false if they do not fit. */
bool gather_write_ranges(struct resources *resources, unsigned char *bytes, uint64_t size);

/* ---- Staging: host-visible memory to which the device copies inputs of builds, and from which
 * results are copied. Chunks that are given back are kept for later recordings. */

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
