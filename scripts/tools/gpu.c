/* SPDX-License-Identifier: Apache-2.0 */
/* Opens the loader, an instance with a messenger, and a device; says in one line why it can't. */
#include <dlfcn.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "scripts/tools/gpu.h"

static const char *const gpu_extensions[] = {
    VK_KHR_ACCELERATION_STRUCTURE_EXTENSION_NAME, VK_KHR_DEFERRED_HOST_OPERATIONS_EXTENSION_NAME,
    VK_KHR_RAY_QUERY_EXTENSION_NAME, /* the last: not always wanted */
};

static uint32_t gpu_extension_count(const struct gpu *gpu)
{
    return sizeof(gpu_extensions) / sizeof(*gpu_extensions) - !gpu->wants_queries;
}

/* ---- instance */

static void gpu_open_instance(struct gpu *gpu, const char *layer,
                              VkDebugUtilsMessengerCreateInfoEXT messenger)
{
    gpu->library = dlopen("libvulkan.so.1", RTLD_NOW | RTLD_LOCAL);
    if (!gpu->library)
        tool_fail("no Vulkan loader: %s", dlerror());
    PFN_vkGetInstanceProcAddr get =
        (PFN_vkGetInstanceProcAddr)dlsym(gpu->library, "vkGetInstanceProcAddr");
    if (!get)
        tool_fail("no Vulkan loader: libvulkan.so.1 has no vkGetInstanceProcAddr");
    PFN_vkCreateInstance create = (PFN_vkCreateInstance)get(VK_NULL_HANDLE, "vkCreateInstance");
    if (!create)
        tool_fail("no Vulkan loader: libvulkan.so.1 has no vkCreateInstance");

    static const char *const extensions[] = {VK_EXT_DEBUG_UTILS_EXTENSION_NAME};
    VkResult result =
        create(&MAKE(VkInstanceCreateInfo, .pNext = &messenger,
                     .pApplicationInfo = &MAKE(VkApplicationInfo, .apiVersion = VK_API_VERSION_1_2),
                     .enabledLayerCount = layer ? 1 : 0, .ppEnabledLayerNames = &layer,
                     .enabledExtensionCount = 1, .ppEnabledExtensionNames = extensions),
               NULL, &gpu->instance);
    if (result == VK_ERROR_INCOMPATIBLE_DRIVER)
        tool_fail(
            "the Vulkan loader found no driver: install one (mesa-vulkan-drivers has "
            "lavapipe, which needs no GPU) or correct VK_DRIVER_FILES");
    if (result == VK_ERROR_LAYER_NOT_PRESENT)
        tool_fail("%s was not found (VK_ERROR_LAYER_NOT_PRESENT)",
                  layer ? layer : "a layer named in the environment");
    if (result == VK_ERROR_EXTENSION_NOT_PRESENT)
        tool_fail("neither the driver nor a layer offers VK_EXT_debug_utils");
    tool_check(result, "vkCreateInstance");

    vkuInitInstanceDispatchTable(gpu->instance, &gpu->instance_calls, get);
    gpu->get_device_command = (PFN_vkGetDeviceProcAddr)get(gpu->instance, "vkGetDeviceProcAddr");
    messenger.pNext = NULL;
    TOOL_CALL(gpu->instance_calls, CreateDebugUtilsMessengerEXT, gpu->instance, &messenger, NULL,
              &gpu->messenger);
}

/* ---- device */

static bool gpu_has_extensions(struct gpu *gpu, VkPhysicalDevice physical, const char **lacks)
{
    uint32_t count = 0;
    TOOL_CALL(gpu->instance_calls, EnumerateDeviceExtensionProperties, physical, NULL, &count,
              NULL);
    VkExtensionProperties *offered = tool_alloc(count, sizeof(*offered));
    TOOL_CALL(gpu->instance_calls, EnumerateDeviceExtensionProperties, physical, NULL, &count,
              offered);

    *lacks = NULL;
    for (size_t wanted = 0; wanted < gpu_extension_count(gpu) && !*lacks; ++wanted) {
        bool found = false;
        for (uint32_t i = 0; i < count && !found; ++i)
            found = strcmp(offered[i].extensionName, gpu_extensions[wanted]) == 0;
        if (!found)
            *lacks = gpu_extensions[wanted];
    }
    free(offered);
    return !*lacks;
}

/* A queue that computes; better one that also draws, since a mistake is planted in a render pass.
 */
static bool gpu_find_queue(struct gpu *gpu, VkPhysicalDevice physical)
{
    uint32_t count = 0;
    gpu->instance_calls.GetPhysicalDeviceQueueFamilyProperties(physical, &count, NULL);
    VkQueueFamilyProperties *families = tool_alloc(count, sizeof(*families));
    gpu->instance_calls.GetPhysicalDeviceQueueFamilyProperties(physical, &count, families);

    gpu->queue_flags = 0;
    for (uint32_t i = 0; i < count; ++i) {
        VkQueueFlags flags = families[i].queueFlags;
        bool better = !gpu->queue_flags || (flags & ~gpu->queue_flags & VK_QUEUE_GRAPHICS_BIT);
        if (families[i].queueCount && (flags & VK_QUEUE_COMPUTE_BIT) && better) {
            gpu->queue_family = i;
            gpu->queue_flags = flags;
        }
    }
    free(families);
    return gpu->queue_flags != 0;
}

/* The first thing the demo needs that the device doesn't have, or null. */
static const char *gpu_lacks(struct gpu *gpu, VkPhysicalDevice physical)
{
    VkPhysicalDeviceProperties properties;
    gpu->instance_calls.GetPhysicalDeviceProperties(physical, &properties);
    if (properties.apiVersion < VK_API_VERSION_1_2)
        return "Vulkan 1.2";

    const char *extension;
    if (!gpu_has_extensions(gpu, physical, &extension))
        return extension;

    STRUCT(VkPhysicalDeviceRayQueryFeaturesKHR, query);
    STRUCT(VkPhysicalDeviceAccelerationStructureFeaturesKHR, structures,
           .pNext = gpu->wants_queries ? &query : NULL);
    STRUCT(VkPhysicalDeviceVulkan12Features, core, .pNext = &structures);
    gpu->instance_calls.GetPhysicalDeviceFeatures2(
        physical, &MAKE(VkPhysicalDeviceFeatures2, .pNext = &core));
    if (!structures.accelerationStructure)
        return "the feature accelerationStructure";
    gpu->has_host = structures.accelerationStructureHostCommands;
    if (gpu->wants_queries && !query.rayQuery)
        return "the feature rayQuery";
    if (!core.bufferDeviceAddress)
        return "the feature bufferDeviceAddress";
    return gpu_find_queue(gpu, physical) ? NULL : "a queue that computes";
}

static void gpu_choose_device(struct gpu *gpu)
{
    VkPhysicalDevice devices[16];
    uint32_t count = sizeof(devices) / sizeof(*devices);
    VkResult result = gpu->instance_calls.EnumeratePhysicalDevices(gpu->instance, &count, devices);
    /* What the loader says where there are drivers, but none for this machine. */
    if (result == VK_ERROR_INITIALIZATION_FAILED)
        tool_fail(
            "the Vulkan drivers here offer no device (mesa-vulkan-drivers has lavapipe, "
            "which needs no GPU)");
    if (result != VK_INCOMPLETE)
        tool_check(result, "vkEnumeratePhysicalDevices");
    if (count == 0)
        tool_fail("the Vulkan drivers here offer no device");

    char reasons[1024] = "";
    for (uint32_t i = 0; i < count; ++i) {
        const char *lacks = gpu_lacks(gpu, devices[i]);
        gpu->instance_calls.GetPhysicalDeviceProperties(devices[i], &gpu->properties);
        if (!lacks) {
            gpu->physical = devices[i];
            return;
        }
        size_t used = strlen(reasons);
        snprintf(reasons + used, sizeof(reasons) - used, "%s%s lacks %s", i ? "; " : "",
                 gpu->properties.deviceName, lacks);
    }
    tool_fail("no device with acceleration structures%s: %s",
              gpu->wants_queries ? " and ray queries" : "", reasons);
}

/* A driver may offer the extension without its commands. */
static void gpu_require_commands(const struct gpu *gpu)
{
    static const char *const names[] = {
        "vkCmdBuildAccelerationStructuresKHR",
        "vkCmdCopyAccelerationStructureKHR",
        "vkCmdWriteAccelerationStructuresPropertiesKHR",
        "vkCreateAccelerationStructureKHR",
        "vkDestroyAccelerationStructureKHR",
        "vkGetAccelerationStructureBuildSizesKHR",
        "vkGetAccelerationStructureDeviceAddressKHR",
    };
    for (size_t i = 0; i < sizeof(names) / sizeof(*names); ++i)
        if (!gpu->get_device_command(gpu->device, names[i]))
            tool_fail("%s offers %s, but not its command %s", gpu->properties.deviceName,
                      gpu_extensions[0], names[i]);
}

static void gpu_open_device(struct gpu *gpu)
{
    STRUCT(VkPhysicalDeviceRayQueryFeaturesKHR, query, .rayQuery = VK_TRUE);
    STRUCT(VkPhysicalDeviceAccelerationStructureFeaturesKHR, structures,
           .pNext = gpu->wants_queries ? &query : NULL, .accelerationStructure = VK_TRUE,
           .accelerationStructureHostCommands = gpu->has_host);
    const STRUCT(VkPhysicalDeviceVulkan12Features, core, .pNext = &structures,
                 .bufferDeviceAddress = VK_TRUE);
    const float priority = 1.0f;
    PFN_vkCreateDevice create = (PFN_vkCreateDevice)gpu->instance_calls.GetInstanceProcAddr(
        gpu->instance, "vkCreateDevice");
    tool_check(create(gpu->physical,
                      &MAKE(VkDeviceCreateInfo, .pNext = &core, .queueCreateInfoCount = 1,
                            .pQueueCreateInfos = &MAKE(
                                VkDeviceQueueCreateInfo, .queueFamilyIndex = gpu->queue_family,
                                .queueCount = 1, .pQueuePriorities = &priority),
                            .enabledExtensionCount = gpu_extension_count(gpu),
                            .ppEnabledExtensionNames = gpu_extensions),
                      NULL, &gpu->device),
               "vkCreateDevice");
    vkuInitDeviceDispatchTable(gpu->device, &gpu->calls, gpu->get_device_command);
    gpu_require_commands(gpu);
}

void gpu_open(struct gpu *gpu, const char *layer,
              const VkDebugUtilsMessengerCreateInfoEXT *messenger, bool wants_queries)
{
    *gpu = (struct gpu){.wants_queries = wants_queries};
    gpu_open_instance(gpu, layer, *messenger);
    gpu_choose_device(gpu);
    gpu_open_device(gpu);

    gpu->limits = MAKE(VkPhysicalDeviceAccelerationStructurePropertiesKHR);
    gpu->instance_calls.GetPhysicalDeviceProperties2(
        gpu->physical, &MAKE(VkPhysicalDeviceProperties2, .pNext = &gpu->limits));
    gpu->instance_calls.GetPhysicalDeviceMemoryProperties(gpu->physical, &gpu->memory);

    gpu->calls.GetDeviceQueue(gpu->device, gpu->queue_family, 0, &gpu->queue);
    TOOL_CALL(gpu->calls, CreateCommandPool, gpu->device,
              &MAKE(VkCommandPoolCreateInfo, .flags = VK_COMMAND_POOL_CREATE_TRANSIENT_BIT,
                    .queueFamilyIndex = gpu->queue_family),
              NULL, &gpu->pool);
}

void gpu_close(struct gpu *gpu)
{
    gpu->calls.DestroyCommandPool(gpu->device, gpu->pool, NULL);
    gpu->calls.DestroyDevice(gpu->device, NULL);
    gpu->instance_calls.DestroyDebugUtilsMessengerEXT(gpu->instance, gpu->messenger, NULL);
    gpu->instance_calls.DestroyInstance(gpu->instance, NULL);
    dlclose(gpu->library);
}
