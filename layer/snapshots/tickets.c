/* SPDX-License-Identifier: Apache-2.0 */
/* Fences of the layer's own. A fence is kept until the device no longer uses it. */
#include "layer/snapshots/tickets.h"

#include <stdlib.h>

#include "src/snapshots/ticket.h"

struct fence_ticket {
    struct ticket ticket; /* first */
    struct snapshots *snapshots;
    VkFence fence;
    VkQueue queue;
    bool is_submitted;         /* the fence was submitted */
    struct fence_ticket *next; /* in the list of unfinished tickets */
};

static VkResult wait_for_fence(struct ticket *ticket, uint64_t nanoseconds)
{
    const struct fence_ticket *own = (const struct fence_ticket *)ticket;
    const struct snapshots *snapshots = own->snapshots;
    if (!own->is_submitted)
        return VK_ERROR_DEVICE_LOST; /* the fence will never signal */
    bool is_lost = atomic_load(&snapshots->device_lost);
    VkResult result = snapshots->next.WaitForFences(snapshots->device->handle, 1, &own->fence,
                                                    VK_TRUE, is_lost ? 0 : nanoseconds);
    return is_lost && result == VK_TIMEOUT ? VK_ERROR_DEVICE_LOST : result;
}

static void destroy_ticket(struct fence_ticket *own)
{
    const struct snapshots *snapshots = own->snapshots;
    snapshots->next.DestroyFence(snapshots->device->handle, own->fence, NULL);
    free(own);
}

/* Whether the device no longer uses the fence, so that it may be destroyed. */
static bool is_finished(const struct fence_ticket *own)
{
    const struct snapshots *snapshots = own->snapshots;
    return !own->is_submitted ||
           snapshots->next.GetFenceStatus(snapshots->device->handle, own->fence) != VK_NOT_READY;
}

static void keep_unfinished(struct fence_ticket *own)
{
    struct snapshots *snapshots = own->snapshots;
    pthread_mutex_lock(&snapshots->tickets_lock);
    own->next = snapshots->unfinished;
    snapshots->unfinished = own;
    pthread_mutex_unlock(&snapshots->tickets_lock);
}

static void free_ticket(struct ticket *ticket)
{
    struct fence_ticket *own = (struct fence_ticket *)ticket;
    if (is_finished(own))
        destroy_ticket(own);
    else
        keep_unfinished(own);
}

void tickets_release(struct snapshots *snapshots, bool all)
{
    pthread_mutex_lock(&snapshots->tickets_lock);
    struct fence_ticket *own = snapshots->unfinished, *next;
    snapshots->unfinished = NULL;
    pthread_mutex_unlock(&snapshots->tickets_lock);
    for (; own; own = next) {
        next = own->next;
        if (all || is_finished(own))
            destroy_ticket(own);
        else
            keep_unfinished(own);
    }
}

VkQueue ticket_queue(const struct ticket *ticket)
{
    return ((const struct fence_ticket *)ticket)->queue;
}

struct ticket *ticket_create(struct snapshots *snapshots, VkQueue queue)
{
    const VkFenceCreateInfo create_info = {.sType = VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
    tickets_release(snapshots, false);
    struct fence_ticket *own = calloc(1, sizeof(*own));
    if (!own)
        return NULL;
    atomic_init(&own->ticket.references, 1);
    own->ticket.wait = wait_for_fence;
    own->ticket.free = free_ticket;
    own->snapshots = snapshots;
    own->queue = queue;
    own->ticket.number = atomic_fetch_add(&snapshots->ticket_count, 1) + 1;
    if (snapshots->next.CreateFence(snapshots->device->handle, &create_info, NULL, &own->fence) ==
        VK_SUCCESS)
        return &own->ticket;
    free(own);
    return NULL;
}

VkResult ticket_submit(struct ticket *ticket)
{
    struct fence_ticket *own = (struct fence_ticket *)ticket;
    VkResult result = own->snapshots->next.QueueSubmit(own->queue, 0, NULL, own->fence);
    own->is_submitted = result == VK_SUCCESS;
    return result;
}
