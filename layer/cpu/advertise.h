/* SPDX-License-Identifier: Apache-2.0 */
/* The extensions, features and limits that backend cpu advertises instead of the driver's. */
#ifndef ASSAY_LAYER_CPU_ADVERTISE_H
#define ASSAY_LAYER_CPU_ADVERTISE_H

#include "layer/layer.h"

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
