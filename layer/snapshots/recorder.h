/* SPDX-License-Identifier: Apache-2.0 */
/* What the layer adds to a command buffer when a build is recorded: copies of the build's inputs,
 * in the command buffer and at the build's entry of the journal. */
#ifndef ASSAY_LAYER_SNAPSHOTS_RECORDER_H
#define ASSAY_LAYER_SNAPSHOTS_RECORDER_H

#include "layer/snapshots/snapshots.h"
#include "src/snapshots/recording.h"

struct guard_call;

/* Maps an address to a byte of a buffer. */
struct recorder_addresses {
    bool (*find)(void *context, uint64_t address, struct buffer_target *target);
    void *context;
};

struct recorder {
    struct layer_device *device;
    VkCommandBuffer handle;
    struct command_buffer *command_buffer;
    struct recording *recording;
    const struct recorder_addresses *addresses; /* NULL: addresses are device addresses */
    bool is_other;                              /* the command builds no structures */
    bool cannot_inject;                         /* no commands may be added at this point */
    bool has_copied;                            /* the barrier before the first copy is recorded */
    bool has_dispatched;                        /* a dispatch of the layer's own is recorded */
    VkPipelineStageFlags copy_stages;           /* of the copies; set by recorder_end() */
    struct journal_walk builds;                 /* over the entries of this command's builds */
    struct journal_entry *next_build;           /* that it has reached; NULL: none */
    uint32_t build_count;                       /* builds of this command that are recorded */
    uint32_t first_chunk;                       /* the first chunk that the command may write to */
    uint32_t first_order; /* in the last block of copy orders: the first one not dispatched yet */
    struct copy_orders mark;   /* order that marks the copies by vkCmdCopyBuffer; count 0: there are
                                  no such copies */
    enum left_out left_out;    /* of the current build */
    struct guard_call *guards; /* of the call; NULL: nothing is guarded */
};

/* Begins to record a command. Returns false if nothing can be recorded: the command buffer is
 * unknown, or memory ran out. vkEndCommandBuffer reports lack of memory, here and below. */
bool recorder_begin(struct recorder *recorder, VkCommandBuffer handle);

/* Begins to record a build command, and sets cannot_inject. */
bool recorder_begin_builds(struct recorder *recorder, VkCommandBuffer handle);

/* Begins to record a command that builds micromaps, or reads serialized data, and sets
 * cannot_inject. */
bool recorder_begin_other(struct recorder *recorder, VkCommandBuffer handle);

/* Adds an entry for backend cpu. */
void recorder_add(struct recorder *recorder, const struct recorded_command *command);
/* Adds a copy of a structure, unless the call has an entry for it. */
void recorder_add_copy(struct recorder *recorder, const struct recorded_command *copy);
/* Lets a build's entry have copies; makes an entry if it has none. Takes ownership of the build. */
void recorder_keep_build(struct recorder *recorder, struct recorded_build *build);
void recorder_fail(struct recorder *recorder);
/* Called before the first copy of a command: records a barrier. Does nothing after that. */
void recorder_start_copies(struct recorder *recorder);
/* Called after the last copy of a command: records pending copies, and makes all copies visible to
 * the host. On backend cpu it also makes later commands wait for them. */
void recorder_end(struct recorder *recorder);
/* Called behind the build command itself: lets later builds wait for the copies. */
void recorder_end_call(const struct recorder *recorder);

/* A dependency between the layer's own accesses of one buffer of its own. */
struct own_dependency {
    VkPipelineStageFlags src, dst;
    VkAccessFlags src_access, dst_access;
};
void recorder_order_buffer(const struct recorder *recorder, VkBuffer buffer,
                           const struct own_dependency *dependency);
/* The stages of the command's builds. */
VkPipelineStageFlags recorder_build_stages(const struct recorder *recorder);

/* The recording of a command buffer. Returns NULL if there is none. */
struct recording *recording_of(const struct layer_device *device, VkCommandBuffer handle);

/* Records copies of a build's inputs, and the build. Takes ownership of the build. */
void recorder_add_build(struct recorder *recorder, struct recorded_build *build);
/* Notes that a build is not recorded, for lack of memory. */
void recorder_leave_out_build(struct recorder *recorder, uint32_t position);

/* Orders a copy of `size` bytes at an address, cut at the end of the buffer that has the address
 * now. Returns false if there is no such buffer, or without memory. */
bool recorder_copy(struct recorder *recorder, uint64_t address, uint64_t size,
                   struct snapshot *snapshot);

/* Makes a snapshot of no bytes. At the submission it receives the number of bytes from the address
 * to the end of the buffer. Returns false if that cannot be known. */
bool recorder_measure(struct recorder *recorder, uint64_t address, struct snapshot *snapshot);

/* Reserves `size` bytes in the recording's chunks; the snapshot has no address yet. */
bool recorder_reserve(struct recorder *recorder, uint64_t size, struct snapshot *snapshot);

/* The buffer at an address, from there to its end. Returns false if there is none. */
bool recorder_find(const struct recorder *recorder, uint64_t address, struct buffer_target *target);

#endif
