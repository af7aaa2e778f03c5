/* SPDX-License-Identifier: Apache-2.0 */
/* Backend cpu as an overlay on a device's dispatch table: for each command that it supplies,
 * device->vk has a function of layer/cpu instead of the next layer's, so that intercepts observe,
 * check and forward as on backend driver. What the next layer has stays in cpu_overlay.next. */
#ifndef ASSAY_LAYER_CPU_OVERLAY_H
#define ASSAY_LAYER_CPU_OVERLAY_H

#include "cpu/device.h"
#include "layer.h"

/* layer_device.cpu; NULL on backend driver. */
struct cpu_overlay {
    struct cpu_device *device;
    VkuDeviceDispatchTable next;
    /* extensions that the application has enabled, and that are the backend's */
    bool acceleration_structure, deferred_host_operations;
};

/* Once device->vk and device->facts are filled in. */
VkResult cpu_overlay_create(struct layer_device *device, const VkDeviceCreateInfo *create_info);
void cpu_overlay_destroy(struct cpu_overlay *overlay); /* NULL: nothing */

/* What vkGetDeviceProcAddr answers for a command that is the backend's: NULL where it isn't, or
 * where its extension isn't enabled. */
PFN_vkVoidFunction cpu_overlay_command(const struct cpu_overlay *overlay, const char *name);

/* The backend of a dispatchable handle's device. */
static inline struct cpu_overlay *cpu_overlay_of(const void *dispatchable)
{
    return layer_find_device(dispatchable)->cpu;
}

#endif
