/* SPDX-License-Identifier: Apache-2.0 */
/* Tickets of submissions: fences of the layer's own. */
#ifndef ASSAY_LAYER_SNAPSHOTS_TICKETS_H
#define ASSAY_LAYER_SNAPSHOTS_TICKETS_H

#include "layer/snapshots/snapshots.h"

/* Returns a ticket that is not submitted yet. Returns NULL without host or device memory. */
struct ticket *ticket_create(struct snapshots *snapshots, VkQueue queue);
/* Submits the ticket's fence, which signals when all earlier submissions to its queue are complete.
 * Call with the queues locked. */
VkResult ticket_submit(struct ticket *ticket);

/* The queue of the submission that a ticket is for. */
VkQueue ticket_queue(const struct ticket *ticket);

/* Destroys all tickets, before the device is destroyed. */
void tickets_destroy(struct snapshots *snapshots);

#endif
