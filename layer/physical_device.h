/* SPDX-License-Identifier: Apache-2.0 */
/* Queries of a physical device, if the application itself may make them.
 *
 * A layer below reports calls that the application's version and extensions do not allow, so this
 * layer avoids them too. Vulkan 1.1 has these queries; VK_KHR_get_physical_device_properties2 has
 * them for Vulkan 1.0. */
#ifndef ASSAY_LAYER_PHYSICAL_DEVICE_H
#define ASSAY_LAYER_PHYSICAL_DEVICE_H

#include "layer/layer.h"

/* The lower of two versions: the application's and the physical device's. */
uint32_t physical_device_api_version(const struct layer_instance *instance,
                                     VkPhysicalDevice physical_device);

/* The command in `vk`, which is the next layer's table or the backend's. Returns NULL if neither
 * the core command nor the extension's may be called. */
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
