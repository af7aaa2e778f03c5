/* SPDX-License-Identifier: Apache-2.0 */
/* Making instances and devices. */
#include "world.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "device_features.h"
#include "vuid-tables/registry.h"

void expect_success(VkResult result, const char *what)
{
    if (result != VK_SUCCESS) {
        fprintf(stderr, "%s failed: VkResult %d\n", what, result);
        exit(1);
    }
}

/* ---- the instance ---- */

static uint32_t setup_api_version(const struct setup *setup)
{
    if (setup->api_version != 0)
        return setup->api_version;
    return setup->route == ROUTE_KHR ? VK_API_VERSION_1_1 : VK_API_VERSION_1_3;
}

static void instance_create(struct world *world)
{
    /* Findings repeat from case to case of the same instance: none may be held back. */
    static const uint32_t no_limit = 0;
    const VkLayerSettingEXT settings[] = {
        {LAYER_NAME, "duplicate_message_limit", VK_LAYER_SETTING_TYPE_UINT32_EXT, 1, &no_limit},
        {LAYER_NAME, "message_id_filter", VK_LAYER_SETTING_TYPE_STRING_EXT,
         world->setup.muted != NULL ? 1 : 0, &world->setup.muted},
        {LAYER_NAME, "level", VK_LAYER_SETTING_TYPE_STRING_EXT, 1, &world->setup.level},
    };
    const VkLayerSettingsCreateInfoEXT layer_settings = {
        .sType = VK_STRUCTURE_TYPE_LAYER_SETTINGS_CREATE_INFO_EXT,
        .settingCount = world->setup.level != NULL ? 3 : 2,
        .pSettings = settings,
    };
    VkDebugUtilsMessengerCreateInfoEXT messenger = messages_messenger(&world->messages);
    messenger.pNext = &layer_settings;
    const VkApplicationInfo application = {
        .sType = VK_STRUCTURE_TYPE_APPLICATION_INFO,
        .apiVersion = setup_api_version(&world->setup),
    };
    const char *layer = LAYER_NAME, *extension = VK_EXT_DEBUG_UTILS_EXTENSION_NAME;
    const VkInstanceCreateInfo create_info = {
        .sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO,
        .pNext = &messenger,
        .pApplicationInfo = &application,
        .enabledLayerCount = world->setup.by_environment ? 0 : 1,
        .ppEnabledLayerNames = &layer,
        .enabledExtensionCount = 1,
        .ppEnabledExtensionNames = &extension,
    };
    const PFN_vkGetInstanceProcAddr proc_addr = world->platform->get_instance_proc_addr;
    const PFN_vkCreateInstance create = (PFN_vkCreateInstance)proc_addr(NULL, "vkCreateInstance");
    expect_success(create(&create_info, NULL, &world->instance), "vkCreateInstance");
    vkuInitInstanceDispatchTable(world->instance, &world->vki, proc_addr);
    world->create_device = (PFN_vkCreateDevice)proc_addr(world->instance, "vkCreateDevice");
    world->get_device_proc_addr =
        (PFN_vkGetDeviceProcAddr)proc_addr(world->instance, "vkGetDeviceProcAddr");

    messenger.pNext = NULL;
    expect_success(world->vki.CreateDebugUtilsMessengerEXT(world->instance, &messenger, NULL,
                                                           &world->messenger),
                   "vkCreateDebugUtilsMessengerEXT");
}

/* ---- the physical device ---- */

/* Which driver it is that the environment names, once. */
static void tell_device(const struct world *world)
{
    static bool told;
    VkPhysicalDeviceDriverProperties driver = {
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DRIVER_PROPERTIES};
    VkPhysicalDeviceProperties2 properties = {
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2, .pNext = &driver};

    if (told || !world->platform->is_named)
        return;
    told = true;
    world->vki.GetPhysicalDeviceProperties2(world->physical_device, &properties);
    printf("[  DEVICE  ] %s, %s %s\n", properties.properties.deviceName, driver.driverName,
           driver.driverInfo);
}

static void physical_device_choose(struct world *world)
{
    uint32_t count = 1;
    const VkResult result =
        world->vki.EnumeratePhysicalDevices(world->instance, &count, &world->physical_device);
    if (count == 0 || (result != VK_SUCCESS && result != VK_INCOMPLETE)) {
        fprintf(stderr, "%s offers no physical device\n", world->platform->name);
        exit(1);
    }

    world->limits = (VkPhysicalDeviceAccelerationStructurePropertiesKHR){
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_ACCELERATION_STRUCTURE_PROPERTIES_KHR};
    VkPhysicalDeviceProperties2 properties = {
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2, .pNext = &world->limits};
    world->vki.GetPhysicalDeviceProperties2(world->physical_device, &properties);
    world->vki.GetPhysicalDeviceMemoryProperties(world->physical_device, &world->memory);
    world->family_count = WORLD_QUEUE_FAMILIES;
    world->vki.GetPhysicalDeviceQueueFamilyProperties(world->physical_device, &world->family_count,
                                                      world->families);

    VkPhysicalDeviceAccelerationStructureFeaturesKHR offered = {
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_ACCELERATION_STRUCTURE_FEATURES_KHR};
    VkPhysicalDeviceFeatures2 features = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2,
                                          .pNext = &offered};
    world->vki.GetPhysicalDeviceFeatures2(world->physical_device, &features);
    world->has_indirect = offered.accelerationStructureIndirectBuild;
    world->has_host = offered.accelerationStructureHostCommands;
    tell_device(world);
}

uint32_t world_find_family(const struct world *world, VkQueueFlags with, VkQueueFlags without)
{
    for (uint32_t i = 0; i < world->family_count; i++) {
        const VkQueueFlags flags = world->families[i].queueFlags;
        if ((flags & with) == with && (flags & without) == 0)
            return i;
    }
    return UINT32_MAX;
}

/* ---- the device ---- */

VkDevice world_create_device(struct world *world)
{
    const float priority = 1.0f;
    VkDeviceQueueCreateInfo queues[WORLD_QUEUE_FAMILIES];
    for (uint32_t i = 0; i < world->family_count; i++) {
        const bool is_protected = (world->setup.enable & ENABLE_PROTECTED) != 0 &&
                                  (world->families[i].queueFlags & VK_QUEUE_PROTECTED_BIT) != 0;
        queues[i] = (VkDeviceQueueCreateInfo){
            .sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO,
            .flags = is_protected ? VK_DEVICE_QUEUE_CREATE_PROTECTED_BIT : 0,
            .queueFamilyIndex = i,
            .queueCount = 1,
            .pQueuePriorities = &priority,
        };
    }
    VkDeviceCreateInfo create_info = {
        .sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO,
        .queueCreateInfoCount = world->family_count,
        .pQueueCreateInfos = queues,
    };
    struct features features;
    features_fill(&features, world, &create_info);

    VkDeviceGroupDeviceCreateInfo group_info = {
        .sType = VK_STRUCTURE_TYPE_DEVICE_GROUP_DEVICE_CREATE_INFO};
    VkPhysicalDevice devices[NULL_DRIVER_MAX_PHYSICAL_DEVICES];
    if ((world->setup.enable & ENABLE_GROUP) != 0) {
        group_info.physicalDeviceCount = NULL_DRIVER_MAX_PHYSICAL_DEVICES;
        world->vki.EnumeratePhysicalDevices(world->instance, &group_info.physicalDeviceCount,
                                            devices);
        group_info.pPhysicalDevices = devices;
        group_info.pNext = create_info.pNext;
        create_info.pNext = &group_info;
    }
    VkDevice device;
    expect_success(world->create_device(world->physical_device, &create_info, NULL, &device),
                   "vkCreateDevice");
    return device;
}

const char *world_open(struct world *world, const struct platform *platform,
                       const struct setup *setup)
{
    world->platform = platform;
    world->setup = *setup;
    world->messages.answer = VK_FALSE;
    messages_clear(&world->messages);
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

    instance_create(world);
    physical_device_choose(world);
    const char *missing = features_missing(world);
    if (missing == NULL) {
        world->device = world_create_device(world);
        vkuInitDeviceDispatchTable(world->device, &world->vk, world->get_device_proc_addr);
    } else {
        world_close(world);
    }
    return missing;
}

void world_close(struct world *world)
{
    if (world->instance == VK_NULL_HANDLE)
        return;
    if (world->device != VK_NULL_HANDLE)
        world->vk.DestroyDevice(world->device, NULL);
    world->vki.DestroyDebugUtilsMessengerEXT(world->instance, world->messenger, NULL);
    world->vki.DestroyInstance(world->instance, NULL);
    world->device = VK_NULL_HANDLE;
    world->instance = VK_NULL_HANDLE;
}
