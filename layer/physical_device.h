/* SPDX-License-Identifier: Apache-2.0 */
/* Queries of a physical device, as far as the application itself may make them.
 *
 * A layer below reports calls that the application's version and extensions do not allow, so the
 * layer may not make them either. Vulkan 1.1 has these queries; before that they are of
 * VK_KHR_get_physical_device_properties2. */
#ifndef ASSAY_LAYER_PHYSICAL_DEVICE_H
#define ASSAY_LAYER_PHYSICAL_DEVICE_H

#include "layer/layer.h"

/* The lower of the version that the application asked for and the physical device's. */
uint32_t physical_device_api_version(const struct layer_instance *instance,
                                     VkPhysicalDevice physical_device);

/* The command in `vk`, the next layer's or the backend's; NULL if neither the core command nor the
 * extension's may be called. */
PFN_vkGetPhysicalDeviceFeatures2 physical_device_features2(const struct layer_instance *instance,
                                                           const VkuInstanceDispatchTable *vk,
                                                           VkPhysicalDevice physical_device);
PFN_vkGetPhysicalDeviceProperties2
physical_device_properties2(const struct layer_instance *instance,
                            const VkuInstanceDispatchTable *vk, VkPhysicalDevice physical_device);
PFN_vkGetPhysicalDeviceFormatProperties2
physical_device_format_properties2(const struct layer_instance *instance,
                                   const VkuInstanceDispatchTable *vk,
                                   VkPhysicalDevice physical_device);

#endif
