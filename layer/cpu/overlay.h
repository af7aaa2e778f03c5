/* SPDX-License-Identifier: Apache-2.0 */
/* Backend cpu as an overlay on dispatch tables. For each command that it implements, device->vk
 * (and instance->vk) holds a function of layer/cpu instead of the next layer's, so that intercepts
 * observe, check and forward as on backend driver. cpu_overlay.down (and instance->down) keeps the
 * next layer's commands. */
#ifndef ASSAY_LAYER_CPU_OVERLAY_H
#define ASSAY_LAYER_CPU_OVERLAY_H

#include "layer/assay.h"
#include "layer/layer.h"
#include "src/base/handle_table.h"
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
    VkuDeviceDispatchTable down;
    struct transfer *unfinished;  /* that the device may still execute; used by the thread that
                                     delivers results */
    pthread_mutex_t mapping_lock; /* guards the next two members */
    struct handle_table mappings; /* where memory is mapped as a whole, by its handle: memory.c */
    bool lacks_mappings;          /* some could not be noted */
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

/* ---- Reports commands that cannot work on backend cpu: shaders cannot access a structure that is
 * built on the host. */

/* Reports that a command cannot do what the application requests, and names the setting that causes
 * it: "vkCommand(): WHAT ...". */
void cpu_report_unsupported(const struct layer_instance *instance, const char *command,
                            const char *what);

/* ---- Backend cpu as a consumer of batches: it executes builds at their point in execution order,
 * and writes results to buffers when the submission is complete. */

/* For a device with device->cpu. */
struct batch_consumer cpu_overlay_consumer(struct layer_device *device);

/* Writes a result through a mapping of its buffer's memory. Returns false if the host cannot do
 * that. */
bool cpu_write_by_host(const struct layer_device *device, const struct result_bytes *result);

/* Called before the device is destroyed: frees copies of results whose end was not observed. What
 * the device may still use stays until it is destroyed. `overlay` may be NULL. */
void cpu_overlay_end_transfers(struct cpu_overlay *overlay);

/* Warns once if something was built from the copies of a later execution, once if a structure was
 * used too early, once if something could not be built because the driver has not executed the
 * copies, and each time if the backend has refused commands of command buffers. */
void cpu_overlay_warn_of_occurrences(const struct layer_device *device);

/* ---- the extensions, features and limits that backend cpu advertises instead of the driver's */

/* Whether the backend advertises acceleration structures on a physical device. It requires what
 * VK_KHR_acceleration_structure requires of a physical device: Vulkan 1.1 and buffer device
 * addresses. The application may use Vulkan 1.0 if it enables
 * VK_KHR_get_physical_device_properties2, as VK_NV_ray_tracing demands. */
bool cpu_advertises(struct layer_instance *instance, VkPhysicalDevice physical_device);

/* Whether the backend advertises an extension, if it advertises any. */
bool cpu_advertises_extension(const char *name);

/* The features that the backend supports, in the structure that queries them; its pNext is NULL. */
struct cpu_features {
    const VkBaseInStructure *structure;
    const char *lacking; /* names of the structure's features that the backend lacks */
};
enum { CPU_FEATURES = 7 };
extern const struct cpu_features cpu_features[CPU_FEATURES];

/* The entry for a structure type. Returns NULL if there is none. */
const struct cpu_features *cpu_find_features(VkStructureType type);

#endif
