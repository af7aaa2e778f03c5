/* SPDX-License-Identifier: Apache-2.0 */
/* What the loader asks first: negotiation, instances, physical devices and their groups. */
#include "tests/null_driver/internal.h"

#include <stdlib.h>

static const VkExtensionProperties instance_extensions[] = {
    {VK_EXT_DEBUG_UTILS_EXTENSION_NAME, 2},
    {VK_KHR_DEVICE_GROUP_CREATION_EXTENSION_NAME, 1},
    {VK_KHR_EXTERNAL_FENCE_CAPABILITIES_EXTENSION_NAME, 1},
    {VK_KHR_EXTERNAL_MEMORY_CAPABILITIES_EXTENSION_NAME, 1},
    {VK_KHR_EXTERNAL_SEMAPHORE_CAPABILITIES_EXTENSION_NAME, 1},
    {VK_KHR_GET_PHYSICAL_DEVICE_PROPERTIES_2_EXTENSION_NAME, 2},
};

NULL_DRIVER_EXPORT __typeof__(*(
    PFN_vk_icdNegotiateLoaderICDInterfaceVersion)NULL) vk_icdNegotiateLoaderICDInterfaceVersion;
NULL_DRIVER_EXPORT __typeof__(*(PFN_vk_icdGetInstanceProcAddr)NULL) vk_icdGetInstanceProcAddr;
NULL_DRIVER_EXPORT
__typeof__(*(PFN_vk_icdGetPhysicalDeviceProcAddr)NULL) vk_icdGetPhysicalDeviceProcAddr;

VkResult vk_icdNegotiateLoaderICDInterfaceVersion(uint32_t *pVersion)
{
    if (*pVersion > 5)
        *pVersion = 5;
    return VK_SUCCESS;
}

PFN_vkVoidFunction vk_icdGetInstanceProcAddr(VkInstance instance, const char *pName)
{
    return entry_find(pName);
}

PFN_vkVoidFunction vk_icdGetPhysicalDeviceProcAddr(VkInstance instance, const char *pName)
{
    return entry_find_physical(pName);
}

VkResult enumerate(uint32_t *count, void *to, const void *from, uint32_t available, size_t size)
{
    if (to == NULL) {
        *count = available;
        return VK_SUCCESS;
    }
    const bool all = *count >= available;
    if (all)
        *count = available;
    memcpy(to, from, *count * size);
    return all ? VK_SUCCESS : VK_INCOMPLETE;
}

COMMAND(EnumerateInstanceExtensionProperties)
{
    return enumerate(pPropertyCount, pProperties, instance_extensions,
                     COUNT_OF(instance_extensions), sizeof(instance_extensions[0]));
}

static bool extension_is_known(const char *name)
{
    for (size_t i = 0; i < COUNT_OF(instance_extensions); i++) {
        if (strcmp(instance_extensions[i].extensionName, name) == 0)
            return true;
    }
    return false;
}

static void release_instance(struct object *instance)
{
    free(instance->instance_config);
}

COMMAND(CreateInstance)
{
    for (uint32_t i = 0; i < pCreateInfo->enabledExtensionCount; i++) {
        if (!extension_is_known(pCreateInfo->ppEnabledExtensionNames[i]))
            return VK_ERROR_EXTENSION_NOT_PRESENT;
    }
    struct null_driver_config *config = driver_allocate(NULL, sizeof(*config));
    struct object *instance = object_create(NULL, VK_OBJECT_TYPE_INSTANCE, release_instance);
    if (config == NULL || instance == NULL) {
        free(config);
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    }
    *config = config_current();
    instance->instance_config = config;
    instance->config = config;
    for (uint32_t i = 0; i < config->physical_device_count; i++) {
        struct object *physical = object_create(instance, VK_OBJECT_TYPE_PHYSICAL_DEVICE, NULL);
        if (physical == NULL) {
            object_destroy_dispatchable(instance, VK_OBJECT_TYPE_INSTANCE);
            return VK_ERROR_OUT_OF_HOST_MEMORY;
        }
        physical->physical_device.index = i;
    }
    entry_plan_failure();
    *pInstance = (VkInstance)instance;
    return VK_SUCCESS;
}

static uint32_t physical_devices(VkInstance instance,
                                 VkPhysicalDevice devices[NULL_DRIVER_MAX_PHYSICAL_DEVICES])
{
    const uint32_t count = CONFIG(instance)->physical_device_count;
    for (uint32_t i = 0; i < count; i++) {
        devices[i] =
            (VkPhysicalDevice)object_child(OBJECT(instance), VK_OBJECT_TYPE_PHYSICAL_DEVICE, i);
    }
    return count;
}

COMMAND(EnumeratePhysicalDevices)
{
    VkPhysicalDevice devices[NULL_DRIVER_MAX_PHYSICAL_DEVICES];
    const uint32_t count = physical_devices(instance, devices);
    return enumerate(pPhysicalDeviceCount, pPhysicalDevices, devices, count, sizeof(devices[0]));
}

COMMAND(EnumeratePhysicalDeviceGroups)
{
    VkPhysicalDevice devices[NULL_DRIVER_MAX_PHYSICAL_DEVICES];
    const uint32_t device_count = physical_devices(instance, devices);
    const uint32_t group_size =
        CONFIG(instance)->one_device_group && device_count > 0 ? device_count : 1;
    const uint32_t group_count = device_count / group_size;
    if (pPhysicalDeviceGroupProperties == NULL) {
        *pPhysicalDeviceGroupCount = group_count;
        return VK_SUCCESS;
    }
    const bool all = *pPhysicalDeviceGroupCount >= group_count;
    if (all)
        *pPhysicalDeviceGroupCount = group_count;
    for (uint32_t i = 0; i < *pPhysicalDeviceGroupCount; i++) {
        pPhysicalDeviceGroupProperties[i].physicalDeviceCount = group_size;
        memcpy(pPhysicalDeviceGroupProperties[i].physicalDevices, &devices[i * group_size],
               group_size * sizeof(devices[0]));
        pPhysicalDeviceGroupProperties[i].subsetAllocation = VK_TRUE;
    }
    return all ? VK_SUCCESS : VK_INCOMPLETE;
}
