/* SPDX-License-Identifier: Apache-2.0 */
/* Making instances and devices. */
#include "tests/player/scene/fixture.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/fixture/device_wish.h"
#include "tests/fixture/make.h"
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

/* ---- extensions and features ---- */

enum { WORD_SIZE = 128 };

/* Takes a word from a text, which may be NULL. Returns the rest; NULL: there is no word. */
static const char *take_word(const char *text, char word[WORD_SIZE])
{
    if (text != NULL)
        text += strspn(text, " ");
    if (text == NULL || *text == '\0')
        return NULL;
    const size_t length = strcspn(text, " ");
    snprintf(word, WORD_SIZE, "%.*s", (int)length, text);
    return text + length;
}

bool setup_has(const struct setup *setup, const char *word)
{
    char found[WORD_SIZE];
    const char *const texts[] = {setup->with, setup->needs};
    for (size_t i = 0; i < ARRAY_COUNT(texts); i++)
        for (const char *rest = texts[i]; (rest = take_word(rest, found)) != NULL;)
            if (strcmp(found, word) == 0)
                return true;
    return false;
}

static const char *const extensions_of_1_1[] = {
    VK_KHR_BUFFER_DEVICE_ADDRESS_EXTENSION_NAME, VK_EXT_DESCRIPTOR_INDEXING_EXTENSION_NAME,
    VK_KHR_CREATE_RENDERPASS_2_EXTENSION_NAME,   VK_KHR_DEPTH_STENCIL_RESOLVE_EXTENSION_NAME,
    VK_KHR_DYNAMIC_RENDERING_EXTENSION_NAME,     VK_KHR_SPIRV_1_4_EXTENSION_NAME,
    VK_KHR_SHADER_FLOAT_CONTROLS_EXTENSION_NAME,
};

#define ADDRESS_COMMANDS VK_KHR_DEVICE_ADDRESS_COMMANDS_EXTENSION_NAME
#define ADDRESS_COMMANDS_FEATURE                                                                   \
    "VkPhysicalDeviceDeviceAddressCommandsFeaturesKHR.deviceAddressCommands"

/* What extensions depend on, and backend cpu does without. */
static bool is_needed(const struct fixture *fixture, const char *extension)
{
    return !fixture->instance.platform->is_cpu ||
           (strcmp(extension, VK_KHR_RAY_TRACING_PIPELINE_EXTENSION_NAME) != 0 &&
            strcmp(extension, ADDRESS_COMMANDS) != 0);
}

static void add_extensions(struct device_wish *wish, const struct fixture *fixture,
                           const char *words)
{
    char word[WORD_SIZE];
    while ((words = take_word(words, word)) != NULL)
        if (strncmp(word, "VK_", 3) == 0 && is_needed(fixture, word))
            device_wish_add(wish, word);
}

static void list_extensions(struct device_wish *wish, const struct fixture *fixture)
{
    const struct setup *setup = &fixture->setup;
    device_wish_begin(wish);
    if (setup->route == ROUTE_EXT) {
        device_wish_add(wish, VK_EXT_BUFFER_DEVICE_ADDRESS_EXTENSION_NAME);
        device_wish_add(wish, VK_KHR_BUFFER_DEVICE_ADDRESS_EXTENSION_NAME);
    }
    for (size_t i = 0; setup->route == ROUTE_KHR && i < ARRAY_COUNT(extensions_of_1_1); i++)
        device_wish_add(wish, extensions_of_1_1[i]);
    add_extensions(wish, fixture, setup->with);
    add_extensions(wish, fixture, setup->needs);
}

/* Features of every world, by the routes. */
#define BY_KHR (1 << ROUTE_KHR)
#define BY_EXT (1 << ROUTE_EXT)
#define BY_CORE (1 << ROUTE_CHAIN | 1 << ROUTE_FEATURES2)
static const struct {
    uint32_t routes;
    const char *feature;
} core_features[] = {
    {BY_KHR, "VkPhysicalDeviceBufferDeviceAddressFeatures.bufferDeviceAddress"},
    {BY_KHR, "VkPhysicalDeviceDynamicRenderingFeatures.dynamicRendering"},
    {BY_EXT, "VkPhysicalDeviceBufferDeviceAddressFeaturesEXT.bufferDeviceAddress"},
    {BY_CORE, "VkPhysicalDeviceVulkan12Features.bufferDeviceAddress"},
    {BY_CORE, "VkPhysicalDeviceVulkan12Features.timelineSemaphore"},
    {BY_CORE, "VkPhysicalDeviceVulkan12Features.hostQueryReset"},
    {BY_EXT | BY_CORE, "VkPhysicalDeviceVulkan13Features.dynamicRendering"},
    {BY_EXT | BY_CORE, "VkPhysicalDeviceVulkan13Features.synchronization2"},
};

/* Off unless a setup turns them on. */
static const char *const features_left_off[] = {"accelerationStructureCaptureReplay",
                                                "micromapCaptureReplay", "robustBufferAccess2"};

static void set_features(struct device_wish *wish, const char *words)
{
    char word[WORD_SIZE];
    while ((words = take_word(words, word)) != NULL)
        if (word[0] == '+' || word[0] == '-')
            assert_true(device_wish_set(wish, word + 1, word[0] == '+'));
}

/* What the device of the fixture is created with. */
static void make_wish(struct device_wish *wish, const struct fixture *fixture)
{
    const struct setup *setup = &fixture->setup;
    list_extensions(wish, fixture);
    fixture->instance.vk.GetPhysicalDeviceFeatures2(fixture->instance.physical, &wish->features);
    wish->features.features = (VkPhysicalDeviceFeatures){0};
    for (size_t i = 0; i < ARRAY_COUNT(core_features); i++)
        if (core_features[i].routes & 1u << setup->route)
            device_wish_set(wish, core_features[i].feature, VK_TRUE);
    for (size_t i = 0; i < ARRAY_COUNT(features_left_off); i++)
        device_wish_set(wish, features_left_off[i], VK_FALSE);
    if (setup_has(setup, ADDRESS_COMMANDS) && fixture->instance.platform->is_cpu)
        device_wish_set(wish, ADDRESS_COMMANDS_FEATURE, VK_TRUE); /* without the extension */
    set_features(wish, setup->needs);
    set_features(wish, setup->with);
}

/* Returns a feature of the words that the driver lacks, or NULL. */
static const char *missing_feature(const struct fixture *fixture, const char *words)
{
    static char word[WORD_SIZE];
    while ((words = take_word(words, word)) != NULL) {
        struct device_wish offered;
        list_extensions(&offered, fixture);
        if (word[0] != '+')
            continue;
        device_wish_set(&offered, word + 1, VK_FALSE);
        fixture->instance.vk.GetPhysicalDeviceFeatures2(fixture->instance.physical,
                                                        &offered.features);
        if (!device_wish_has(&offered, word + 1))
            return word + 1;
    }
    return NULL;
}

/* Returns what of the setup the physical device lacks, or NULL. */
static const char *missing(const struct fixture *fixture)
{
    const struct setup *setup = &fixture->setup;
    struct device_wish wanted;
    static char name[VK_MAX_EXTENSION_NAME_SIZE];
    uint32_t count = 0;
    fixture->instance.vk.EnumeratePhysicalDevices(fixture->instance.instance, &count, NULL);
    if (setup_has(setup, "group") && count < 2)
        return "no group of two physical devices";
    list_extensions(&wanted, fixture);
    for (uint32_t i = 0; i < wanted.extension_count; i++)
        if (instance_fixture_count_extension(&fixture->instance, wanted.extensions[i]) == 0)
            return memcpy(name, wanted.names[i], sizeof(name));
    const char *feature = missing_feature(fixture, setup->with);
    return feature != NULL ? feature : missing_feature(fixture, setup->needs);
}

/* Configures the null driver so that it offers the setup. */
static void configure(struct null_driver_config *config, const struct setup *setup)
{
    if (setup_has(setup, FUTURE_EXTENSION))
        config->extra_extensions[config->extra_extension_count++] = FUTURE_EXTENSION;
    if (setup->api_version > config->api_version)
        config->api_version = setup->api_version;
}

/* ---- the device ---- */

VkDevice fixture_create_device(struct fixture *fixture)
{
    const float priority = 1.0f;
    VkDeviceQueueCreateInfo queues[FIXTURE_QUEUE_FAMILIES];
    for (uint32_t i = 0; i < fixture->family_count; i++) {
        const bool is_protected = setup_has(&fixture->setup, PROTECTED_FEATURE) &&
                                  (fixture->families[i].queueFlags & VK_QUEUE_PROTECTED_BIT) != 0;
        queues[i] = MAKE(VkDeviceQueueCreateInfo,
                         .flags = is_protected ? VK_DEVICE_QUEUE_CREATE_PROTECTED_BIT : 0,
                         .queueFamilyIndex = i, .queueCount = 1, .pQueuePriorities = &priority);
    }
    const bool has_queues = !setup_has(&fixture->setup, "queueless");
    const bool is_chained = fixture->setup.route == ROUTE_FEATURES2;
    struct device_wish wish;
    make_wish(&wish, fixture);
    STRUCT(
        VkDeviceCreateInfo, create_info, .pNext = is_chained ? &wish.features : wish.features.pNext,
        .pEnabledFeatures = is_chained ? NULL : &wish.features.features,
        .enabledExtensionCount = wish.extension_count, .ppEnabledExtensionNames = wish.extensions,
        .queueCreateInfoCount = has_queues ? fixture->family_count : 0,
        .pQueueCreateInfos = queues);

    STRUCT(VkDeviceGroupDeviceCreateInfo, group_info);
    VkPhysicalDevice devices[NULL_DRIVER_PHYSICAL_DEVICES];
    if (setup_has(&fixture->setup, "group")) {
        group_info.physicalDeviceCount = NULL_DRIVER_PHYSICAL_DEVICES;
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
        configure(&config, setup);
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
    const char *what = missing(fixture);
    if (what == NULL) {
        fixture->device = fixture_create_device(fixture);
        vkuInitDeviceDispatchTable(fixture->device, &fixture->vk,
                                   fixture->instance.get_device_proc_addr);
    } else {
        fixture_close(fixture);
    }
    return what;
}

void fixture_open_by_environment(struct fixture *fixture, const char *with)
{
    static struct platform platform = {.name = "environment", .is_named = true};
    const struct setup setup = {.by_environment = true, .with = with};
    const char *what = platform_open_loader(&platform);
    if (what == NULL)
        what = fixture_open(fixture, &platform, &setup);
    if (what != NULL) {
        fprintf(stderr, "%s\n", what);
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
