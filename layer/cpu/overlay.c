/* SPDX-License-Identifier: Apache-2.0 */
/* Selects the commands of instances and devices that the backend replaces. */
#include "layer/cpu/overlay.h"

#include <stdlib.h>
#include <string.h>

#include "backend.h"
#include "layer/cpu/advertise.h"

/* ---- instances */

void cpu_overlay_instance(struct layer_instance *instance)
{
    instance->next = instance->vk;
    cover_instance(&instance->vk);
}

/* ---- devices */

static bool is_enabled(const VkDeviceCreateInfo *create_info, const char *extension)
{
    for (uint32_t i = 0; i < create_info->enabledExtensionCount; i++)
        if (strcmp(create_info->ppEnabledExtensionNames[i], extension) == 0)
            return true;
    return false;
}

/* Writes zeros if the version is 1.0: VkPhysicalDeviceIDProperties came with Vulkan 1.1. The
 * commands that serialize structures, which use the id, need Vulkan 1.1, too. */
static void find_driver_uuid(const struct layer_device *device, uint8_t uuid[VK_UUID_SIZE])
{
    VkPhysicalDeviceIDProperties ids = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_ID_PROPERTIES};
    VkPhysicalDeviceProperties2 properties = {
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2, .pNext = &ids};
    if (device->facts.api_version >= VK_API_VERSION_1_1)
        device->instance->vk.GetPhysicalDeviceProperties2(device->physical_device, &properties);
    memcpy(uuid, ids.driverUUID, VK_UUID_SIZE);
}

VkResult cpu_overlay_create(struct layer_device *device, const VkDeviceCreateInfo *create_info)
{
    const bool khr = is_enabled(create_info, VK_KHR_ACCELERATION_STRUCTURE_EXTENSION_NAME);
    const bool nv = is_enabled(create_info, VK_NV_RAY_TRACING_EXTENSION_NAME);
    const bool deferred = is_enabled(create_info, VK_KHR_DEFERRED_HOST_OPERATIONS_EXTENSION_NAME);
    if ((!khr && !nv && !deferred) || !cpu_advertises(device->instance, device->physical_device))
        return VK_SUCCESS;
    struct cpu_overlay *overlay = calloc(1, sizeof(*overlay));
    uint8_t uuid[VK_UUID_SIZE];
    find_driver_uuid(device, uuid);
    if (!overlay)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    device->cpu = overlay;
    if (cpu_device_create(uuid, &overlay->device) != VK_SUCCESS ||
        cpu_playback_create(overlay->device, device->resources, &overlay->playback) != VK_SUCCESS)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    overlay->acceleration_structure = khr;
    overlay->ray_tracing_nv = nv;
    overlay->structures = khr || nv;
    overlay->deferred_host_operations = deferred;
    overlay->opacity_micromap_ext = is_enabled(create_info, VK_EXT_OPACITY_MICROMAP_EXTENSION_NAME);
    overlay->device->has_micromaps =
        overlay->opacity_micromap_ext ||
        is_enabled(create_info, VK_KHR_OPACITY_MICROMAP_EXTENSION_NAME);
    overlay->next = device->vk;
    cover_device(&device->vk, overlay);
    return VK_SUCCESS;
}

void cpu_overlay_destroy(struct cpu_overlay *overlay)
{
    if (!overlay)
        return;
    cpu_playback_destroy(overlay->playback);
    cpu_device_destroy(overlay->device);
    free(overlay);
}
