/* SPDX-License-Identifier: Apache-2.0 */
/* What backend cpu says of a physical device in the driver's place. */
#ifndef ASSAY_LAYER_CPU_ADVERTISE_H
#define ASSAY_LAYER_CPU_ADVERTISE_H

#include "layer/layer.h"

/* Whether the backend offers acceleration structures there: Vulkan 1.1 and buffer device addresses
 * are what VK_KHR_acceleration_structure needs of a physical device. The application may ask for
 * Vulkan 1.0 if it enables VK_KHR_get_physical_device_properties2, as VK_NV_ray_tracing demands. */
bool cpu_advertises(const struct layer_instance *instance, VkPhysicalDevice physical_device);

/* Whether an extension is among those that the backend offers, where it offers any. */
bool cpu_advertises_extension(const char *name);

/* The features that the backend has, as the structure that tells of them; pNext is NULL. */
struct cpu_features {
    const VkBaseInStructure *structure;
    const char *lacking; /* names of that structure's features which the backend hasn't got */
};
enum { CPU_FEATURES = 7 };
extern const struct cpu_features cpu_features[CPU_FEATURES];

/* Of a structure's type, or NULL. */
const struct cpu_features *cpu_find_features(VkStructureType type);

#endif
