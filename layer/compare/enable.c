/* SPDX-License-Identifier: Apache-2.0 */
/* Adds an extension that traces rays to the extensions that the application enables. */
#include "layer/compare/enable.h"

#include <stdlib.h>
#include <string.h>

#include "layer/physical_device.h"
#include "src/base/chain.h"

/* The extensions that trace rays, in order of preference. The feature is the first member of its
 * structure. */
static const struct trace_method {
    const char *extension;
    VkStructureType features;
} methods[] = {
    {VK_KHR_RAY_QUERY_EXTENSION_NAME, VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_RAY_QUERY_FEATURES_KHR},
    {VK_KHR_RAY_TRACING_PIPELINE_EXTENSION_NAME,
     VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_RAY_TRACING_PIPELINE_FEATURES_KHR},
};

enum { METHODS = sizeof(methods) / sizeof(methods[0]) };

static VkBool32 *feature_of(void *features)
{
    return (VkBool32 *)&((VkBaseOutStructure *)features)[1];
}

/* Version 1.2 includes everything that either extension requires besides acceleration
 * structures. */
static bool can_add(const struct layer_device *device, const struct trace_method *method,
                    struct compare_enabling *enabling)
{
    const VkuInstanceDispatchTable *vk = &device->instance->vk;
    VkPhysicalDeviceProperties properties;
    VkPhysicalDeviceFeatures2 features = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2,
                                          .pNext = &enabling->features};
    memset(&enabling->features, 0, sizeof(enabling->features));
    enabling->features.queries.sType = method->features;
    vk->GetPhysicalDeviceProperties(device->physical_device, &properties);
    if (properties.apiVersion < VK_API_VERSION_1_2 ||
        device->instance->api_version < VK_API_VERSION_1_2 ||
        !physical_device_has_extension(device, method->extension))
        return false;
    vk->GetPhysicalDeviceFeatures2(device->physical_device, &features);
    return *feature_of(&enabling->features);
}

static bool add_name(const VkDeviceCreateInfo *info, const char *name,
                     struct compare_enabling *enabling)
{
    uint32_t count = info->enabledExtensionCount;
    if (enables_extension(info, name))
        return true;
    enabling->names = malloc((count + 1ull) * sizeof(*enabling->names));
    if (!enabling->names)
        return false;
    if (count)
        memcpy(enabling->names, info->ppEnabledExtensionNames, count * sizeof(*enabling->names));
    enabling->names[count] = name;
    enabling->changed.enabledExtensionCount = count + 1;
    enabling->changed.ppEnabledExtensionNames = enabling->names;
    return true;
}

/* Enables the feature in a copy of the application's structure, or in a new structure before the
 * chain. */
static bool add_feature(const VkDeviceCreateInfo *info, VkStructureType type,
                        struct compare_enabling *enabling)
{
    if (chain_copy_begin(&enabling->chain, info->pNext, type) != VK_SUCCESS)
        return false;
    if (enabling->chain.found) {
        *feature_of(enabling->chain.found) = VK_TRUE;
        enabling->changed.pNext = enabling->chain.first;
        return true;
    }
    memset(&enabling->features, 0, sizeof(enabling->features));
    enabling->features.queries.sType = type;
    enabling->features.queries.pNext = (void *)(uintptr_t)info->pNext;
    *feature_of(&enabling->features) = VK_TRUE;
    enabling->changed.pNext = &enabling->features;
    return true;
}

/* Returns the extension that the application enables itself, or NULL. */
static const struct trace_method *find_enabled(const VkDeviceCreateInfo *info)
{
    for (int i = 0; i < METHODS; i++) {
        const VkBaseInStructure *features = chain_find(info->pNext, methods[i].features);
        if (features && *(const VkBool32 *)&features[1] &&
            enables_extension(info, methods[i].extension))
            return &methods[i];
    }
    return NULL;
}

static const struct trace_method *find_addable(const struct layer_device *device,
                                               struct compare_enabling *enabling)
{
    for (int i = 0; i < METHODS; i++)
        if (can_add(device, &methods[i], enabling))
            return &methods[i];
    return NULL;
}

void compare_enabling_begin(const struct layer_device *device, const VkDeviceCreateInfo *info,
                            struct compare_enabling *enabling)
{
    *enabling = (struct compare_enabling){.info = info, .changed = *info};
    const struct trace_method *enabled = find_enabled(info);
    const struct trace_method *method = enabled ? enabled : find_addable(device, enabling);
    if (!method)
        return;
    if (!enabled && (!add_name(info, method->extension, enabling) ||
                     !add_feature(info, method->features, enabling)))
        return;
    enabling->has_queries = method == &methods[0];
    enabling->is_enabled = true;
    if (!enabled)
        enabling->info = &enabling->changed;
}

void compare_enabling_end(struct compare_enabling *enabling)
{
    chain_copy_end(&enabling->chain);
    free(enabling->names);
    enabling->names = NULL;
}
