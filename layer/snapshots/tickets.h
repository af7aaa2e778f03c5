/* SPDX-License-Identifier: Apache-2.0 */
/* Tickets of submissions: fences of the layer's own. */
#ifndef ASSAY_LAYER_SNAPSHOTS_TICKETS_H
#define ASSAY_LAYER_SNAPSHOTS_TICKETS_H

#include "layer/snapshots/snapshots.h"

/* Not yet submitted; NULL without memory of either kind. */
struct ticket *ticket_create(struct snapshots *snapshots, VkQueue queue);
/* Signalled once all that was submitted to its queue before is complete. With the queue's lock
 * held. */
VkResult ticket_submit(struct ticket *ticket);

/* The queue of the submission that a ticket is for. */
VkQueue ticket_queue(const struct ticket *ticket);

/* Frees what is left of tickets of which the device is done; `all` before it is destroyed. */
void tickets_release(struct snapshots *snapshots, bool all);

#endif
