/* SPDX-License-Identifier: Apache-2.0 */
/* Plays the journals of executed command buffers, and updates the structures that they change.
 *
 * The layer calls cpu_playback_run in execution order (src/state/order/order.h). It gives
 * structures their new trees, which are made later, on first use. Results that commands write to
 * buffers are kept until their submission is complete. Thread-safe. */
#ifndef ASSAY_CPU_PLAYBACK_H
#define ASSAY_CPU_PLAYBACK_H

#include "src/cpu/device.h"
#include "src/cpu/query_pools.h"
#include "src/snapshots/recording.h"
#include "src/state/order/clock.h"

struct cpu_playback;

/* `resources`: of the device, to find buffers by address. */
VkResult cpu_playback_create(struct cpu_device *device, struct resources *resources,
                             struct cpu_playback **playback);
void cpu_playback_destroy(struct cpu_playback *playback); /* accepts NULL */

/* Returns for how many structures and results memory has run out since the last call. */
uint32_t cpu_playback_take_failed(struct cpu_playback *playback);

/* Plays an execution. `timestamp` is that of its batch. */
void cpu_playback_run(struct cpu_playback *playback, struct execution *execution,
                      struct timestamp timestamp);

/* Writes, in execution order, the results whose batch is complete. If the host has observed that
 * (`seen`) but the batch's ticket has not ended yet, the call waits for the ticket a short time.
 * `write` copies regions of `bytes` to a buffer. If it returns false, the result stays for the next
 * call. */
struct result_bytes {
    struct ticket *ticket;
    VkBuffer buffer;
    const unsigned char *bytes;
    uint64_t size;
    const VkBufferCopy *regions;
    uint32_t region_count;
};
struct cpu_delivery {
    const struct execution_clock *seen;
    bool (*write)(void *user, const struct result_bytes *result);
    void *user;
};
void cpu_playback_deliver(struct cpu_playback *playback, const struct cpu_delivery *delivery);
/* Whether there are results to write. */
bool cpu_playback_has_results(struct cpu_playback *playback);
/* Call when the buffer is being destroyed: drops the results for it. */
void cpu_playback_forget_buffer(struct cpu_playback *playback, VkBuffer buffer);

#endif
