/* SPDX-License-Identifier: Apache-2.0 */
/* What the layer adds to a command buffer when a build is recorded: items of its recording, and
 * copies of what they will read. */
#ifndef ASSAY_LAYER_SNAPSHOTS_RECORDER_H
#define ASSAY_LAYER_SNAPSHOTS_RECORDER_H

#include "layer/snapshots/snapshots.h"
#include "src/snapshots/recording.h"

/* Which byte of a buffer an address stands for. */
struct recorder_addresses {
    bool (*find)(void *context, uint64_t address, struct buffer_target *target);
    void *context;
};

struct recorder {
    struct layer_device *device;
    VkCommandBuffer handle;
    struct command_buffer *command_buffer;
    struct recording *recording;
    const struct recorder_addresses *addresses; /* NULL: they are device addresses */
    bool cannot_inject;                         /* no commands may be added there */
    bool has_copied;                            /* and has begun with a barrier */
    bool has_dispatched;                        /* a shader of the layer's own */
    uint32_t first_order;    /* of the last block of copy orders, that is not dispatched yet */
    struct copy_orders mark; /* of copies by vkCmdCopyBuffer; count 0: there are none */
    enum left_out left_out;  /* of the build under way */
};

/* False where nothing can be recorded: the command buffer isn't known, or there is no memory. Of
 * the latter vkEndCommandBuffer tells, here and below. */
bool recorder_begin(struct recorder *recorder, VkCommandBuffer handle);

/* The same for a command that builds, where it may be that nothing can be added. */
bool recorder_begin_builds(struct recorder *recorder, VkCommandBuffer handle);

/* Takes over what the item points to. */
void recorder_add(struct recorder *recorder, const struct recorded_item *item);
void recorder_fail(struct recorder *recorder);
/* Before the first copy of a command: a barrier. Does nothing after that. */
void recorder_start_copies(struct recorder *recorder);
/* After the last copy of a command: records copies that are pending, makes all copies visible to
 * the host, and holds back what comes after the command until they are done. */
void recorder_end(struct recorder *recorder);

/* What recording a command buffer has, or NULL. */
struct recording *recording_of(const struct layer_device *device, VkCommandBuffer handle);

/* Records copies of what a build will read, and the build, which it takes over. */
void recorder_add_build(struct recorder *recorder, struct recorded_build *build);
/* Notes that a build isn't recorded, for lack of memory. */
void recorder_miss_build(struct recorder *recorder, uint32_t position);

/* Orders a copy of `size` bytes at an address, at most as many as the buffer has that is there now.
 * False if there is none, or without memory. */
bool recorder_copy(struct recorder *recorder, uint64_t address, uint64_t size,
                   struct snapshot *snapshot);

/* A snapshot of no bytes, which says how many the buffer at an address has from there on when the
 * command buffer is submitted. False if that can't be known. */
bool recorder_measure(struct recorder *recorder, uint64_t address, struct snapshot *snapshot);

/* Makes room for `size` bytes in the recording's chunks, of no address yet. */
bool recorder_reserve(struct recorder *recorder, uint64_t size, struct snapshot *snapshot);

/* The buffer at an address, from there to its end; false where there is none. */
bool recorder_find(const struct recorder *recorder, uint64_t address, struct buffer_target *target);

#endif
