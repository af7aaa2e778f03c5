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

static void instance_create(struct fixture *fixture)
{
    /* Findings repeat from case to case of the same instance: none may be held back. */
    static const uint32_t no_limit = 0;
    static const VkBool32 off = VK_FALSE; /* the cases are about one call each, without barriers */
    const VkLayerSettingEXT settings[] = {
        {LAYER_NAME, "duplicate_message_limit", VK_LAYER_SETTING_TYPE_UINT32_EXT, 1, &no_limit},
        {LAYER_NAME, "message_id_filter", VK_LAYER_SETTING_TYPE_STRING_EXT,
         fixture->setup.muted != NULL ? 1 : 0, &fixture->setup.muted},
        {LAYER_NAME, "hazards", VK_LAYER_SETTING_TYPE_BOOL32_EXT,
         fixture->setup.by_environment ? 0 : 1, &off},
        {LAYER_NAME, "level", VK_LAYER_SETTING_TYPE_STRING_EXT, 1, &fixture->setup.level},
    };
    const STRUCT(VkLayerSettingsCreateInfoEXT, layer_settings,
                 .settingCount = fixture->setup.level != NULL ? 4 : 3, .pSettings = settings);
    VkDebugUtilsMessengerCreateInfoEXT messenger = messages_messenger(&fixture->messages);
    messenger.pNext = &layer_settings;
    const STRUCT(VkApplicationInfo, application, .apiVersion = setup_api_version(&fixture->setup));
    const char *layer = LAYER_NAME, *extension = VK_EXT_DEBUG_UTILS_EXTENSION_NAME;
    const STRUCT(
        VkInstanceCreateInfo, create_info, .pNext = &messenger, .pApplicationInfo = &application,
        .enabledLayerCount = fixture->setup.by_environment ? 0 : 1, .ppEnabledLayerNames = &layer,
        .enabledExtensionCount = 1, .ppEnabledExtensionNames = &extension);
    const PFN_vkGetInstanceProcAddr proc_addr = fixture->platform->get_instance_proc_addr;
    const PFN_vkCreateInstance create = (PFN_vkCreateInstance)proc_addr(NULL, "vkCreateInstance");
    GET(create(&create_info, NULL, &fixture->instance));
    vkuInitInstanceDispatchTable(fixture->instance, &fixture->vki, proc_addr);
    fixture->create_device = (PFN_vkCreateDevice)proc_addr(fixture->instance, "vkCreateDevice");
    fixture->get_device_proc_addr =
        (PFN_vkGetDeviceProcAddr)proc_addr(fixture->instance, "vkGetDeviceProcAddr");

    messenger.pNext = NULL;
    GET(fixture->vki.CreateDebugUtilsMessengerEXT(fixture->instance, &messenger, NULL,
                                                  &fixture->messenger));
}

/* ---- the physical device ---- */

/* Which driver it is that the environment names, once. */
static void report_device(const struct fixture *fixture)
{
    static bool told;
    STRUCT(VkPhysicalDeviceDriverProperties, driver);
    STRUCT(VkPhysicalDeviceProperties2, properties, .pNext = &driver);

    if (told || !fixture->platform->is_named)
        return;
    told = true;
    fixture->vki.GetPhysicalDeviceProperties2(fixture->physical_device, &properties);
    printf("[  DEVICE  ] %s, %s %s\n", properties.properties.deviceName, driver.driverName,
           driver.driverInfo);
}

static void physical_device_choose(struct fixture *fixture)
{
    uint32_t count = 1;
    const VkResult result =
        fixture->vki.EnumeratePhysicalDevices(fixture->instance, &count, &fixture->physical_device);
    if (count == 0 || (result != VK_SUCCESS && result != VK_INCOMPLETE)) {
        fprintf(stderr, "%s offers no physical device\n", fixture->platform->name);
        exit(1);
    }

    fixture->limits = MAKE(VkPhysicalDeviceAccelerationStructurePropertiesKHR);
    STRUCT(VkPhysicalDeviceProperties2, properties, .pNext = &fixture->limits);
    fixture->vki.GetPhysicalDeviceProperties2(fixture->physical_device, &properties);
    fixture->vki.GetPhysicalDeviceMemoryProperties(fixture->physical_device, &fixture->memory);
    fixture->family_count = FIXTURE_QUEUE_FAMILIES;
    fixture->vki.GetPhysicalDeviceQueueFamilyProperties(fixture->physical_device,
                                                        &fixture->family_count, fixture->families);

    STRUCT(VkPhysicalDeviceAccelerationStructureFeaturesKHR, offered);
    STRUCT(VkPhysicalDeviceFeatures2, features, .pNext = &offered);
    fixture->vki.GetPhysicalDeviceFeatures2(fixture->physical_device, &features);
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
    STRUCT(VkDeviceCreateInfo, create_info,
           .queueCreateInfoCount = has_queues ? fixture->family_count : 0,
           .pQueueCreateInfos = queues);
    struct features features;
    features_fill(&features, fixture, &create_info);

    STRUCT(VkDeviceGroupDeviceCreateInfo, group_info);
    VkPhysicalDevice devices[NULL_DRIVER_MAX_PHYSICAL_DEVICES];
    if ((fixture->setup.enable & ENABLE_GROUP) != 0) {
        group_info.physicalDeviceCount = NULL_DRIVER_MAX_PHYSICAL_DEVICES;
        fixture->vki.EnumeratePhysicalDevices(fixture->instance, &group_info.physicalDeviceCount,
                                              devices);
        group_info.pPhysicalDevices = devices;
        group_info.pNext = create_info.pNext;
        create_info.pNext = &group_info;
    }
    VkDevice device;
    GET(fixture->create_device(fixture->physical_device, &create_info, NULL, &device));
    return device;
}

const char *fixture_open(struct fixture *fixture, const struct platform *platform,
                         const struct setup *setup)
{
    fixture->platform = platform;
    fixture->setup = *setup;
    fixture->messages.answer = VK_FALSE;
    messages_clear(&fixture->messages);
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

    instance_create(fixture);
    physical_device_choose(fixture);
    const char *missing = features_missing(fixture);
    if (missing == NULL) {
        fixture->device = fixture_create_device(fixture);
        vkuInitDeviceDispatchTable(fixture->device, &fixture->vk, fixture->get_device_proc_addr);
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
    if (fixture->instance == VK_NULL_HANDLE)
        return;
    if (fixture->device != VK_NULL_HANDLE)
        fixture->vk.DestroyDevice(fixture->device, NULL);
    fixture->vki.DestroyDebugUtilsMessengerEXT(fixture->instance, fixture->messenger, NULL);
    fixture->vki.DestroyInstance(fixture->instance, NULL);
    fixture->device = VK_NULL_HANDLE;
    fixture->instance = VK_NULL_HANDLE;
}
