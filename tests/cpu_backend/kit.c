/* SPDX-License-Identifier: Apache-2.0 */
/* Making instances and devices. */
#include "kit.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "vuid-tables/registry.h"

static void configure(const struct platform *platform, const struct kit_setup *setup)
{
    struct null_driver_config config = platform->null_driver.default_config();
    for (size_t i = 0; !setup->driver_traces && i < registry_ray_tracing_count; i++)
        null_driver_hide_extension(&config, registry_ray_tracing[i]);
    if (setup->configure != NULL)
        setup->configure(&config);
    platform->null_driver.configure(&config);
}

static void create_instance(struct kit *kit, const struct kit_setup *setup)
{
    const char *backend = setup->backend != NULL ? setup->backend : "cpu";
    const VkLayerSettingEXT setting = {LAYER_NAME, "backend", VK_LAYER_SETTING_TYPE_STRING_EXT, 1,
                                       &backend};
    const VkLayerSettingsCreateInfoEXT settings = {
        .sType = VK_STRUCTURE_TYPE_LAYER_SETTINGS_CREATE_INFO_EXT,
        .settingCount = 1,
        .pSettings = &setting,
    };
    const VkApplicationInfo application = {
        .sType = VK_STRUCTURE_TYPE_APPLICATION_INFO,
        .apiVersion = setup->api_version != 0 ? setup->api_version : VK_API_VERSION_1_3,
    };
    const char *layer = LAYER_NAME, *extension = VK_EXT_DEBUG_UTILS_EXTENSION_NAME;
    const VkInstanceCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO,
        .pNext = &settings,
        .pApplicationInfo = &application,
        .enabledLayerCount = 1,
        .ppEnabledLayerNames = &layer,
        .enabledExtensionCount = 1,
        .ppEnabledExtensionNames = &extension,
    };
    const PFN_vkGetInstanceProcAddr proc_addr = kit->platform->get_instance_proc_addr;
    const PFN_vkCreateInstance create = (PFN_vkCreateInstance)proc_addr(NULL, "vkCreateInstance");
    assert_int_equal(create(&info, NULL, &kit->instance), VK_SUCCESS);
    vkuInitInstanceDispatchTable(kit->instance, &kit->vk, proc_addr);
    kit->vk.CreateDevice = (PFN_vkCreateDevice)proc_addr(kit->instance, "vkCreateDevice");
    kit->get_device_proc_addr =
        (PFN_vkGetDeviceProcAddr)proc_addr(kit->instance, "vkGetDeviceProcAddr");
}

void kit_open(struct kit *kit, const struct platform *platform, const struct kit_setup *setup)
{
    memset(kit, 0, sizeof(*kit));
    kit->platform = platform;
    if (platform->is_null)
        configure(platform, setup);
    create_instance(kit, setup);
    const VkDebugUtilsMessengerCreateInfoEXT messenger = messages_messenger(&kit->messages);
    assert_int_equal(
        kit->vk.CreateDebugUtilsMessengerEXT(kit->instance, &messenger, NULL, &kit->messenger),
        VK_SUCCESS);
    uint32_t count = 1;
    kit->vk.EnumeratePhysicalDevices(kit->instance, &count, &kit->physical);
    assert_int_equal(count, 1);
    kit->extension_count = KIT_EXTENSIONS_MAX;
    assert_int_equal(kit->vk.EnumerateDeviceExtensionProperties(
                         kit->physical, NULL, &kit->extension_count, kit->extensions),
                     VK_SUCCESS);
}

void kit_close(struct kit *kit)
{
    kit->vk.DestroyDebugUtilsMessengerEXT(kit->instance, kit->messenger, NULL);
    kit->vk.DestroyInstance(kit->instance, NULL);
}

unsigned kit_count_extension(const struct kit *kit, const char *name)
{
    unsigned found = 0;
    for (uint32_t i = 0; i < kit->extension_count; i++)
        found += strcmp(kit->extensions[i].extensionName, name) == 0;
    return found;
}

bool kit_has_conditions(const struct kit *kit)
{
    return kit_count_extension(kit, VK_EXT_CONDITIONAL_RENDERING_EXTENSION_NAME) != 0;
}

VkResult kit_create_device(const struct kit *kit, const void *chain, const char *const *extensions,
                           uint32_t extension_count, VkDevice *device, VkuDeviceDispatchTable *vk)
{
    const char *enabled[KIT_ENABLED_MAX];
    VkPhysicalDeviceConditionalRenderingFeaturesEXT conditional = {
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_CONDITIONAL_RENDERING_FEATURES_EXT,
        .pNext = (void *)(uintptr_t)chain,
        .conditionalRendering = VK_TRUE,
    };
    assert_true(extension_count < KIT_ENABLED_MAX);
    for (uint32_t i = 0; i < extension_count; i++)
        enabled[i] = extensions[i];
    if (kit_has_conditions(kit)) {
        enabled[extension_count++] = VK_EXT_CONDITIONAL_RENDERING_EXTENSION_NAME;
        chain = &conditional;
    }
    const VkPhysicalDeviceVulkan12Features core = {
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES,
        .pNext = (void *)(uintptr_t)chain,
        .timelineSemaphore = VK_TRUE,
        .bufferDeviceAddress = VK_TRUE,
    };
    const float priority = 1;
    const VkDeviceQueueCreateInfo queue = {
        .sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO,
        .queueCount = 1,
        .pQueuePriorities = &priority,
    };
    const VkDeviceCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO,
        .pNext = &core,
        .queueCreateInfoCount = 1,
        .pQueueCreateInfos = &queue,
        .enabledExtensionCount = extension_count,
        .ppEnabledExtensionNames = enabled,
    };
    const VkResult result = kit->vk.CreateDevice(kit->physical, &info, NULL, device);
    if (result == VK_SUCCESS)
        vkuInitDeviceDispatchTable(*device, vk, kit->get_device_proc_addr);
    return result;
}

VkDevice kit_open_device(const struct kit *kit, VkuDeviceDispatchTable *vk)
{
    static const char *const extensions[] = {VK_KHR_ACCELERATION_STRUCTURE_EXTENSION_NAME,
                                             VK_KHR_DEFERRED_HOST_OPERATIONS_EXTENSION_NAME,
                                             VK_NV_RAY_TRACING_EXTENSION_NAME,
                                             VK_NV_RAY_TRACING_MOTION_BLUR_EXTENSION_NAME,
                                             VK_NV_RAY_TRACING_LINEAR_SWEPT_SPHERES_EXTENSION_NAME,
                                             VK_AMDX_DENSE_GEOMETRY_FORMAT_EXTENSION_NAME,
                                             VK_EXT_OPACITY_MICROMAP_EXTENSION_NAME,
                                             VK_KHR_OPACITY_MICROMAP_EXTENSION_NAME,
                                             VK_NV_DISPLACEMENT_MICROMAP_EXTENSION_NAME};
    VkPhysicalDeviceDisplacementMicromapFeaturesNV displacement = {
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DISPLACEMENT_MICROMAP_FEATURES_NV,
        .displacementMicromap = VK_TRUE,
    };
    VkPhysicalDeviceOpacityMicromapFeaturesKHR micromap_khr = {
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_OPACITY_MICROMAP_FEATURES_KHR,
        .pNext = &displacement,
        .micromap = VK_TRUE,
    };
    VkPhysicalDeviceOpacityMicromapFeaturesEXT micromap_ext = {
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_OPACITY_MICROMAP_FEATURES_EXT,
        .pNext = &micromap_khr,
        .micromap = VK_TRUE,
        .micromapHostCommands = VK_TRUE,
    };
    VkPhysicalDeviceDenseGeometryFormatFeaturesAMDX dense = {
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DENSE_GEOMETRY_FORMAT_FEATURES_AMDX,
        .pNext = &micromap_ext,
        .denseGeometryFormat = VK_TRUE,
    };
    VkPhysicalDeviceRayTracingLinearSweptSpheresFeaturesNV spheres = {
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_RAY_TRACING_LINEAR_SWEPT_SPHERES_FEATURES_NV,
        .pNext = &dense,
        .spheres = VK_TRUE,
        .linearSweptSpheres = VK_TRUE,
    };
    VkPhysicalDeviceRayTracingMotionBlurFeaturesNV motion = {
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_RAY_TRACING_MOTION_BLUR_FEATURES_NV,
        .pNext = &spheres,
        .rayTracingMotionBlur = VK_TRUE,
    };
    const VkPhysicalDeviceAccelerationStructureFeaturesKHR structures = {
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_ACCELERATION_STRUCTURE_FEATURES_KHR,
        .pNext = &motion,
        .accelerationStructure = VK_TRUE,
        .accelerationStructureIndirectBuild = VK_TRUE,
        .accelerationStructureHostCommands = VK_TRUE,
    };
    VkDevice device;
    assert_int_equal(kit_create_device(kit, &structures, extensions,
                                       sizeof(extensions) / sizeof(extensions[0]), &device, vk),
                     VK_SUCCESS);
    return device;
}
