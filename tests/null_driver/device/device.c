/* SPDX-License-Identifier: Apache-2.0 */
/* Devices: what they were created with, and their queues. */
#include "tests/null_driver/internal.h"

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

static VkResult set_up(struct object *device, const VkDeviceCreateInfo *info)
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
    const VkResult result = set_up(device, pCreateInfo);
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
