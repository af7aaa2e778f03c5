/* SPDX-License-Identifier: Apache-2.0 */
/* Making instances and devices. */
#include "tests/rules/scene/fixture.h"

#include <stdio.h>
#include <stdlib.h>

#include "tests/fixture/make.h"
#include "tests/rules/scene/device_features.h"
#include "vuid-tables/registry.h"

/* ---- the instance ---- */

static uint32_t setup_api_version(const struct setup *setup)
{
    if (setup->api_version != 0)
        return setup->api_version;
    return setup->route == ROUTE_KHR ? VK_API_VERSION_1_1 : VK_API_VERSION_1_3;
}

/* Findings repeat from case to case of the same instance: none may be held back. Cases are about
 * one call each, without barriers. */
static void instance_create(struct fixture *fixture, const struct platform *platform)
{
    const struct setup *setup = &fixture->setup;
    instance_fixture_create(
        &fixture->instance, platform,
        &(struct instance_settings){.level = setup->level,
                                    .muted = setup->muted,
                                    .limit = "0",
                                    .hazards = setup->by_environment ? NULL : "false",
                                    .api_version = setup_api_version(setup),
                                    .by_environment = setup->by_environment,
                                    .hears_creation = true});
}

/* ---- the physical device ---- */

/* Which driver it is that the environment names, once. */
static void report_device(const struct fixture *fixture)
{
    static bool told;
    STRUCT(VkPhysicalDeviceDriverProperties, driver);
    STRUCT(VkPhysicalDeviceProperties2, properties, .pNext = &driver);

    if (told || !fixture->instance.platform->is_named)
        return;
    told = true;
    fixture->instance.vk.GetPhysicalDeviceProperties2(fixture->instance.physical, &properties);
    printf("[  DEVICE  ] %s, %s %s\n", properties.properties.deviceName, driver.driverName,
           driver.driverInfo);
}

static void physical_device_choose(struct fixture *fixture)
{
    fixture->limits = MAKE(VkPhysicalDeviceAccelerationStructurePropertiesKHR);
    STRUCT(VkPhysicalDeviceProperties2, properties, .pNext = &fixture->limits);
    fixture->instance.vk.GetPhysicalDeviceProperties2(fixture->instance.physical, &properties);
    fixture->instance.vk.GetPhysicalDeviceMemoryProperties(fixture->instance.physical,
                                                           &fixture->memory);
    fixture->family_count = FIXTURE_QUEUE_FAMILIES;
    fixture->instance.vk.GetPhysicalDeviceQueueFamilyProperties(
        fixture->instance.physical, &fixture->family_count, fixture->families);

    STRUCT(VkPhysicalDeviceAccelerationStructureFeaturesKHR, offered);
    STRUCT(VkPhysicalDeviceFeatures2, features, .pNext = &offered);
    fixture->instance.vk.GetPhysicalDeviceFeatures2(fixture->instance.physical, &features);
    fixture->has_indirect = offered.accelerationStructureIndirectBuild;
    fixture->has_host = offered.accelerationStructureHostCommands;
    report_device(fixture);
}

uint32_t fixture_find_family(const struct fixture *fixture, VkQueueFlags with, VkQueueFlags without)
{
    for (uint32_t i = 0; i < fixture->family_count; i++) {
        const VkQueueFlags flags = fixture->families[i].queueFlags;
        if ((flags & with) == with && (flags & without) == 0)
            return i;
    }
    return UINT32_MAX;
}

/* ---- the device ---- */

VkDevice fixture_create_device(struct fixture *fixture)
{
    const float priority = 1.0f;
    VkDeviceQueueCreateInfo queues[FIXTURE_QUEUE_FAMILIES];
    for (uint32_t i = 0; i < fixture->family_count; i++) {
        const bool is_protected = (fixture->setup.enable & ENABLE_PROTECTED) != 0 &&
                                  (fixture->families[i].queueFlags & VK_QUEUE_PROTECTED_BIT) != 0;
        queues[i] = MAKE(VkDeviceQueueCreateInfo,
                         .flags = is_protected ? VK_DEVICE_QUEUE_CREATE_PROTECTED_BIT : 0,
                         .queueFamilyIndex = i, .queueCount = 1, .pQueuePriorities = &priority);
    }
    const bool has_queues = (fixture->setup.enable & ENABLE_NO_QUEUES) == 0;
    const bool is_chained = fixture->setup.route == ROUTE_FEATURES2;
    struct device_wish wish;
    features_wish(&wish, fixture);
    STRUCT(
        VkDeviceCreateInfo, create_info, .pNext = is_chained ? &wish.features : wish.features.pNext,
        .pEnabledFeatures = is_chained ? NULL : &wish.features.features,
        .enabledExtensionCount = wish.extension_count, .ppEnabledExtensionNames = wish.extensions,
        .queueCreateInfoCount = has_queues ? fixture->family_count : 0,
        .pQueueCreateInfos = queues);

    STRUCT(VkDeviceGroupDeviceCreateInfo, group_info);
    VkPhysicalDevice devices[NULL_DRIVER_MAX_PHYSICAL_DEVICES];
    if ((fixture->setup.enable & ENABLE_GROUP) != 0) {
        group_info.physicalDeviceCount = NULL_DRIVER_MAX_PHYSICAL_DEVICES;
        fixture->instance.vk.EnumeratePhysicalDevices(fixture->instance.instance,
                                                      &group_info.physicalDeviceCount, devices);
        group_info.pPhysicalDevices = devices;
        group_info.pNext = create_info.pNext;
        create_info.pNext = &group_info;
    }
    VkDevice device;
    GET(fixture->instance.vk.CreateDevice(fixture->instance.physical, &create_info, NULL, &device));
    return device;
}

const char *fixture_open(struct fixture *fixture, const struct platform *platform,
                         const struct setup *setup)
{
    fixture->setup = *setup;
    if (setup->configure != NULL && platform->is_cpu)
        return "its limits and queue families are those of the backend";
    if (platform->is_null) {
        struct null_driver_config config = platform->null_driver.default_config();
        features_configure(&config, setup);
        for (size_t i = 0; platform->is_cpu && i < registry_ray_tracing_count; i++)
            null_driver_hide_extension(&config, registry_ray_tracing[i]);
        if (setup->configure != NULL)
            setup->configure(&config);
        platform->null_driver.configure(&config);
    } else if (setup->configure != NULL) {
        return "its limits and queue families cannot be chosen";
    }

    instance_create(fixture, platform);
    physical_device_choose(fixture);
    const char *missing = features_missing(fixture);
    if (missing == NULL) {
        fixture->device = fixture_create_device(fixture);
        vkuInitDeviceDispatchTable(fixture->device, &fixture->vk,
                                   fixture->instance.get_device_proc_addr);
    } else {
        fixture_close(fixture);
    }
    return missing;
}

void fixture_open_by_environment(struct fixture *fixture, uint32_t enable)
{
    static struct platform platform = {.name = "environment", .is_named = true};
    const struct setup setup = {.by_environment = true, .enable = enable};
    const char *missing = platform_open_loader(&platform);
    if (missing == NULL)
        missing = fixture_open(fixture, &platform, &setup);
    if (missing != NULL) {
        fprintf(stderr, "%s\n", missing);
        exit(3);
    }
}

void fixture_close(struct fixture *fixture)
{
    if (fixture->instance.instance == VK_NULL_HANDLE)
        return;
    if (fixture->device != VK_NULL_HANDLE)
        fixture->vk.DestroyDevice(fixture->device, NULL);
    instance_fixture_close(&fixture->instance);
    fixture->device = VK_NULL_HANDLE;
    fixture->instance.instance = VK_NULL_HANDLE;
}
