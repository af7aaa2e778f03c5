/* SPDX-License-Identifier: Apache-2.0 */
/* What the loader asks first: negotiation, instances, physical devices and their groups; devices
 * and their queues. */
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

#define EXPORTED(name) __attribute__((visibility("default"))) __typeof__(*(PFN_##name)NULL) name;
EXPORTED(vk_icdNegotiateLoaderICDInterfaceVersion)
EXPORTED(vk_icdGetInstanceProcAddr)
EXPORTED(vk_icdGetPhysicalDeviceProcAddr)

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
    for (uint32_t i = 0; i < NULL_DRIVER_PHYSICAL_DEVICES; i++) {
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

static void list_devices(VkInstance instance,
                         VkPhysicalDevice devices[NULL_DRIVER_PHYSICAL_DEVICES])
{
    for (uint32_t i = 0; i < NULL_DRIVER_PHYSICAL_DEVICES; i++)
        devices[i] =
            (VkPhysicalDevice)object_child(OBJECT(instance), VK_OBJECT_TYPE_PHYSICAL_DEVICE, i);
}

COMMAND(EnumeratePhysicalDevices)
{
    VkPhysicalDevice devices[NULL_DRIVER_PHYSICAL_DEVICES];
    list_devices(instance, devices);
    return enumerate(pPhysicalDeviceCount, pPhysicalDevices, devices, NULL_DRIVER_PHYSICAL_DEVICES,
                     sizeof(devices[0]));
}

COMMAND(EnumeratePhysicalDeviceGroups)
{
    VkPhysicalDeviceGroupProperties *group = pPhysicalDeviceGroupProperties;
    if (group != NULL && *pPhysicalDeviceGroupCount == 0)
        return VK_INCOMPLETE;
    *pPhysicalDeviceGroupCount = 1;
    if (group != NULL) {
        group->physicalDeviceCount = NULL_DRIVER_PHYSICAL_DEVICES;
        group->subsetAllocation = VK_TRUE;
        list_devices(instance, group->physicalDevices);
    }
    return VK_SUCCESS;
}

/* ---- devices and their queues */

/* Enables it; false where it is not offered. */
static bool enable_extension(struct object *device, const char *name)
{
    const struct null_driver_config *config = device->config;
    for (enum guard guard = FIRST_EXTENSION; guard < GUARD_COUNT; guard++) {
        if (strcmp(guard_extension_name(guard), name) == 0) {
            device->device.enabled[guard] = guard_is_offered(config, guard);
            return device->device.enabled[guard];
        }
    }
    for (uint32_t i = 0; i < config->extra_extension_count; i++) {
        if (strcmp(config->extra_extensions[i], name) == 0)
            return true;
    }
    return false;
}

static VkResult create_queues(struct object *device, const VkDeviceQueueCreateInfo *info)
{
    const struct null_driver_config *config = device->config;
    if (info->queueFamilyIndex >= config->queue_family_count ||
        info->queueCount > config->queue_families[info->queueFamilyIndex].queueCount)
        return VK_ERROR_INITIALIZATION_FAILED;
    for (uint32_t i = 0; i < info->queueCount; i++) {
        struct object *queue = object_create(device, VK_OBJECT_TYPE_QUEUE, NULL);
        if (queue == NULL)
            return VK_ERROR_OUT_OF_HOST_MEMORY;
        queue->queue.family = info->queueFamilyIndex;
        queue->queue.index = i;
        queue->queue.flags = info->flags;
    }
    return VK_SUCCESS;
}

static VkResult set_up_device(struct object *device, const VkDeviceCreateInfo *info)
{
    for (uint32_t i = 0; i < info->enabledExtensionCount; i++) {
        if (!enable_extension(device, info->ppEnabledExtensionNames[i]))
            return VK_ERROR_EXTENSION_NOT_PRESENT;
    }
    if (!features_are_on(device->config, info->pNext, info->pEnabledFeatures))
        return VK_ERROR_FEATURE_NOT_PRESENT;
    for (uint32_t i = 0; i < info->queueCreateInfoCount; i++) {
        const VkResult result = create_queues(device, &info->pQueueCreateInfos[i]);
        if (result != VK_SUCCESS)
            return result;
    }
    return VK_SUCCESS;
}

COMMAND(CreateDevice)
{
    struct object *device = object_create(OBJECT(physicalDevice), VK_OBJECT_TYPE_DEVICE, NULL);
    if (device == NULL)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    const VkResult result = set_up_device(device, pCreateInfo);
    if (result != VK_SUCCESS) {
        object_destroy_dispatchable(device, VK_OBJECT_TYPE_DEVICE);
        return result;
    }
    *pDevice = (VkDevice)device;
    return VK_SUCCESS;
}

COMMAND(GetDeviceQueue2)
{
    struct object *queue;
    *pQueue = VK_NULL_HANDLE;
    for (uint32_t i = 0; *pQueue == VK_NULL_HANDLE &&
                         (queue = object_child(OBJECT(device), VK_OBJECT_TYPE_QUEUE, i)) != NULL;
         i++)
        if (queue->queue.family == pQueueInfo->queueFamilyIndex &&
            queue->queue.index == pQueueInfo->queueIndex && queue->queue.flags == pQueueInfo->flags)
            *pQueue = (VkQueue)queue;
}
