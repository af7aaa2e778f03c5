/* SPDX-License-Identifier: Apache-2.0 */
/* What a command adds to its command buffer on backend cpu: items of its recording, and copies of
 * what they will read. */
#ifndef ASSAY_LAYER_CPU_RECORDER_H
#define ASSAY_LAYER_CPU_RECORDER_H

#include "cpu/overlay.h"
#include "cpu/recording.h"

/* Which byte of a buffer an address stands for. */
struct cpu_addresses {
    bool (*find)(void *context, uint64_t address, struct cpu_target *target);
    void *context;
};

struct cpu_recorder {
    struct layer_device *device;
    VkCommandBuffer handle;
    struct command_buffer *command_buffer;
    struct cpu_recording *recording;
    const struct cpu_addresses *addresses; /* NULL: they are device addresses */
    bool has_copied;
};

/* False where nothing can be recorded: the command buffer isn't known, or there is no memory. Of
 * the latter vkEndCommandBuffer tells, here and below. */
bool cpu_recorder_begin(struct cpu_recorder *recorder, VkCommandBuffer handle);

/* Takes over what the item points to. */
void cpu_recorder_add(const struct cpu_recorder *recorder, const struct cpu_item *item);
void cpu_recorder_lose(const struct cpu_recorder *recorder);
/* Makes the copies visible to the host. */
void cpu_recorder_end(const struct cpu_recorder *recorder);

/* What recording a command buffer has, or NULL. */
struct cpu_recording *cpu_recording_of(const struct layer_device *device, VkCommandBuffer handle);

/* Records copies of what a build will read, and the build, which it takes over. */
void cpu_recorder_add_build(struct cpu_recorder *recorder, struct cpu_recorded_build *build);

/* Records a copy of `size` bytes at an address, as many of them as the buffer there has.
 * False where it has none, or without memory. */
bool cpu_recorder_copy(struct cpu_recorder *recorder, uint64_t address, uint64_t size,
                       struct cpu_snapshot *snapshot);

/* Makes room for `size` bytes in the recording's chunks, of no address yet. */
bool cpu_recorder_reserve(struct cpu_recorder *recorder, uint64_t size,
                          struct cpu_snapshot *snapshot);

/* The buffer at an address, from there to its end; false where there is none. */
bool cpu_recorder_find(const struct cpu_recorder *recorder, uint64_t address,
                       struct cpu_target *target);

#endif
