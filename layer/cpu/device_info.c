/* SPDX-License-Identifier: Apache-2.0 */
/* Creates a device below the backend: decides which of the enabled extensions and features the
 * driver receives. */
#include <stdlib.h>

#include "layer/cpu/advertise.h"
#include "layer/cpu/overlay.h"
#include "layer/cpu/unsupported.h"
#include "src/base/chain_copy.h"
#include "vuid-tables/registry.h"

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
