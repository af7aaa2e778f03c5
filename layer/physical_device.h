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

bool physical_device_has_extension(const struct layer_device *device, const char *name);

/* ---- Which formats the physical device supports as inputs of builds. Both functions return
 * UNKNOWN if the value is no format. */

enum tristate layer_vertex_format_supported(struct layer_device *device, VkFormat format);
enum tristate layer_radius_format_supported(struct layer_device *device, VkFormat format);

/* ---- Sizes of builds. The commands below the layer are called once for each shape of a build;
 * size_cache.h keeps the result. */

/* Writes what vkGetAccelerationStructureBuildSizesKHR returns; `counts` are the primitive counts.
 * Leaves `sizes` unchanged if the device has no such command, or may not call it. */
void layer_find_build_sizes(struct layer_device *device,
                            const VkAccelerationStructureBuildGeometryInfoKHR *info,
                            const uint32_t *counts, VkAccelerationStructureBuildTypeKHR build_type,
                            struct size_facts *sizes);

/* ---- device addresses of acceleration structures that the application did not query */

/* Queries the next layer for the address of a structure, or of all if `structure` is
 * VK_NULL_HANDLE, if it is unknown and the query is valid. A query may change what a layer below
 * reports, because the Khronos layer learns addresses from queries: call this only if an address is
 * needed. */
void layer_query_accel_address(struct layer_device *device, VkAccelerationStructureKHR structure);

/* Whether the device can read serialized data of a version; UNKNOWN if it cannot be asked. Calls
 * down. */
enum tristate layer_find_compatibility(const struct layer_device *device, bool is_micromap,
                                       const uint8_t version[2 * VK_UUID_SIZE]);

#endif
