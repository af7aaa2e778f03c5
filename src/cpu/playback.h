/* SPDX-License-Identifier: Apache-2.0 */
/* Executed command buffers, and what structures hold after them.
 *
 * Executions take their turns in execution order (the layer asks src/state/order/order.h); then
 * their items set the trees of structures, without making any.
 * Results that commands write to buffers wait here for the end of their submission. */
#ifndef ASSAY_CPU_PLAYBACK_H
#define ASSAY_CPU_PLAYBACK_H

#include "src/cpu/device.h"
#include "src/cpu/query_pools.h"
#include "src/snapshots/recording.h"
#include "src/state/order/clock.h"

struct cpu_playback;

/* `resources`: the device's, to find what has an address. */
VkResult cpu_playback_create(struct cpu_device *device, struct resources *resources,
                             struct cpu_playback **playback);
void cpu_playback_destroy(struct cpu_playback *playback); /* NULL: nothing */

/* How many structures and results were lost for lack of memory since the last call. */
uint32_t cpu_playback_take_failed(struct cpu_playback *playback);

/* The turn of an execution, in a batch that executes at `moment`. */
void cpu_playback_run(struct cpu_playback *playback, struct execution *execution,
                      struct timestamp timestamp);

/* Writes the results of submissions that are complete, in execution order, until one is not: each
 * by copying regions of `bytes` to a buffer. What the host has seen complete is waited for, should
 * its ticket come a moment later, but not for long. */
struct cpu_delivery {
    const struct execution_clock *seen;
    void (*write)(void *user, struct ticket *ticket, VkBuffer buffer, const void *bytes,
                  uint64_t size, const VkBufferCopy *regions, uint32_t region_count);
    void *user;
};
void cpu_playback_deliver(struct cpu_playback *playback, const struct cpu_delivery *delivery);
/* Whether there is any to write. */
bool cpu_playback_has_results(struct cpu_playback *playback);
/* The buffer is being destroyed: what was to be written to it is not. */
void cpu_playback_forget_buffer(struct cpu_playback *playback, VkBuffer buffer);

#endif
