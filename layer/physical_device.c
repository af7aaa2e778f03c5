/* SPDX-License-Identifier: Apache-2.0 */
/* Chooses between a core command, the equivalent command of an extension, and neither; queries
 * format features, for most formats only once, and sizes of builds through the size cache. */
#include "layer/physical_device.h"

#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#include "src/base/recording_path.h"
#include "src/model/formats.h"

PFN_vkGetPhysicalDeviceFormatProperties2
physical_device_format_properties2(const struct layer_instance *instance,
                                   const VkuInstanceDispatchTable *vk,
                                   VkPhysicalDevice physical_device);

uint32_t physical_device_api_version(const struct layer_instance *instance,
                                     VkPhysicalDevice physical_device)
{
    VkPhysicalDeviceProperties properties;
    instance->vk.GetPhysicalDeviceProperties(physical_device, &properties);
    return properties.apiVersion < instance->api_version ? properties.apiVersion
                                                         : instance->api_version;
}

bool physical_device_has_extension(const struct layer_device *device, const char *name)
{
    const VkuInstanceDispatchTable *vk = &device->instance->vk;
    uint32_t count = 0;
    bool is_found = false;
    if (vk->EnumerateDeviceExtensionProperties(device->physical_device, NULL, &count, NULL) !=
        VK_SUCCESS)
        return false;
    VkExtensionProperties *extensions = calloc(count + 1ull, sizeof(*extensions));
    if (extensions && vk->EnumerateDeviceExtensionProperties(device->physical_device, NULL, &count,
                                                             extensions) == VK_SUCCESS)
        for (uint32_t i = 0; i < count; i++)
            is_found |= strcmp(extensions[i].extensionName, name) == 0;
    free(extensions);
    return is_found;
}

static bool has_core_queries(const struct layer_instance *instance,
                             VkPhysicalDevice physical_device)
{
    return physical_device_api_version(instance, physical_device) >= VK_API_VERSION_1_1;
}

/* A table may hold commands that the application may not call: the Khronos layer returns its own,
 * whatever the instance enables. */
#define CHOOSE(name)                                                                               \
    if (has_core_queries(instance, physical_device))                                               \
        return vk->name;                                                                           \
    return instance->has_properties2 ? vk->name##KHR : NULL;

PFN_vkGetPhysicalDeviceFeatures2
physical_device_features2(const struct layer_instance *instance, const VkuInstanceDispatchTable *vk,
                          VkPhysicalDevice physical_device){CHOOSE(GetPhysicalDeviceFeatures2)}

PFN_vkGetPhysicalDeviceProperties2
    physical_device_properties2(const struct layer_instance *instance,
                                const VkuInstanceDispatchTable *vk,
                                VkPhysicalDevice physical_device){
        CHOOSE(GetPhysicalDeviceProperties2)}

PFN_vkGetPhysicalDeviceFormatProperties2
    physical_device_format_properties2(const struct layer_instance *instance,
                                       const VkuInstanceDispatchTable *vk,
                                       VkPhysicalDevice physical_device)
{
    CHOOSE(GetPhysicalDeviceFormatProperties2)
}

/* ---- queries format features, for most formats only once */

static enum tristate query_vertices(const struct layer_device *device, VkFormat format)
{
    VkFormatProperties properties;
    device->instance->vk.GetPhysicalDeviceFormatProperties(device->physical_device, format,
                                                           &properties);
    return properties.bufferFeatures &
                   VK_FORMAT_FEATURE_ACCELERATION_STRUCTURE_VERTEX_BUFFER_BIT_KHR
               ? YES
               : NO;
}

/* A driver that ignores the structure leaves all bits set. */
static enum tristate query_radii(const struct layer_device *device, VkFormat format)
{
    PFN_vkGetPhysicalDeviceFormatProperties2 get_properties = physical_device_format_properties2(
        device->instance, &device->instance->vk, device->physical_device);
    VkFormatProperties3 features = {.sType = VK_STRUCTURE_TYPE_FORMAT_PROPERTIES_3,
                                    .bufferFeatures = UINT64_MAX};
    VkFormatProperties2 properties = {.sType = VK_STRUCTURE_TYPE_FORMAT_PROPERTIES_2,
                                      .pNext = &features};
    if (!get_properties)
        return UNKNOWN;
    get_properties(device->physical_device, format, &properties);
    if (features.bufferFeatures == UINT64_MAX)
        return UNKNOWN;
    return features.bufferFeatures & VK_FORMAT_FEATURE_2_ACCELERATION_STRUCTURE_RADIUS_BUFFER_BIT_NV
               ? YES
               : NO;
}

/* The driver is queried only for formats that exist. */
static enum tristate find_in_cache(const struct layer_device *device, VkFormat format,
                                   _Atomic unsigned char *cache,
                                   enum tristate (*query)(const struct layer_device *, VkFormat))
{
    bool is_cached = (uint32_t)format < FORMAT_CACHE_SIZE;
    enum tristate known = UNKNOWN;
    if (is_cached)
        known = (enum tristate)atomic_load_explicit(&cache[format], memory_order_relaxed);
    if (known != UNKNOWN || !format_is_known(format))
        return known;
    known = query(device, format);
    if (is_cached)
        atomic_store_explicit(&cache[format], (unsigned char)known, memory_order_relaxed);
    return known;
}

enum tristate layer_vertex_format_supported(struct layer_device *device, VkFormat format)
{
    return find_in_cache(device, format, device->vertex_formats, query_vertices);
}

enum tristate layer_radius_format_supported(struct layer_device *device, VkFormat format)
{
    return find_in_cache(device, format, device->radius_formats, query_radii);
}

/* ---- queries the sizes of builds, through the size cache */

/* The query ignores these members, and a layer below may still find them invalid: mode and source
 * of a micromap, or a structure that was destroyed. */
static VkAccelerationStructureBuildGeometryInfoKHR
without_ignored(const VkAccelerationStructureBuildGeometryInfoKHR *info)
{
    VkAccelerationStructureBuildGeometryInfoKHR query = *info;
    query.mode = VK_BUILD_ACCELERATION_STRUCTURE_MODE_BUILD_KHR;
    query.srcAccelerationStructure = query.dstAccelerationStructure = VK_NULL_HANDLE;
    query.scratchData = (VkDeviceOrHostAddressKHR){.deviceAddress = 0};
    return query;
}

ON_RECORDING_PATH void
layer_find_build_sizes(struct layer_device *device,
                       const VkAccelerationStructureBuildGeometryInfoKHR *info,
                       const uint32_t *counts, VkAccelerationStructureBuildTypeKHR build_type,
                       struct size_facts *sizes)
{
    struct build_shape shape;
    bool has_shape = build_shape_of(info, counts, build_type, &shape);
    if (has_shape && size_cache_find(device->sizes, &shape, sizes))
        return;
    if (!device->may_query_structures || !device->vk.GetAccelerationStructureBuildSizesKHR)
        return;
    VkAccelerationStructureBuildSizesInfoKHR answer = {
        .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_BUILD_SIZES_INFO_KHR};
    const VkAccelerationStructureBuildGeometryInfoKHR query = without_ignored(info);
    bool is_micromap = info->type == VK_ACCELERATION_STRUCTURE_TYPE_OPACITY_MICROMAP_KHR;
    device->vk.GetAccelerationStructureBuildSizesKHR(device->handle, build_type, &query,
                                                     is_micromap ? NULL : counts, &answer);
    *sizes = (struct size_facts){.known = true,
                                 .acceleration_structure = answer.accelerationStructureSize,
                                 .build_scratch = answer.buildScratchSize,
                                 .update_scratch = answer.updateScratchSize};
    if (has_shape)
        size_cache_add(device->sizes, &shape, sizes);
}

/* ---- device addresses of acceleration structures that the application did not query */

static VkDeviceAddress query(void *user, VkAccelerationStructureKHR structure)
{
    const struct layer_device *device = user;
    const VkAccelerationStructureDeviceAddressInfoKHR info = {
        .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_DEVICE_ADDRESS_INFO_KHR,
        .accelerationStructure = structure,
    };
    return device->vk.GetAccelerationStructureDeviceAddressKHR(device->handle, &info);
}

void layer_query_accel_address(struct layer_device *device, VkAccelerationStructureKHR structure)
{
    if (device->may_query_structures && device->vk.GetAccelerationStructureDeviceAddressKHR)
        resources_query_addresses(device->resources, structure, query, device);
}

enum tristate layer_find_compatibility(const struct layer_device *device, bool is_micromap,
                                       const uint8_t version[2 * VK_UUID_SIZE])
{
    VkAccelerationStructureCompatibilityKHR result =
        VK_ACCELERATION_STRUCTURE_COMPATIBILITY_MAX_ENUM_KHR;
    const VkAccelerationStructureVersionInfoKHR info = {
        .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_VERSION_INFO_KHR,
        .pVersionData = version};
    const VkMicromapVersionInfoEXT micromap_info = {
        .sType = VK_STRUCTURE_TYPE_MICROMAP_VERSION_INFO_EXT, .pVersionData = version};
    if (!is_micromap && device->vk.GetDeviceAccelerationStructureCompatibilityKHR)
        device->vk.GetDeviceAccelerationStructureCompatibilityKHR(device->handle, &info, &result);
    if (is_micromap && device->vk.GetDeviceMicromapCompatibilityEXT)
        device->vk.GetDeviceMicromapCompatibilityEXT(device->handle, &micromap_info, &result);
    switch (result) {
    case VK_ACCELERATION_STRUCTURE_COMPATIBILITY_COMPATIBLE_KHR:
        return YES;
    case VK_ACCELERATION_STRUCTURE_COMPATIBILITY_INCOMPATIBLE_KHR:
        return NO;
    default:
        return UNKNOWN;
    }
}
