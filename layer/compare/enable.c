/* SPDX-License-Identifier: Apache-2.0 */
/* Adding VK_KHR_ray_query to what the application enables. */
#include "compare/enable.h"

#include <stdlib.h>
#include <string.h>

#include "state/chain.h"

static bool has_extension(const VkDeviceCreateInfo *info, const char *name)
{
    for (uint32_t i = 0; i < info->enabledExtensionCount; i++)
        if (strcmp(info->ppEnabledExtensionNames[i], name) == 0)
            return true;
    return false;
}

static bool offers_extension(const struct layer_device *device)
{
    const VkuInstanceDispatchTable *vk = &device->instance->vk;
    uint32_t count = 0;
    bool is_there = false;
    if (vk->EnumerateDeviceExtensionProperties(device->physical_device, NULL, &count, NULL) !=
        VK_SUCCESS)
        return false;
    VkExtensionProperties *offered = calloc(count + 1ull, sizeof(*offered));
    if (offered && vk->EnumerateDeviceExtensionProperties(device->physical_device, NULL, &count,
                                                          offered) == VK_SUCCESS)
        for (uint32_t i = 0; i < count; i++)
            is_there |= strcmp(offered[i].extensionName, VK_KHR_RAY_QUERY_EXTENSION_NAME) == 0;
    free(offered);
    return is_there;
}

/* From version 1.2 on, what the extension needs beside acceleration structures is part of it. */
static bool can_add(const struct layer_device *device)
{
    const VkuInstanceDispatchTable *vk = &device->instance->vk;
    VkPhysicalDeviceProperties properties;
    VkPhysicalDeviceRayQueryFeaturesKHR query = {
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_RAY_QUERY_FEATURES_KHR};
    VkPhysicalDeviceFeatures2 features = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2,
                                          .pNext = &query};
    vk->GetPhysicalDeviceProperties(device->physical_device, &properties);
    if (properties.apiVersion < VK_API_VERSION_1_2 ||
        device->instance->api_version < VK_API_VERSION_1_2 || !offers_extension(device))
        return false;
    vk->GetPhysicalDeviceFeatures2(device->physical_device, &features);
    return query.rayQuery;
}

static bool add_name(const VkDeviceCreateInfo *info, struct compare_enabling *enabling)
{
    uint32_t count = info->enabledExtensionCount;
    if (has_extension(info, VK_KHR_RAY_QUERY_EXTENSION_NAME))
        return true;
    enabling->names = malloc((count + 1ull) * sizeof(*enabling->names));
    if (!enabling->names)
        return false;
    if (count)
        memcpy(enabling->names, info->ppEnabledExtensionNames, count * sizeof(*enabling->names));
    enabling->names[count] = VK_KHR_RAY_QUERY_EXTENSION_NAME;
    enabling->changed.enabledExtensionCount = count + 1;
    enabling->changed.ppEnabledExtensionNames = enabling->names;
    return true;
}

/* In a copy of the application's structure, or in one before its own. */
static bool add_feature(const VkDeviceCreateInfo *info, struct compare_enabling *enabling)
{
    if (chain_copy_begin(&enabling->chain, info->pNext,
                         VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_RAY_QUERY_FEATURES_KHR) != VK_SUCCESS)
        return false;
    VkPhysicalDeviceRayQueryFeaturesKHR *found = enabling->chain.found;
    if (found) {
        found->rayQuery = VK_TRUE;
        enabling->changed.pNext = enabling->chain.first;
        return true;
    }
    enabling->features = (VkPhysicalDeviceRayQueryFeaturesKHR){
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_RAY_QUERY_FEATURES_KHR,
        .pNext = (void *)(uintptr_t)info->pNext,
        .rayQuery = VK_TRUE,
    };
    enabling->changed.pNext = &enabling->features;
    return true;
}

void compare_enabling_begin(const struct layer_device *device, const VkDeviceCreateInfo *info,
                            struct compare_enabling *enabling)
{
    *enabling = (struct compare_enabling){.info = info, .changed = *info};
    enabling->is_wanted = reporter_settings(device->instance->reporter)->compare_rays > 0 &&
                          has_extension(info, VK_KHR_ACCELERATION_STRUCTURE_EXTENSION_NAME);
    if (!enabling->is_wanted)
        return;
    const VkPhysicalDeviceRayQueryFeaturesKHR *features =
        chain_find(info->pNext, VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_RAY_QUERY_FEATURES_KHR);
    enabling->is_enabled =
        features && features->rayQuery && has_extension(info, VK_KHR_RAY_QUERY_EXTENSION_NAME);
    if (enabling->is_enabled || !can_add(device) || !add_name(info, enabling) ||
        !add_feature(info, enabling))
        return;
    enabling->is_enabled = enabling->is_added = true;
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
