/* SPDX-License-Identifier: Apache-2.0 */
/* Opening an instance and a device with or without the layer. */
#include "side.h"

#include <glob.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/tools/fail.h"

static const char *const extensions[] = {VK_KHR_ACCELERATION_STRUCTURE_EXTENSION_NAME,
                                         VK_KHR_DEFERRED_HOST_OPERATIONS_EXTENSION_NAME};
enum { EXTENSION_COUNT = sizeof(extensions) / sizeof(extensions[0]), MOST_DEVICES = 16 };

/* ---- the loader's environment */

static void select_lavapipe(void)
{
    glob_t found = {0};
    if (glob("/usr/share/vulkan/icd.d/lvp_icd*.json", 0, NULL, &found) != 0)
        tool_fail("lavapipe is not installed: run scripts/setup, or ask for --driver null");
    setenv("VK_DRIVER_FILES", found.gl_pathv[0], 1);
    globfree(&found);
}

void layers_select_all(const char *folder)
{
    char path[4096];
    snprintf(path, sizeof(path), "%s%s%s", BENCH_LAYER_FOLDER, folder ? ":" : "",
             folder ? folder : "");
    unsetenv("VK_LAYER_PATH");
    setenv("VK_ADD_LAYER_PATH", path, 1);
}

bool layer_find(const char *name, VkLayerProperties *found)
{
    PFN_vkEnumerateInstanceLayerProperties enumerate =
        (PFN_vkEnumerateInstanceLayerProperties)vkGetInstanceProcAddr(
            VK_NULL_HANDLE, "vkEnumerateInstanceLayerProperties");
    uint32_t count = 0;
    tool_check(enumerate(&count, NULL), "vkEnumerateInstanceLayerProperties");
    VkLayerProperties *layers = tool_alloc(count, sizeof(*layers));
    tool_check(enumerate(&count, layers), "vkEnumerateInstanceLayerProperties");
    bool is_found = false;
    for (uint32_t i = 0; i < count && !is_found; i++) {
        is_found = strcmp(layers[i].layerName, name) == 0;
        *found = layers[i];
    }
    free(layers);
    return is_found;
}

void driver_select(const char *name)
{
    if (strcmp(name, "lavapipe") == 0)
        select_lavapipe();
    else
        setenv("VK_DRIVER_FILES", BENCH_NULL_DRIVER_MANIFEST, 1);
    if (!getenv("VK_ADD_LAYER_PATH"))
        setenv("VK_LAYER_PATH", BENCH_LAYER_FOLDER, 0);
    setenv("VK_LOADER_LAYERS_DISABLE", "~implicit~", 1);
    unsetenv("VK_INSTANCE_LAYERS");
    unsetenv("VK_LOADER_LAYERS_ENABLE");
}

/* ---- the instance */

static VKAPI_ATTR VkBool32 VKAPI_CALL count_finding(
    VkDebugUtilsMessageSeverityFlagBitsEXT severity, VkDebugUtilsMessageTypeFlagsEXT types,
    const VkDebugUtilsMessengerCallbackDataEXT *data, void *user)
{
    (void)severity;
    (void)types;
    struct side_findings *findings = user;
    if (findings->is_open && ++findings->count == 1)
        fprintf(stderr, "%s\n", data->pMessage);
    return VK_FALSE;
}

static void open_instance(struct side *side, const char *layer, const char *level)
{
    const VkLayerSettingEXT setting = {BENCH_LAYER, "level", VK_LAYER_SETTING_TYPE_STRING_EXT, 1,
                                       &level};
    const VkLayerSettingsCreateInfoEXT settings =
        MAKE(VkLayerSettingsCreateInfoEXT, .settingCount = 1, .pSettings = &setting);
    VkDebugUtilsMessengerCreateInfoEXT messenger =
        MAKE(VkDebugUtilsMessengerCreateInfoEXT, .pNext = layer && level ? &settings : NULL,
             .messageSeverity = VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT |
                                VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT,
             .messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT,
             .pfnUserCallback = count_finding, .pUserData = side->findings);
    const VkApplicationInfo application = MAKE(
        VkApplicationInfo, .pApplicationName = "record_bench", .apiVersion = VK_API_VERSION_1_2);
    const char *const debug_utils = VK_EXT_DEBUG_UTILS_EXTENSION_NAME;
    const VkInstanceCreateInfo create_info =
        MAKE(VkInstanceCreateInfo, .pNext = &messenger, .pApplicationInfo = &application,
             .enabledLayerCount = layer ? 1 : 0, .ppEnabledLayerNames = &layer,
             .enabledExtensionCount = 1, .ppEnabledExtensionNames = &debug_utils);
    PFN_vkCreateInstance create =
        (PFN_vkCreateInstance)vkGetInstanceProcAddr(VK_NULL_HANDLE, "vkCreateInstance");
    VkResult result = create(&create_info, NULL, &side->instance);
    if (result == VK_ERROR_LAYER_NOT_PRESENT)
        tool_fail("the loader finds no layer %s", layer);
    if (result == VK_ERROR_INCOMPATIBLE_DRIVER)
        tool_fail("the loader cannot use the driver %s", getenv("VK_DRIVER_FILES"));
    tool_check(result, "vkCreateInstance");
    vkuInitInstanceDispatchTable(side->instance, &side->instance_calls, vkGetInstanceProcAddr);

    messenger.pNext = NULL;
    TOOL_CALL(side->instance_calls, CreateDebugUtilsMessengerEXT, side->instance, &messenger, NULL,
              &side->messenger);
}

/* ---- the physical device */

static bool has_extensions(const struct side *side, VkPhysicalDevice physical)
{
    uint32_t count = 0, found = 0;
    TOOL_CALL(side->instance_calls, EnumerateDeviceExtensionProperties, physical, NULL, &count,
              NULL);
    VkExtensionProperties *offered = tool_alloc(count, sizeof(*offered));
    TOOL_CALL(side->instance_calls, EnumerateDeviceExtensionProperties, physical, NULL, &count,
              offered);
    for (int wanted = 0; wanted < EXTENSION_COUNT; wanted++) {
        for (uint32_t i = 0; i < count; i++)
            found += strcmp(offered[i].extensionName, extensions[wanted]) == 0;
    }
    free(offered);
    return found == EXTENSION_COUNT;
}

static void choose_device(struct side *side)
{
    VkPhysicalDevice devices[MOST_DEVICES];
    uint32_t count = MOST_DEVICES;
    VkResult result =
        side->instance_calls.EnumeratePhysicalDevices(side->instance, &count, devices);
    if (result != VK_INCOMPLETE)
        tool_check(result, "vkEnumeratePhysicalDevices");
    for (uint32_t i = 0; i < count && !side->physical; i++) {
        if (has_extensions(side, devices[i]))
            side->physical = devices[i];
    }
    if (!side->physical)
        tool_fail("the driver %s has no device with acceleration structures",
                  getenv("VK_DRIVER_FILES"));
}

/* The figures mean nothing where a layer isn't on its side, or is on another. */
static void require_layer(const struct side *side, const char *layer)
{
    uint32_t count = 0;
    bool found = false, wanted = side->layer && strcmp(side->layer, layer) == 0;
    TOOL_CALL(side->instance_calls, EnumerateDeviceLayerProperties, side->physical, &count, NULL);
    VkLayerProperties *enabled = tool_alloc(count, sizeof(*enabled));
    TOOL_CALL(side->instance_calls, EnumerateDeviceLayerProperties, side->physical, &count,
              enabled);
    for (uint32_t i = 0; i < count; i++)
        found = found || strcmp(enabled[i].layerName, layer) == 0;
    free(enabled);
    if (found != wanted)
        tool_fail("%s is %s", layer, wanted ? "not enabled" : "enabled on a side without it");
}

static uint32_t find_compute_family(const struct side *side)
{
    uint32_t count = 0, family = 0;
    side->instance_calls.GetPhysicalDeviceQueueFamilyProperties(side->physical, &count, NULL);
    VkQueueFamilyProperties *families = tool_alloc(count, sizeof(*families));
    side->instance_calls.GetPhysicalDeviceQueueFamilyProperties(side->physical, &count, families);
    while (family < count && !(families[family].queueFlags & VK_QUEUE_COMPUTE_BIT))
        family++;
    free(families);
    if (family == count)
        tool_fail("the device has no queue that computes");
    return family;
}

/* ---- the device */

static void open_device(struct side *side)
{
    const VkPhysicalDeviceAccelerationStructureFeaturesKHR structures =
        MAKE(VkPhysicalDeviceAccelerationStructureFeaturesKHR, .accelerationStructure = VK_TRUE);
    const VkPhysicalDeviceVulkan12Features core =
        MAKE(VkPhysicalDeviceVulkan12Features, .pNext = (void *)&structures,
             .bufferDeviceAddress = VK_TRUE);
    const float priority = 1.0f;
    const VkDeviceCreateInfo create_info = MAKE(
        VkDeviceCreateInfo, .pNext = &core, .queueCreateInfoCount = 1,
        .pQueueCreateInfos = &MAKE(VkDeviceQueueCreateInfo, .queueFamilyIndex = side->queue_family,
                                   .queueCount = 1, .pQueuePriorities = &priority),
        .enabledExtensionCount = EXTENSION_COUNT, .ppEnabledExtensionNames = extensions);
    PFN_vkCreateDevice create =
        (PFN_vkCreateDevice)vkGetInstanceProcAddr(side->instance, "vkCreateDevice");
    tool_check(create(side->physical, &create_info, NULL, &side->device), "vkCreateDevice");
    vkuInitDeviceDispatchTable(
        side->device, &side->calls,
        (PFN_vkGetDeviceProcAddr)vkGetInstanceProcAddr(side->instance, "vkGetDeviceProcAddr"));
}

void side_open(struct side *side, const char *layer, const char *level)
{
    *side = (struct side){.layer = layer, .findings = tool_alloc(1, sizeof(*side->findings))};
    open_instance(side, layer, level);
    choose_device(side);
    require_layer(side, BENCH_LAYER);
    require_layer(side, BENCH_PEER);
    side->queue_family = find_compute_family(side);
    side->limits.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_ACCELERATION_STRUCTURE_PROPERTIES_KHR;
    side->instance_calls.GetPhysicalDeviceProperties2(
        side->physical, &MAKE(VkPhysicalDeviceProperties2, .pNext = &side->limits));
    open_device(side);
    side->findings->is_open = true; /* the tables ask for what there is not, and layers say so */
}

void side_close(struct side *side)
{
    side->calls.DestroyDevice(side->device, NULL);
    side->instance_calls.DestroyDebugUtilsMessengerEXT(side->instance, side->messenger, NULL);
    side->instance_calls.DestroyInstance(side->instance, NULL);
    const bool are_expected = side->layer && side->findings->are_expected;
    if (are_expected && !side->findings->count)
        tool_fail("%s reports no finding: the recorded builds should have some", side->layer);
    if (!are_expected && side->findings->count)
        tool_fail("%s reports %u findings: the recorded builds should have none", side->layer,
                  side->findings->count);
    free(side->findings);
}
