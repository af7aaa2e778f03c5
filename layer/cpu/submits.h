/* SPDX-License-Identifier: Apache-2.0 */
/* What the layer tells backend cpu of submissions that it observes: when their turn comes, and when
 * the application may learn that they are complete. */
#ifndef ASSAY_LAYER_CPU_SUBMITS_H
#define ASSAY_LAYER_CPU_SUBMITS_H

#include "cpu/overlay.h"
#include "state/execution_order.h"

/* A batch's turn in execution order. */
void cpu_overlay_run(const struct layer_device *device, const struct batch_run *run);
/* From now on submissions take their turns as they are made. */
void cpu_overlay_lose_order(const struct layer_device *device);

/* The host has seen something complete, or is about to submit: writes the results of complete
 * submissions to their buffers. */
void cpu_overlay_deliver(struct layer_device *device);
static inline void cpu_deliver(struct layer_device *device)
{
    if (device->cpu)
        cpu_overlay_deliver(device);
}

/* Frees what is left of tickets of which the device is done; `all` before it is destroyed. */
void cpu_tickets_release(struct cpu_overlay *overlay, bool all);

/* The queue of the submission that a ticket is for. */
VkQueue cpu_ticket_queue(const struct ticket *ticket);
/* False where the queue isn't known. */
bool cpu_queue_family(struct cpu_overlay *overlay, VkQueue queue, uint32_t *family);

#endif
