/* SPDX-License-Identifier: Apache-2.0 */
/* Adding an extension that traces to what the application enables. */
#include "layer/compare/enable.h"

#include <stdlib.h>
#include <string.h>

#include "src/base/chain.h"

/* What traces, the better first. The feature is the first of its structure. */
static const struct way {
    const char *extension;
    VkStructureType features;
} ways[] = {
    {VK_KHR_RAY_QUERY_EXTENSION_NAME, VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_RAY_QUERY_FEATURES_KHR},
    {VK_KHR_RAY_TRACING_PIPELINE_EXTENSION_NAME,
     VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_RAY_TRACING_PIPELINE_FEATURES_KHR},
};

enum { WAYS = sizeof(ways) / sizeof(ways[0]) };

static VkBool32 *feature_of(void *features)
{
    return (VkBool32 *)&((VkBaseOutStructure *)features)[1];
}

static bool has_extension(const VkDeviceCreateInfo *info, const char *name)
{
    for (uint32_t i = 0; i < info->enabledExtensionCount; i++)
        if (strcmp(info->ppEnabledExtensionNames[i], name) == 0)
            return true;
    return false;
}

static bool advertises_extension(const struct layer_device *device, const char *name)
{
    const VkuInstanceDispatchTable *vk = &device->instance->vk;
    uint32_t count = 0;
    bool is_there = false;
    if (vk->EnumerateDeviceExtensionProperties(device->physical_device, NULL, &count, NULL) !=
        VK_SUCCESS)
        return false;
    VkExtensionProperties *advertised = calloc(count + 1ull, sizeof(*advertised));
    if (advertised && vk->EnumerateDeviceExtensionProperties(device->physical_device, NULL, &count,
                                                             advertised) == VK_SUCCESS)
        for (uint32_t i = 0; i < count; i++)
            is_there |= strcmp(advertised[i].extensionName, name) == 0;
    free(advertised);
    return is_there;
}

/* From version 1.2 on, what either needs beside acceleration structures is part of it. */
static bool can_add(const struct layer_device *device, const struct way *way,
                    struct compare_enabling *enabling)
{
    const VkuInstanceDispatchTable *vk = &device->instance->vk;
    VkPhysicalDeviceProperties properties;
    VkPhysicalDeviceFeatures2 features = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2,
                                          .pNext = &enabling->features};
    memset(&enabling->features, 0, sizeof(enabling->features));
    enabling->features.queries.sType = way->features;
    vk->GetPhysicalDeviceProperties(device->physical_device, &properties);
    if (properties.apiVersion < VK_API_VERSION_1_2 ||
        device->instance->api_version < VK_API_VERSION_1_2 ||
        !advertises_extension(device, way->extension))
        return false;
    vk->GetPhysicalDeviceFeatures2(device->physical_device, &features);
    return *feature_of(&enabling->features);
}

static bool add_name(const VkDeviceCreateInfo *info, const char *name,
                     struct compare_enabling *enabling)
{
    uint32_t count = info->enabledExtensionCount;
    if (has_extension(info, name))
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

/* In a copy of the application's structure, or in one before its own. */
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

/* The one that the application enables itself; or NULL. */
static const struct way *find_enabled(const VkDeviceCreateInfo *info)
{
    for (int i = 0; i < WAYS; i++) {
        const VkBaseInStructure *features = chain_find(info->pNext, ways[i].features);
        if (features && *(const VkBool32 *)&features[1] && has_extension(info, ways[i].extension))
            return &ways[i];
    }
    return NULL;
}

static const struct way *find_addable(const struct layer_device *device,
                                      struct compare_enabling *enabling)
{
    for (int i = 0; i < WAYS; i++)
        if (can_add(device, &ways[i], enabling))
            return &ways[i];
    return NULL;
}

void compare_enabling_begin(const struct layer_device *device, const VkDeviceCreateInfo *info,
                            struct compare_enabling *enabling)
{
    *enabling = (struct compare_enabling){.info = info, .changed = *info};
    enabling->is_wanted = reporter_settings(device->instance->reporter)->compare_rays > 0 &&
                          has_extension(info, VK_KHR_ACCELERATION_STRUCTURE_EXTENSION_NAME);
    if (!enabling->is_wanted)
        return;
    const struct way *enabled = find_enabled(info);
    const struct way *way = enabled ? enabled : find_addable(device, enabling);
    if (!way)
        return;
    if (!enabled &&
        (!add_name(info, way->extension, enabling) || !add_feature(info, way->features, enabling)))
        return;
    enabling->has_queries = way == &ways[0];
    enabling->is_enabled = true;
    enabling->is_added = !enabled;
    if (!enabled)
        enabling->info = &enabling->changed;
}

void compare_enabling_undo(struct compare_enabling *enabling, const VkDeviceCreateInfo *info)
{
    enabling->is_enabled = enabling->is_added = false;
    enabling->info = info;
}

void compare_enabling_end(struct compare_enabling *enabling)
{
    chain_copy_end(&enabling->chain);
    free(enabling->names);
}
