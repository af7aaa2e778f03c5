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
    struct fence_ticket *next; /* in the list of unfinished or of spare tickets */
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

/* VK_NOT_READY while the device uses the fence. */
static VkResult status_of(const struct fence_ticket *own)
{
    const struct snapshots *snapshots = own->snapshots;
    return own->is_submitted ? snapshots->next.GetFenceStatus(snapshots->device->handle, own->fence)
                             : VK_SUCCESS;
}

/* Makes the fence unsignaled again. */
static bool reset(struct fence_ticket *own)
{
    const struct snapshots *snapshots = own->snapshots;
    if (own->is_submitted &&
        snapshots->next.ResetFences(snapshots->device->handle, 1, &own->fence) != VK_SUCCESS)
        return false;
    own->is_submitted = false;
    return true;
}

static void add(struct fence_ticket *own, struct fence_ticket **list)
{
    pthread_mutex_lock(&own->snapshots->tickets_lock);
    own->next = *list;
    *list = own;
    pthread_mutex_unlock(&own->snapshots->tickets_lock);
}

/* Spare tickets are used again, because some drivers take hundreds of microseconds to create and
 * destroy a fence. */
static void free_ticket(struct ticket *ticket)
{
    struct fence_ticket *own = (struct fence_ticket *)ticket;
    VkResult status = status_of(own);
    if (status == VK_NOT_READY)
        add(own, &own->snapshots->unfinished);
    else if (status == VK_SUCCESS && reset(own))
        add(own, &own->snapshots->spare);
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
        free_ticket(&own->ticket);
    }
}

static void destroy_all(struct fence_ticket *own)
{
    for (struct fence_ticket *next; own; own = next) {
        next = own->next;
        destroy_ticket(own);
    }
}

void tickets_destroy(struct snapshots *snapshots)
{
    destroy_all(take_all(snapshots, &snapshots->unfinished));
    destroy_all(take_all(snapshots, &snapshots->spare));
}

VkQueue ticket_queue(const struct ticket *ticket)
{
    return ((const struct fence_ticket *)ticket)->queue;
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

static struct fence_ticket *create(struct snapshots *snapshots)
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
        own = create(snapshots);
    if (!own)
        return NULL;
    atomic_init(&own->ticket.references, 1);
    own->queue = queue;
    own->ticket.number = atomic_fetch_add(&snapshots->ticket_count, 1) + 1;
    return &own->ticket;
}

VkResult ticket_submit(struct ticket *ticket)
{
    struct fence_ticket *own = (struct fence_ticket *)ticket;
    VkResult result = own->snapshots->next.QueueSubmit(own->queue, 0, NULL, own->fence);
    own->is_submitted = result == VK_SUCCESS;
    return result;
}
