/* SPDX-License-Identifier: Apache-2.0 */
/* When the device is done with a submission. Who submits makes tickets and says how to wait. */
#ifndef ASSAY_SNAPSHOTS_TICKET_H
#define ASSAY_SNAPSHOTS_TICKET_H

#include <stdatomic.h>
#include <stdint.h>
#include <vulkan/vulkan_core.h>

struct ticket {
    atomic_uint references;
    /* VK_SUCCESS; VK_TIMEOUT after `nanoseconds`; or an error, for good. From any thread. */
    VkResult (*wait)(struct ticket *ticket, uint64_t nanoseconds);
    void (*free)(struct ticket *ticket);
};

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
