/* SPDX-License-Identifier: Apache-2.0 */
/* What submissions need: tickets, and warnings about executions that cannot be validated. */
#ifndef ASSAY_LAYER_SNAPSHOTS_EXECUTIONS_H
#define ASSAY_LAYER_SNAPSHOTS_EXECUTIONS_H

#include "layer/snapshots/snapshots.h"

/* ---- tickets: fences of the layer's own */

/* Returns a ticket that is not submitted yet. Returns NULL without host or device memory. */
struct ticket *ticket_create(struct snapshots *snapshots, VkQueue queue);
/* Submits the ticket's fence, which signals when all earlier submissions to its queue are complete.
 * Call while the queue counts as in use. If it fails, the ticket stays pending. */
VkResult ticket_submit(struct ticket *ticket);
/* Called instead of ticket_submit(), or after it has failed: from now on waits for the ticket
 * return VK_ERROR_DEVICE_LOST. */
void ticket_refuse(struct ticket *ticket);

/* Destroys all tickets, before the device is destroyed. All executions have been released. */
void tickets_destroy(struct snapshots *snapshots);

/* ---- warnings about builds that level content does not validate */

/* Warns about builds of a command buffer that were left out when they were recorded. Warns once for
 * each recording. Also called for secondaries, when they are executed. */
void warn_left_out(const struct layer_device *device, VkCommandBuffer handle);

/* Numbers of executions whose builds were not validated, by reason. */
struct missed_executions {
    uint32_t no_memory;   /* out of memory */
    uint32_t overwritten; /* another execution of the same submission copied to the same memory */
    uint32_t unread;      /* resubmitted before the copies could be read */
    uint32_t repeated;    /* executed again after ONE_TIME_SUBMIT */
    uint32_t device_lost; /* the device was lost */
    uint32_t held;        /* waited for a signal that was never submitted */
};
void warn_missed(const struct layer_device *device, const struct missed_executions *missed);

/* Warns once about executions whose order is unknown: gives the reason, and says that later
 * executions are affected too. */
void warn_unordered(const struct layer_device *device);

/* Warns once that the driver completes submissions without executing the copies in them. */
void warn_lack_of_copies(const struct layer_device *device);

#endif
