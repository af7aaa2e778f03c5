/* SPDX-License-Identifier: Apache-2.0 */
/* Backend cpu as an overlay on dispatch tables: for each command that it has, device->vk (and
 * instance->vk) has a function of layer/cpu instead of the next layer's, so that intercepts
 * observe, check and forward as on backend driver. What the next layer has stays in
 * cpu_overlay.next (and instance->next). */
#ifndef ASSAY_LAYER_CPU_OVERLAY_H
#define ASSAY_LAYER_CPU_OVERLAY_H

#include "layer/layer.h"
#include "layer/snapshots/consumers.h"
#include "src/cpu/device.h"
#include "src/cpu/playback.h"

/* Once instance->vk is filled in. */
void cpu_overlay_instance(struct layer_instance *instance);

/* What vkGetInstanceProcAddr answers, where the next layer has `next`. Of the extensions of a
 * device it knows nothing, so it has all commands. */
PFN_vkVoidFunction cpu_overlay_instance_command(const char *name, PFN_vkVoidFunction next);

/* Creates a device below, without what the backend keeps from it. Fails, and tells why, where the
 * application enables what cannot work. */
VkResult cpu_create_device(struct layer_device *device, PFN_vkCreateDevice create,
                           const VkDeviceCreateInfo *create_info,
                           const VkAllocationCallbacks *allocator, VkDevice *handle);

/* layer_device.cpu; NULL on backend driver, and for a device that enables nothing of the backend's.
 */
struct cpu_overlay {
    struct cpu_device *device;
    struct cpu_playback *playback;
    VkuDeviceDispatchTable next;
    struct snapshots_consumer consumer; /* see cpu_overlay_consumer() */
    /* extensions that the application has enabled, and that are the backend's */
    bool acceleration_structure, ray_tracing_nv, deferred_host_operations, opacity_micromap_ext;
    bool structures; /* one of the first two */
};

/* Once device->vk and device->facts are filled in. */
VkResult cpu_overlay_create(struct layer_device *device, const VkDeviceCreateInfo *create_info);
void cpu_overlay_destroy(struct cpu_overlay *overlay); /* NULL: nothing */

/* What vkGetDeviceProcAddr answers, where the next layer has `next`. */
PFN_vkVoidFunction cpu_overlay_command(const struct cpu_overlay *overlay, const char *name,
                                       PFN_vkVoidFunction next);

/* The backend of the device of a VkDevice or VkQueue. */
static inline struct cpu_overlay *cpu_overlay_of(const void *dispatchable)
{
    return layer_find_device(dispatchable)->cpu;
}

/* The next layer's commands for it. */
static inline const VkuDeviceDispatchTable *cpu_next(const void *dispatchable)
{
    return &cpu_overlay_of(dispatchable)->next;
}

/* Both of a command buffer. Return NULL if the handle is invalid. */
static inline struct cpu_overlay *cpu_overlay_of_recording(VkCommandBuffer handle)
{
    struct layer_device *device = layer_find_recording_device(handle);
    return device ? device->cpu : NULL;
}

static inline const VkuDeviceDispatchTable *cpu_next_of_recording(VkCommandBuffer handle)
{
    struct cpu_overlay *overlay = cpu_overlay_of_recording(handle);
    return overlay ? &overlay->next : NULL;
}

#endif
