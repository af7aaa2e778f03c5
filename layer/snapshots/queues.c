/* SPDX-License-Identifier: Apache-2.0 */
/* The device's queues: their families, and who uses them. Vulkan demands that one thread at a time
 * uses a queue. The application sees to that for its own calls, and these functions for the layer's
 * own submissions (backend cpu, compare_rays), which come when the application waits. */
#include "layer/snapshots/snapshots.h"

#include <stdlib.h>

#include "observers.h"

/* The lock of the queues guards it. */
struct known_queue {
    uint32_t family, users; /* calls of the application that use the queue */
};

static struct known_queue *find_queue(const struct snapshots *snapshots, VkQueue queue)
{
    return handle_table_find(&snapshots->queues, handle_number(queue));
}

/* Without memory the queue stays unknown, and the layer submits nothing to it. */
void snapshots_note_queue(struct layer_device *device, VkQueue handle, uint32_t family)
{
    struct snapshots *snapshots = device->snapshots;
    struct known_queue *queue = handle ? calloc(1, sizeof(*queue)) : NULL;
    if (!queue)
        return;
    queue->family = family;
    pthread_mutex_lock(&snapshots->queue_lock);
    bool is_added = !find_queue(snapshots, handle) &&
                    handle_table_set(&snapshots->queues, handle_number(handle), queue);
    pthread_mutex_unlock(&snapshots->queue_lock);
    if (!is_added)
        free(queue);
}

bool snapshots_queue_family(struct snapshots *snapshots, VkQueue handle, uint32_t *family)
{
    pthread_mutex_lock(&snapshots->queue_lock);
    const struct known_queue *queue = find_queue(snapshots, handle);
    if (queue)
        *family = queue->family;
    pthread_mutex_unlock(&snapshots->queue_lock);
    return queue;
}

void snapshots_release_queues(struct snapshots *snapshots)
{
    handle_table_drop(&snapshots->queues, free);
}

/* ---- calls of the application */

static void count_user(struct snapshots *snapshots, VkQueue handle, bool begins)
{
    if (!snapshots->submits_itself)
        return;
    pthread_mutex_lock(&snapshots->queue_lock);
    struct known_queue *queue = find_queue(snapshots, handle);
    if (queue)
        queue->users += begins ? 1 : -1u;
    pthread_mutex_unlock(&snapshots->queue_lock);
}

void snapshots_enter_queue(struct layer_device *device, VkQueue queue)
{
    count_user(device->snapshots, queue, true);
}

void snapshots_leave_queue(struct layer_device *device, VkQueue queue)
{
    count_user(device->snapshots, queue, false);
}

static void count_user_of_all(struct snapshots *snapshots, bool begins)
{
    if (!snapshots->submits_itself)
        return;
    pthread_mutex_lock(&snapshots->queue_lock);
    snapshots->users_of_all_queues += begins ? 1 : -1u;
    pthread_mutex_unlock(&snapshots->queue_lock);
}

void snapshots_enter_all_queues(struct layer_device *device)
{
    count_user_of_all(device->snapshots, true);
}

void snapshots_leave_all_queues(struct layer_device *device)
{
    count_user_of_all(device->snapshots, false);
}

/* ---- the layer's own submissions */

bool snapshots_begin_own_submission(struct snapshots *snapshots, VkQueue handle)
{
    if (execution_order_holds_queue(snapshots->device->order, handle))
        return false;
    pthread_mutex_lock(&snapshots->queue_lock);
    const struct known_queue *queue = find_queue(snapshots, handle);
    if (queue && !queue->users && !snapshots->users_of_all_queues)
        return true;
    pthread_mutex_unlock(&snapshots->queue_lock);
    return false;
}

void snapshots_end_own_submission(struct snapshots *snapshots)
{
    pthread_mutex_unlock(&snapshots->queue_lock);
}
