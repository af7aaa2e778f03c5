/* SPDX-License-Identifier: Apache-2.0 */
/* Fences of the layer's own. A fence is kept until the device certainly no longer uses it: until
 * its status is VK_SUCCESS or VK_ERROR_DEVICE_LOST. Any other status leaves that open. */
#include "layer/snapshots/executions.h"

#include <stdlib.h>

#include "src/snapshots/ticket.h"

enum fence_state {
    FENCE_IS_UNUSED, /* it may still be submitted */
    FENCE_IS_SUBMITTED,
    FENCE_IS_REFUSED, /* it will never be submitted */
};

/* The thread that creates a ticket submits it, and sets its state once. Other threads may wait for
 * it at any time, so the state is atomic. */
struct fence_ticket {
    struct ticket ticket; /* first */
    struct snapshots *snapshots;
    VkFence fence;
    _Atomic enum fence_state state;
    struct fence_ticket *next; /* in the list of unfinished or of spare tickets */
};

static VkResult wait_for_fence(struct ticket *ticket, uint64_t nanoseconds)
{
    const struct fence_ticket *own = (const struct fence_ticket *)ticket;
    const struct snapshots *snapshots = own->snapshots;
    enum fence_state state = atomic_load(&own->state);
    /* A driver that fails meanwhile must not make the end unknown again. */
    if (atomic_load(&ticket->is_complete))
        return VK_SUCCESS;
    if (state != FENCE_IS_SUBMITTED)
        return state == FENCE_IS_REFUSED ? VK_ERROR_DEVICE_LOST : VK_TIMEOUT;
    bool is_lost = atomic_load(&snapshots->device_lost);
    VkResult result = snapshots->next.WaitForFences(snapshots->device->handle, 1, &own->fence,
                                                    VK_TRUE, is_lost ? 0 : nanoseconds);
    if (result == VK_SUCCESS)
        atomic_store(&ticket->is_complete, true);
    return is_lost && result == VK_TIMEOUT ? VK_ERROR_DEVICE_LOST : result;
}

static void destroy_ticket(struct fence_ticket *own)
{
    const struct snapshots *snapshots = own->snapshots;
    snapshots->next.DestroyFence(snapshots->device->handle, own->fence, NULL);
    free(own);
}

static bool is_submitted(const struct fence_ticket *own)
{
    return atomic_load(&own->state) == FENCE_IS_SUBMITTED;
}

/* Unless the result is final, the device may use the fence. */
static VkResult status_of(const struct fence_ticket *own)
{
    const struct snapshots *snapshots = own->snapshots;
    return is_submitted(own) ? snapshots->next.GetFenceStatus(snapshots->device->handle, own->fence)
                             : VK_SUCCESS;
}

/* Makes the fence unsignaled again. */
static bool reset(struct fence_ticket *own)
{
    const struct snapshots *snapshots = own->snapshots;
    if (is_submitted(own) &&
        snapshots->next.ResetFences(snapshots->device->handle, 1, &own->fence) != VK_SUCCESS)
        return false;
    atomic_store(&own->state, FENCE_IS_UNUSED);
    return true;
}

static void add_ticket(struct fence_ticket *own, struct fence_ticket **list)
{
    pthread_mutex_lock(&own->snapshots->tickets_lock);
    own->next = *list;
    *list = own;
    pthread_mutex_unlock(&own->snapshots->tickets_lock);
}

/* Calls that destroy something may release a ticket. They do not query the fence: see
 * free_finished(). */
static void free_ticket(struct ticket *ticket)
{
    struct fence_ticket *own = (struct fence_ticket *)ticket;
    add_ticket(own, &own->snapshots->unfinished);
}

/* Spare tickets are used again, because some drivers take hundreds of microseconds to create and
 * destroy a fence. */
static void recycle(struct fence_ticket *own)
{
    VkResult status = status_of(own);
    if (!ticket_result_is_final(status))
        add_ticket(own, &own->snapshots->unfinished);
    else if (status == VK_SUCCESS && reset(own))
        add_ticket(own, &own->snapshots->spare);
    else
        destroy_ticket(own);
}

static struct fence_ticket *take_all(struct snapshots *snapshots, struct fence_ticket **list)
{
    pthread_mutex_lock(&snapshots->tickets_lock);
    struct fence_ticket *first = *list;
    *list = NULL;
    pthread_mutex_unlock(&snapshots->tickets_lock);
    return first;
}

static void free_finished(struct snapshots *snapshots)
{
    struct fence_ticket *own = take_all(snapshots, &snapshots->unfinished), *next;
    for (; own; own = next) {
        next = own->next;
        recycle(own);
    }
}

/* The layer's last fence may signal a moment after the application has observed the end of its own
 * submissions. A fence that the device may still use then stays until the device is destroyed. */
void tickets_destroy(struct snapshots *snapshots)
{
    uint64_t nanoseconds = TICKET_GRACE_NANOSECONDS;
    struct fence_ticket *own, *next;
    for (own = take_all(snapshots, &snapshots->unfinished); own; own = next) {
        next = own->next;
        if (ticket_result_is_final(wait_for_fence(&own->ticket, nanoseconds))) {
            destroy_ticket(own);
        } else {
            nanoseconds = 0;
            free(own);
        }
    }
    for (own = take_all(snapshots, &snapshots->spare); own; own = next) {
        next = own->next;
        destroy_ticket(own);
    }
}

static struct fence_ticket *take_spare(struct snapshots *snapshots)
{
    pthread_mutex_lock(&snapshots->tickets_lock);
    struct fence_ticket *own = snapshots->spare;
    if (own)
        snapshots->spare = own->next;
    pthread_mutex_unlock(&snapshots->tickets_lock);
    return own;
}

static struct fence_ticket *create_ticket(struct snapshots *snapshots)
{
    const VkFenceCreateInfo create_info = {.sType = VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
    struct fence_ticket *own = calloc(1, sizeof(*own));
    if (!own)
        return NULL;
    own->ticket.wait = wait_for_fence;
    own->ticket.free = free_ticket;
    own->snapshots = snapshots;
    if (snapshots->next.CreateFence(snapshots->device->handle, &create_info, NULL, &own->fence) ==
        VK_SUCCESS)
        return own;
    free(own);
    return NULL;
}

struct ticket *ticket_create(struct snapshots *snapshots, VkQueue queue)
{
    free_finished(snapshots);
    struct fence_ticket *own = take_spare(snapshots);
    if (!own)
        own = create_ticket(snapshots);
    if (!own)
        return NULL;
    atomic_init(&own->ticket.references, 1);
    atomic_init(&own->ticket.is_complete, false);
    own->ticket.queue = queue;
    own->ticket.number = atomic_fetch_add(&snapshots->ticket_count, 1) + 1;
    own->ticket.call = own->ticket.number;
    return &own->ticket;
}

VkResult ticket_submit(struct ticket *ticket)
{
    struct fence_ticket *own = (struct fence_ticket *)ticket;
    VkResult result = own->snapshots->next.QueueSubmit(ticket->queue, 0, NULL, own->fence);
    if (result == VK_SUCCESS)
        atomic_store(&own->state, FENCE_IS_SUBMITTED);
    return result;
}

void ticket_refuse(struct ticket *ticket)
{
    struct fence_ticket *own = (struct fence_ticket *)ticket;
    atomic_store(&own->state, FENCE_IS_REFUSED);
}
