/* SPDX-License-Identifier: Apache-2.0 */
/* Tells when the device has completed a submission. The code that submits creates tickets and
 * implements `wait`. */
#ifndef ASSAY_SNAPSHOTS_TICKET_H
#define ASSAY_SNAPSHOTS_TICKET_H

#include <stdatomic.h>
#include <stdbool.h>
#include <stdint.h>
#include <vulkan/vulkan_core.h>

struct ticket {
    atomic_uint references;
    uint64_t number; /* unique on the device, from 1; 0: unknown */
    /* Returns VK_SUCCESS, VK_TIMEOUT after `nanoseconds`, or an error that is final. May be called
     * from any thread. */
    VkResult (*wait)(struct ticket *ticket, uint64_t nanoseconds);
    void (*free)(struct ticket *ticket);
};

/* How long to wait for a ticket if the host has observed the end of its batch, because the fence
 * signals a moment later. On a busy machine a driver's threads take tenths of a second. If it takes
 * longer, another batch of the same submission may wait for the host. */
enum { TICKET_GRACE_NANOSECONDS = 500 * 1000 * 1000 };

/* Whether the result is final. *end is then VK_SUCCESS or an error. `was_seen`: the host has
 * observed the end of the ticket's batch. */
static inline bool ticket_has_ended(struct ticket *ticket, bool was_seen, VkResult *end)
{
    *end = ticket->wait(ticket, was_seen ? TICKET_GRACE_NANOSECONDS : 0);
    return *end != VK_TIMEOUT;
}

static inline struct ticket *ticket_share(struct ticket *ticket)
{
    atomic_fetch_add_explicit(&ticket->references, 1, memory_order_relaxed);
    return ticket;
}

static inline void ticket_release(struct ticket *ticket)
{
    if (ticket && atomic_fetch_sub_explicit(&ticket->references, 1, memory_order_acq_rel) == 1)
        ticket->free(ticket);
}

#endif
