/* SPDX-License-Identifier: Apache-2.0 */
/* Selects the commands of instances and devices that the backend replaces, and decides which of
 * the enabled extensions and features the driver receives. */
#include "layer/cpu/overlay.h"

#include <stdlib.h>

#include "backend.h"
#include "src/base/chain.h"
#include "src/base/text_buffer.h"
#include "src/report/words.h"
#include "vuid-tables/registry.h"

/* ---- instances */

void cpu_overlay_instance(struct layer_instance *instance)
{
    instance->down = instance->vk;
    cover_instance(&instance->vk);
}

/* ---- devices */

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
    const bool khr = enables_extension(create_info, VK_KHR_ACCELERATION_STRUCTURE_EXTENSION_NAME);
    const bool nv = enables_extension(create_info, VK_NV_RAY_TRACING_EXTENSION_NAME);
    const bool deferred =
        enables_extension(create_info, VK_KHR_DEFERRED_HOST_OPERATIONS_EXTENSION_NAME);
    if ((!khr && !nv && !deferred) || !cpu_advertises(device->instance, device->physical_device))
        return VK_SUCCESS;
    struct cpu_overlay *overlay = calloc(1, sizeof(*overlay));
    uint8_t uuid[VK_UUID_SIZE];
    find_driver_uuid(device, uuid);
    if (!overlay)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    device->cpu = overlay;
    pthread_mutex_init(&overlay->mapping_lock, NULL);
    if (cpu_device_create(uuid, &overlay->device) != VK_SUCCESS ||
        cpu_playback_create(overlay->device, device->resources, &overlay->playback) != VK_SUCCESS)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    overlay->acceleration_structure = khr;
    overlay->ray_tracing_nv = nv;
    overlay->structures = khr || nv;
    overlay->deferred_host_operations = deferred;
    overlay->opacity_micromap_ext =
        enables_extension(create_info, VK_EXT_OPACITY_MICROMAP_EXTENSION_NAME);
    overlay->device->has_micromaps =
        overlay->opacity_micromap_ext ||
        enables_extension(create_info, VK_KHR_OPACITY_MICROMAP_EXTENSION_NAME);
    overlay->down = device->vk;
    cover_device(&device->vk, overlay);
    return VK_SUCCESS;
}

void cpu_overlay_destroy(struct cpu_overlay *overlay)
{
    if (!overlay)
        return;
    cpu_playback_destroy(overlay->playback);
    cpu_device_destroy(overlay->device);
    handle_table_release(&overlay->mappings);
    pthread_mutex_destroy(&overlay->mapping_lock);
    free(overlay);
}

/* ---- what cannot work */

static VkResult check_extensions(const struct layer_instance *instance,
                                 const VkDeviceCreateInfo *create_info)
{
    VkResult result = VK_SUCCESS;
    for (uint32_t i = 0; i < create_info->enabledExtensionCount; i++) {
        const char *name = create_info->ppEnabledExtensionNames[i];
        if (cpu_advertises_extension(name) || !registry_is_ray_tracing(name))
            continue;
        cpu_report_unsupported(instance, "vkCreateDevice", name);
        result = VK_ERROR_EXTENSION_NOT_PRESENT;
    }
    return result;
}

/* Whether the application enables a feature that `advertised`, a structure of the same type, lacks.
 */
static bool requests_more(const VkBaseInStructure *asked, const VkBaseInStructure *advertised,
                          unsigned count)
{
    const VkBool32 *features = (const void *)&asked[1];
    const VkBool32 *ours = advertised ? (const void *)&advertised[1] : NULL;
    for (unsigned i = 0; i < count; i++)
        if (features[i] && !(ours && ours[i]))
            return true;
    return false;
}

static VkResult check_features(const struct layer_instance *instance,
                               const VkDeviceCreateInfo *create_info)
{
    VkResult result = VK_SUCCESS;
    for (const VkBaseInStructure *in = create_info->pNext; in; in = in->pNext) {
        const struct registry_structure *structure = registry_find_structure(in->sType);
        const struct cpu_features *ours = cpu_find_features(in->sType);
        if (!structure || !structure->ray_tracing ||
            !requests_more(in, ours ? ours->structure : NULL, structure->feature_count))
            continue;
        cpu_report_unsupported(instance, "vkCreateDevice",
                               ours ? ours->lacking : structure->ray_tracing);
        result = VK_ERROR_FEATURE_NOT_PRESENT;
    }
    return result;
}

/* ---- what the driver receives */

/* The extension names without those that the backend supplies. Returns NULL without memory. */
static const char **names_below(const VkDeviceCreateInfo *create_info, uint32_t *count)
{
    const char **names = malloc((create_info->enabledExtensionCount + 1) * sizeof(*names));
    *count = 0;
    for (uint32_t i = 0; names && i < create_info->enabledExtensionCount; i++)
        if (!cpu_advertises_extension(create_info->ppEnabledExtensionNames[i]))
            names[(*count)++] = create_info->ppEnabledExtensionNames[i];
    return names;
}

/* Removes the backend's features from a chain, by one copy of the chain for each. */
static VkResult chains_begin(struct chain_copy chains[CPU_FEATURES], const void **chain)
{
    for (size_t i = 0; i < CPU_FEATURES; i++) {
        VkResult result = chain_copy_begin(&chains[i], *chain, cpu_features[i].structure->sType);
        if (result != VK_SUCCESS)
            return result;
        if (chains[i].found)
            chain_copy_leave_out(&chains[i]);
        *chain = chains[i].first;
    }
    return VK_SUCCESS;
}

static VkResult create_below(struct layer_device *device, PFN_vkCreateDevice create,
                             const VkDeviceCreateInfo *create_info,
                             const VkAllocationCallbacks *allocator, VkDevice *handle)
{
    VkDeviceCreateInfo below = *create_info;
    struct chain_copy chains[CPU_FEATURES] = {0};
    VkResult result = chains_begin(chains, &below.pNext);
    if (result == VK_SUCCESS) {
        const char **names = names_below(create_info, &below.enabledExtensionCount);
        below.ppEnabledExtensionNames = names;
        result = names ? create(device->physical_device, &below, allocator, handle)
                       : VK_ERROR_OUT_OF_HOST_MEMORY;
        free(names);
    }
    for (size_t i = 0; i < CPU_FEATURES; i++)
        chain_copy_end(&chains[i]);
    return result;
}

VkResult cpu_create_device(struct layer_device *device, PFN_vkCreateDevice create,
                           const VkDeviceCreateInfo *create_info,
                           const VkAllocationCallbacks *allocator, VkDevice *handle)
{
    if (!cpu_advertises(device->instance, device->physical_device)) {
        reporter_warn(device->instance->reporter,
                      "assay_validation.backend = cpu needs a physical device of Vulkan 1.1 with "
                      "the feature bufferDeviceAddress, and an application that asks for Vulkan "
                      "1.1 or enables VK_KHR_get_physical_device_properties2; the driver executes "
                      "builds itself.");
        return create(device->physical_device, create_info, allocator, handle);
    }
    VkResult result = check_extensions(device->instance, create_info);
    if (result == VK_SUCCESS)
        result = check_features(device->instance, create_info);
    return result == VK_SUCCESS ? create_below(device, create, create_info, allocator, handle)
                                : result;
}

/* ---- words the reports of what cannot work */

void cpu_report_unsupported(const struct layer_instance *instance, const char *command,
                            const char *what)
{
    char line[512];
    struct text_buffer text;
    text_begin(&text, line, sizeof(line));
    text_say(&text,
             "{}(): {} cannot work, because assay_validation.backend is cpu: acceleration "
             "structures are built on the host, where shaders do not reach them. The driver's ray "
             "tracing needs assay_validation.backend = driver.",
             phrase(command), phrase(what));
    reporter_report_unsupported(instance->reporter, line);
}
