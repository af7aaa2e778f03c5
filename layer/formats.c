/* SPDX-License-Identifier: Apache-2.0 */
/* Queries format features, for most formats only once. */
#include "layer/formats.h"

#include <stdatomic.h>

#include "layer/physical_device.h"
#include "src/view/formats.h"

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
static enum tristate find(const struct layer_device *device, VkFormat format,
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
    return find(device, format, device->vertex_formats, query_vertices);
}

enum tristate layer_radius_format_supported(struct layer_device *device, VkFormat format)
{
    return find(device, format, device->radius_formats, query_radii);
}
