/* SPDX-License-Identifier: Apache-2.0 */
/* When the device is done with a submission. Who submits makes tickets and says how to wait. */
#ifndef ASSAY_SNAPSHOTS_TICKET_H
#define ASSAY_SNAPSHOTS_TICKET_H

#include <stdatomic.h>
#include <stdbool.h>
#include <stdint.h>
#include <vulkan/vulkan_core.h>

struct ticket {
    atomic_uint references;
    /* VK_SUCCESS; VK_TIMEOUT after `nanoseconds`; or an error, for good. From any thread. */
    VkResult (*wait)(struct ticket *ticket, uint64_t nanoseconds);
    void (*free)(struct ticket *ticket);
};

/* What the host knows to be complete is waited for a moment, as what tells of it comes last. On a
 * machine whose cores are all busy a driver's threads take tenths of a second to get there; what
 * takes longer has another batch in its submission, which may wait for the host. */
enum { TICKET_GRACE_NANOSECONDS = 500 * 1000 * 1000 };

/* Whether nothing more will be known of it, either: *end is VK_SUCCESS, or an error. */
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
