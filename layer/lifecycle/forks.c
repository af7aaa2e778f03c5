/* SPDX-License-Identifier: Apache-2.0 */
/* The instances and devices of a parent process in the child of a fork.
 *
 * Vulkan says nothing about forks, and drivers do not support that a child uses objects of its
 * parent. So the layer validates nothing of them: it forwards their calls, and neither hangs nor
 * crashes. Instances that the child creates are validated as usual. */
#include <stdlib.h>
#include <string.h>

#include "layer/cpu/overlay.h"
#include "layer/layer.h"
#include "layer/snapshots/snapshots.h"

struct layer_instance *layer_replace_instance(const struct layer_instance *old)
{
    struct layer_instance *instance = malloc(sizeof(*instance));
    if (!instance)
        return NULL;
    *instance = *old;
    instance->reporter = reporter_create_silent(old->reporter);
    if (instance->reporter)
        return instance;
    free(instance);
    return NULL;
}

/* The next layer's commands, without those of the overlays. */
static const VkuDeviceDispatchTable *next_of(const struct layer_device *old)
{
    if (old->cpu)
        return &old->cpu->down;
    return old->snapshots ? &old->snapshots->next : &old->vk;
}

static bool copy_constants(struct layer_device *device, const struct layer_device *old,
                           struct layer_instance *instance)
{
    const size_t size = old->queue_family_count * sizeof(*device->queue_families);
    device->queue_families = malloc(size ? size : 1);
    if (!device->queue_families)
        return false;
    memcpy(device->queue_families, old->queue_families, size);
    device->queue_family_count = old->queue_family_count;
    device->link.key = old->link.key;
    device->handle = old->handle;
    device->physical_device = old->physical_device;
    device->instance = instance;
    device->vk = *next_of(old);
    device->harsh = old->harsh;
    device->facts = old->facts;
    device->level = old->level;
    device->memory = old->memory;
    /* What the parent has allocated is unknown, not invalid. No rule is active. */
    command_buffers_set_unknown(device->command_buffers);
    return true;
}

/* Overlays that know nothing. The application may have their commands from vkGetDeviceProcAddr. */
static VkResult cover_with_overlays(struct layer_device *device, const struct layer_device *old)
{
    const struct {
        bool is_enabled;
        const char *name;
    } extensions[] = {
        {old->cpu && old->cpu->acceleration_structure,
         VK_KHR_ACCELERATION_STRUCTURE_EXTENSION_NAME},
        {old->cpu && old->cpu->ray_tracing_nv, VK_NV_RAY_TRACING_EXTENSION_NAME},
        {old->cpu && old->cpu->deferred_host_operations,
         VK_KHR_DEFERRED_HOST_OPERATIONS_EXTENSION_NAME},
        {old->cpu && old->cpu->opacity_micromap_ext, VK_EXT_OPACITY_MICROMAP_EXTENSION_NAME},
    };
    enum { EXTENSIONS = sizeof(extensions) / sizeof(extensions[0]) };
    const char *names[EXTENSIONS];
    VkPhysicalDeviceBufferDeviceAddressFeatures addresses = {
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_BUFFER_DEVICE_ADDRESS_FEATURES,
        .bufferDeviceAddress = old->snapshots->has_addresses,
    };
    const VkLayerDeviceCreateInfo loader = {
        .sType = VK_STRUCTURE_TYPE_LOADER_DEVICE_CREATE_INFO,
        .pNext = &addresses,
        .function = VK_LOADER_DATA_CALLBACK,
        .u.pfnSetDeviceLoaderData = old->snapshots->set_loader_data,
    };
    VkDeviceCreateInfo info = {.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO,
                               .pNext = &loader,
                               .ppEnabledExtensionNames = names};
    for (unsigned i = 0; i < EXTENSIONS; i++)
        if (extensions[i].is_enabled)
            names[info.enabledExtensionCount++] = extensions[i].name;
    VkResult result = old->cpu ? cpu_overlay_create(device, &info) : VK_SUCCESS;
    if (result == VK_SUCCESS)
        result = snapshots_create(device, &info, device->cpu ? &device->cpu->down : NULL);
    return result;
}

struct layer_device *layer_replace_device(const struct layer_device *old,
                                          struct layer_instance *instance)
{
    struct layer_device *device = layer_allocate_device();
    if (!device)
        return NULL;
    if (instance && copy_constants(device, old, instance) &&
        (!old->snapshots || cover_with_overlays(device, old) == VK_SUCCESS) &&
        layer_track_submissions(device) == VK_SUCCESS &&
        layer_register_consumers(device) == VK_SUCCESS)
        return device;
    layer_free_device(device);
    return NULL;
}
