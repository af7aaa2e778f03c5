/* SPDX-License-Identifier: Apache-2.0 */
/* Tickets of submissions: fences of the layer's own. */
#ifndef ASSAY_LAYER_SNAPSHOTS_TICKETS_H
#define ASSAY_LAYER_SNAPSHOTS_TICKETS_H

#include "layer/snapshots/snapshots.h"

/* Returns a ticket that is not submitted yet. Returns NULL without host or device memory. */
struct ticket *ticket_create(struct snapshots *snapshots, VkQueue queue);
/* Submits the ticket's fence, which signals when all earlier submissions to its queue are complete.
 * Call with the queues locked. If it fails, the ticket stays pending. */
VkResult ticket_submit(struct ticket *ticket);
/* Called instead of ticket_submit(), or after it has failed: from now on waits for the ticket
 * return VK_ERROR_DEVICE_LOST. */
void ticket_refuse(struct ticket *ticket);

/* Destroys all tickets, before the device is destroyed. All executions have been released. */
void tickets_destroy(struct snapshots *snapshots);

#endif
