/* SPDX-License-Identifier: Apache-2.0 */
/* Says when the device has completed a submission. The code that submits creates tickets and
 * implements `wait`.
 *
 * Other threads find a ticket through the executions that have it (recording.h), which exist before
 * the submission. So a ticket counts as pending from its creation on, until `wait` returns a final
 * result. */
#ifndef ASSAY_SNAPSHOTS_TICKET_H
#define ASSAY_SNAPSHOTS_TICKET_H

#include <stdatomic.h>
#include <stdbool.h>
#include <stdint.h>
#include <vulkan/vulkan_core.h>

struct ticket {
    atomic_uint references;
    uint64_t number; /* unique on the device, from 1; 0: unknown */
    uint64_t call;   /* number of the first ticket of the same submitting call; 0: unknown */
    VkQueue queue;   /* of the submission */
    atomic_bool is_complete; /* `wait` has returned VK_SUCCESS */
    /* Returns VK_SUCCESS, or VK_ERROR_DEVICE_LOST if the device will never complete the submission:
     * both are final, and the device no longer uses what the submission names. VK_TIMEOUT comes
     * after `nanoseconds`, or at once before the submission. Any other error says nothing about the
     * device. May be called from any thread. */
    VkResult (*wait)(struct ticket *ticket, uint64_t nanoseconds);
    void (*free)(struct ticket *ticket);
};

/* How long to wait for a ticket if the host has observed the end of its batch, because the fence
 * signals a moment later. On a busy machine a driver's threads take tenths of a second. If it takes
 * longer, another batch of the same submission may wait for the host. */
enum { TICKET_GRACE_NANOSECONDS = 500 * 1000 * 1000 };

/* Whether the device no longer uses what a submission names, by the result of a wait for it. */
static inline bool ticket_result_is_final(VkResult result)
{
    return result == VK_SUCCESS || result == VK_ERROR_DEVICE_LOST;
}

/* Whether the result is final, which *end then is. `was_seen`: the host has observed the end of the
 * ticket's batch. */
static inline bool ticket_has_ended(struct ticket *ticket, bool was_seen, VkResult *end)
{
    *end = ticket->wait(ticket, was_seen ? TICKET_GRACE_NANOSECONDS : 0);
    return ticket_result_is_final(*end);
}

/* Whether both belong to one submitting call. On backend cpu each batch has its own ticket. */
static inline bool ticket_is_of_call(const struct ticket *ticket, const struct ticket *other)
{
    return ticket == other || (other && other->call && ticket->call == other->call);
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
