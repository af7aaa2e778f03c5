/* SPDX-License-Identifier: Apache-2.0 */
/* Snapshots of the input data of builds in command buffers: an overlay on a device's dispatch
 * table, above whatever executes the builds. It records the copies, and hands the executions of
 * each submission to its batches, where consumers find them (src/state/order/batch.h). */
#ifndef ASSAY_LAYER_SNAPSHOTS_SNAPSHOTS_H
#define ASSAY_LAYER_SNAPSHOTS_SNAPSHOTS_H

#include "layer/assay.h"
#include "layer/layer.h"
#include "layer/own_objects.h"
#include "src/base/handle_table.h"
#include "src/base/unknown.h"
#include "src/platform/threads.h"
#include "src/snapshots/recording.h"
#include "src/state/order/order.h"

struct fence_ticket;
struct guard;
struct own_shaders;
struct staging;
struct word_pool;

/* layer_device.snapshots. NULL if nothing uses snapshots: on backend driver below level content,
 * and for a device that enables no builds. */
struct snapshots {
    struct layer_device *device;
    /* A backend executes builds from the snapshots: each build is copied, whatever the budget, and
     * the application's fences signal only when the copies can be read. */
    bool are_for_backend;
    bool are_for_rules;          /* alone: what no rule reads is not copied */
    VkuDeviceDispatchTable next; /* the next layer's, for the layer's own objects and commands */
    VkuDeviceDispatchTable down; /* the backend's or the next layer's */
    PFN_vkSetDeviceLoaderData set_loader_data; /* may be NULL */
    struct staging *staging;
    struct guard *guard;     /* NULL unless guard = references */
    struct word_pool *words; /* gates and marks of recordings */
    struct own_shaders *shaders;
    bool has_addresses;           /* bufferDeviceAddress is enabled */
    pthread_mutex_t buffers_lock; /* guards the next member */
    struct handle_table copyable; /* buffers that can be copied from; on backend cpu all can be */
    pthread_mutex_t pools_lock;   /* guards the next member */
    struct handle_table uncounting_pools; /* query pools that count no compute work */
    _Atomic uint64_t bytes_copied;        /* bytes that recorded copies read */
    /* The order is unknown: executions go to `run_unordered` of the consumers as they are
     * submitted. */
    struct unknown order_unknown;
    enum order_unknown_reason unknown_reason; /* never changes after order_unknown is set */
    atomic_uint unordered;                    /* number of executions without a known order */
    atomic_bool unordered_reported;           /* one warning reports them */
    atomic_bool lack_of_copies_reported;
    bool submits_itself;          /* the layer submits at times of its own: queues.c */
    pthread_mutex_t queue_lock;   /* guards the next two members; held while the layer submits */
    struct handle_table queues;   /* queues.c */
    uint32_t users_of_all_queues; /* calls of the application */
    _Atomic uint64_t ticket_count;
    atomic_bool device_lost; /* no fence will signal any more */
    /* Held while copy orders are renewed for an execution, until that exists. */
    pthread_mutex_t executions_lock;
    pthread_mutex_t tickets_lock;    /* guards the next two members */
    struct fence_ticket *unfinished; /* released; the device may still use their fences */
    struct fence_ticket *spare;      /* released, with fences to be used again */
    uint32_t held; /* executions that never ran; set when the device is destroyed */
};

/* Creates device->snapshots and covers device->vk, which must be filled in, with the backend's
 * commands if there is a backend. `below_backend`: the next layer's commands if a backend executes
 * builds from the snapshots, else NULL. If this fails, snapshots_destroy() frees what was created.
 */
VkResult snapshots_create(struct layer_device *device, const VkDeviceCreateInfo *create_info,
                          const VkuDeviceDispatchTable *below_backend);
void snapshots_destroy(struct snapshots *snapshots); /* accepts NULL */

/* Of assay.h, on backend driver. */
extern __typeof__(*(PFN_vkGetCountersASSAY)0) snapshots_GetCountersASSAY;

/* Marks executions as reached when they run, and releases them behind all other consumers of their
 * batch. Add it before those that use executions. */
struct batch_consumer snapshots_consumer(struct snapshots *snapshots);
/* The order is unknown: run the execution, which is taken over, or all that batches have. */
void snapshots_run_unordered(struct snapshots *snapshots, struct execution *execution);
void snapshots_run_all(struct snapshots *snapshots);
/* Called when the order has ended: releases executions that never ran. Accepts NULL. */
void snapshots_release_held(struct snapshots *snapshots);

/* Called when the host may have observed a completion, or is about to submit: consumers use the
 * copies of the executions that the host has observed to be complete. */
static inline void snapshots_deliver(const struct layer_device *device)
{
    if (device->snapshots)
        execution_order_deliver(device->order);
}

/* Whether a buffer has the usage that copies from it need, including the usage that the layer added
 * when the buffer was created (nv_builds.c). */
bool snapshots_can_copy(struct snapshots *snapshots, VkBuffer buffer);

/* Before the layer submits to a queue while the application does not: whether it may. Returns false
 * if a call of the application uses the queue, which may take long; if the queue waits for a signal
 * that was not submitted; or if the queue is unknown. Then try again after the next wait or
 * submission of the application. If true, calls of the application that use a queue wait until
 * snapshots_end_own_submission(); wait for nothing before that. */
bool snapshots_begin_own_submission(struct snapshots *snapshots, VkQueue queue);
void snapshots_end_own_submission(struct snapshots *snapshots);

/* Returns false if the queue is unknown. */
bool snapshots_queue_family(struct snapshots *snapshots, VkQueue queue, uint32_t *family);
void snapshots_release_queues(struct snapshots *snapshots);

/* The device for own_objects.h. */
static inline struct own_device snapshots_own_device(const struct snapshots *snapshots)
{
    const struct layer_device *device = snapshots->device;
    return (struct own_device){device->handle, &snapshots->next, &device->memory};
}

/* The snapshots of the device to which a VkDevice or VkQueue belongs. */
static inline struct snapshots *snapshots_of(const void *dispatchable)
{
    return layer_find_device(dispatchable)->snapshots;
}

/* The snapshots of a command buffer's device. Returns NULL if the handle is invalid. */
static inline struct snapshots *snapshots_of_recording(VkCommandBuffer handle)
{
    struct layer_device *device = layer_find_recording_device(handle);
    return device ? device->snapshots : NULL;
}

#endif
