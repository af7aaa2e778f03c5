/* SPDX-License-Identifier: Apache-2.0 */
/* Chooses between a core command, the equivalent command of an extension, and neither. */
#include "layer/physical_device.h"

uint32_t physical_device_api_version(const struct layer_instance *instance,
                                     VkPhysicalDevice physical_device)
{
    VkPhysicalDeviceProperties properties;
    instance->vk.GetPhysicalDeviceProperties(physical_device, &properties);
    return properties.apiVersion < instance->api_version ? properties.apiVersion
                                                         : instance->api_version;
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
