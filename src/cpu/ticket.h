/* SPDX-License-Identifier: Apache-2.0 */
/* When the device is done with a submission. Who submits makes tickets and says how to wait. */
#ifndef ASSAY_CPU_TICKET_H
#define ASSAY_CPU_TICKET_H

#include <stdatomic.h>
#include <stdint.h>
#include <vulkan/vulkan_core.h>

struct cpu_ticket {
    atomic_uint references;
    /* VK_SUCCESS; VK_TIMEOUT after `nanoseconds`; or an error, for good. From any thread. */
    VkResult (*wait)(struct cpu_ticket *ticket, uint64_t nanoseconds);
    void (*free)(struct cpu_ticket *ticket);
};

static inline struct cpu_ticket *cpu_ticket_share(struct cpu_ticket *ticket)
{
    atomic_fetch_add_explicit(&ticket->references, 1, memory_order_relaxed);
    return ticket;
}

static inline void cpu_ticket_release(struct cpu_ticket *ticket)
{
    if (ticket && atomic_fetch_sub_explicit(&ticket->references, 1, memory_order_acq_rel) == 1)
        ticket->free(ticket);
}

#endif
