/* SPDX-License-Identifier: Apache-2.0 */
/* Backend cpu as an overlay on dispatch tables. For each command that it implements, device->vk
 * (and instance->vk) holds a function of layer/cpu instead of the next layer's, so that intercepts
 * observe, check and forward as on backend driver. cpu_overlay.next (and instance->next) keeps the
 * next layer's commands. */
#ifndef ASSAY_LAYER_CPU_OVERLAY_H
#define ASSAY_LAYER_CPU_OVERLAY_H

#include "layer/assay.h"
#include "layer/layer.h"
#include "src/cpu/device.h"
#include "src/cpu/playback.h"

/* Covers instance->vk, which must be filled in. */
void cpu_overlay_instance(struct layer_instance *instance);

/* Creates a device below, without the extensions and features that the backend supplies itself.
 * Fails and reports why if the application enables what cannot work. */
VkResult cpu_create_device(struct layer_device *device, PFN_vkCreateDevice create,
                           const VkDeviceCreateInfo *create_info,
                           const VkAllocationCallbacks *allocator, VkDevice *handle);

/* layer_device.cpu; NULL on backend driver, and for a device that enables none of the backend's
 * extensions. */
struct cpu_overlay {
    struct cpu_device *device;
    struct cpu_playback *playback;
    VkuDeviceDispatchTable next;
    struct transfer *unfinished; /* that the device may still execute; used by the thread that
                                    delivers results */
    /* the backend's extensions that the application has enabled */
    bool acceleration_structure, ray_tracing_nv, deferred_host_operations, opacity_micromap_ext;
    bool structures; /* acceleration_structure or ray_tracing_nv */
};

/* Sets device->cpu and covers device->vk. Call after device->vk and device->facts are filled in. */
VkResult cpu_overlay_create(struct layer_device *device, const VkDeviceCreateInfo *create_info);
void cpu_overlay_destroy(struct cpu_overlay *overlay); /* accepts NULL */

/* Commands of assay.h, which no dispatch table has. */
extern __typeof__(*(PFN_vkTraceRaysASSAY)0) cpu_TraceRaysASSAY;
extern __typeof__(*(PFN_vkGetCountersASSAY)0) cpu_GetCountersASSAY;

#endif
