/* SPDX-License-Identifier: Apache-2.0 */
/* Snapshots of the input data of builds in command buffers: an overlay on a device's dispatch
 * table, above whatever executes the builds. It records the copies, tracks submissions, and hands
 * each execution to the registered consumers (consumers.h) at its point in execution order. */
#ifndef ASSAY_LAYER_SNAPSHOTS_SNAPSHOTS_H
#define ASSAY_LAYER_SNAPSHOTS_SNAPSHOTS_H

#include <pthread.h>

#include "layer/layer.h"
#include "layer/own_objects.h"
#include "layer/snapshots/commands.h"
#include "src/base/handle_table.h"
#include "src/snapshots/recording.h"
#include "src/state/order/order.h"

struct fence_ticket;
struct gates;
struct own_shaders;
struct snapshots_consumer;
struct staging;

/* layer_device.snapshots; NULL if nothing needs any: on backend driver below level content, and for
 * a device that enables nothing that builds. */
struct snapshots {
    struct layer_device *device;
    struct snapshots_consumer *consumers; /* never changes once the device is published */
    /* A backend executes builds from the snapshots: each build is copied, whatever the budget, and
     * the application's fences signal after the copies can be read. */
    bool are_for_backend;
    VkuDeviceDispatchTable next; /* the next layer's, for objects and commands of the layer's own */
#define MEMBER(name) PFN_vk##name name;
    struct {
        SNAPSHOTS_COMMANDS(MEMBER)
    } below; /* what the overlay lies over: the backend's commands, or the next layer's */
#undef MEMBER
    PFN_vkSetDeviceLoaderData set_loader_data; /* may be NULL */
    struct staging *staging;
    struct gates *gates;
    struct own_shaders *shaders;
    bool has_addresses;           /* buffers have: bufferDeviceAddress is enabled */
    pthread_mutex_t buffers_lock; /* guards: */
    struct handle_table copyable; /* buffers that can be copied from; on backend cpu all can */
    pthread_mutex_t pools_lock;   /* guards: */
    struct handle_table uncounting_pools; /* of queries that count no compute work */
    _Atomic uint64_t bytes_copied;        /* that command buffers were told to copy */
    /* Submissions take their turns as they are made, for their order isn't known any more. */
    _Atomic bool order_unknown;
    enum order_unknown_reason unknown_reason; /* why; never changes after that */
    atomic_uint unordered;                    /* executions that had no other turn, */
    atomic_bool unordered_reported;           /* of which one warning speaks */
    atomic_bool lack_of_copies_reported;
    bool uses_queues; /* see snapshots_lock_queues() */
    pthread_mutex_t queue_lock;
    pthread_mutex_t families_lock;      /* guards: */
    struct handle_table queue_families; /* of queues, as pointers to their names */
    pthread_mutex_t tickets_lock;       /* guards: */
    struct fence_ticket *unfinished;    /* that nobody needs, but the device still uses */
    pthread_mutex_t submitted_lock;     /* guards: */
    struct execution *submitted, **submitted_last; /* submitted, and before their turn */
};

/* Once device->vk is filled in, with the backend's commands if there is one. `below_backend` are
 * the next layer's commands if a backend executes builds from the snapshots, or else NULL. */
VkResult snapshots_create(struct layer_device *device, const VkDeviceCreateInfo *create_info,
                          const VkuDeviceDispatchTable *below_backend);
void snapshots_destroy(struct snapshots *snapshots); /* NULL: nothing */

/* What vkGetDeviceProcAddr answers, where what lies below has `next`. */
PFN_vkVoidFunction snapshots_command(const struct snapshots *snapshots, const char *name,
                                     PFN_vkVoidFunction next);

/* An execution was submitted, after those that were expected before. Takes the reference. */
void snapshots_add_submitted(struct snapshots *snapshots, struct execution *execution);

struct batch_run;

/* A batch executes now: its executions go to the consumers. */
void snapshots_run(struct snapshots *snapshots, const struct batch_run *batch);
/* The order is unknown from now on: all executions go to the consumers, then and after each
 * submission. */
void snapshots_set_order_unknown(struct snapshots *snapshots, enum order_unknown_reason why);
void snapshots_run_all(struct snapshots *snapshots);

/* The host has seen something complete, or is about to submit: consumers use the copies of the
 * executions that are complete. */
void snapshots_deliver_complete(struct layer_device *device);
static inline void snapshots_deliver(struct layer_device *device)
{
    if (device->snapshots)
        snapshots_deliver_complete(device);
}

/* Whether a buffer has the usage that copies from it need, with what was added when it was created
 * (buffers.c). */
bool snapshots_can_copy(struct snapshots *snapshots, VkBuffer buffer);

/* Where the layer submits to the application's queues at times of its own choosing, around each use
 * of a queue; nothing elsewhere. */
void snapshots_lock_queues(struct snapshots *snapshots);
void snapshots_unlock_queues(struct snapshots *snapshots);

/* False where the queue isn't known. */
bool snapshots_queue_family(struct snapshots *snapshots, VkQueue queue, uint32_t *family);

/* For objects of the layer's own. */
static inline struct own_device snapshots_own_device(const struct snapshots *snapshots)
{
    const struct layer_device *device = snapshots->device;
    return (struct own_device){device->handle, &snapshots->next, &device->memory};
}

/* The snapshots of the device of a VkDevice or VkQueue. */
static inline struct snapshots *snapshots_of(const void *dispatchable)
{
    return layer_find_device(dispatchable)->snapshots;
}

/* The same of a command buffer. Returns NULL if the handle is invalid. */
static inline struct snapshots *snapshots_of_recording(VkCommandBuffer handle)
{
    struct layer_device *device = layer_find_recording_device(handle);
    return device ? device->snapshots : NULL;
}

#endif
