/* SPDX-License-Identifier: Apache-2.0 */
/* Making instances and devices. */
#include "tests/cpu_backend/instance_fixture.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "vuid-tables/registry.h"

static void configure(const struct platform *platform, const struct instance_fixture_setup *setup)
{
    struct null_driver_config config = platform->null_driver.default_config();
    for (size_t i = 0; !setup->driver_traces && i < registry_ray_tracing_count; i++)
        null_driver_hide_extension(&config, registry_ray_tracing[i]);
    if (setup->configure != NULL)
        setup->configure(&config);
    platform->null_driver.configure(&config);
}

static void create_instance(struct instance_fixture *instance_fixture,
                            const struct instance_fixture_setup *setup)
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
    const PFN_vkGetInstanceProcAddr proc_addr = instance_fixture->platform->get_instance_proc_addr;
    const PFN_vkCreateInstance create = (PFN_vkCreateInstance)proc_addr(NULL, "vkCreateInstance");
    assert_int_equal(create(&info, NULL, &instance_fixture->instance), VK_SUCCESS);
    vkuInitInstanceDispatchTable(instance_fixture->instance, &instance_fixture->vk, proc_addr);
    instance_fixture->vk.CreateDevice =
        (PFN_vkCreateDevice)proc_addr(instance_fixture->instance, "vkCreateDevice");
    instance_fixture->get_device_proc_addr =
        (PFN_vkGetDeviceProcAddr)proc_addr(instance_fixture->instance, "vkGetDeviceProcAddr");
}

void instance_fixture_open(struct instance_fixture *instance_fixture,
                           const struct platform *platform,
                           const struct instance_fixture_setup *setup)
{
    memset(instance_fixture, 0, sizeof(*instance_fixture));
    instance_fixture->platform = platform;
    if (platform->is_null)
        configure(platform, setup);
    create_instance(instance_fixture, setup);
    const VkDebugUtilsMessengerCreateInfoEXT messenger =
        messages_messenger(&instance_fixture->messages);
    assert_int_equal(
        instance_fixture->vk.CreateDebugUtilsMessengerEXT(instance_fixture->instance, &messenger,
                                                          NULL, &instance_fixture->messenger),
        VK_SUCCESS);
    uint32_t count = 1;
    instance_fixture->vk.EnumeratePhysicalDevices(instance_fixture->instance, &count,
                                                  &instance_fixture->physical);
    assert_int_equal(count, 1);
    instance_fixture->extension_count = INSTANCE_FIXTURE_EXTENSIONS_MAX;
    assert_int_equal(instance_fixture->vk.EnumerateDeviceExtensionProperties(
                         instance_fixture->physical, NULL, &instance_fixture->extension_count,
                         instance_fixture->extensions),
                     VK_SUCCESS);
}

void instance_fixture_close(struct instance_fixture *instance_fixture)
{
    instance_fixture->vk.DestroyDebugUtilsMessengerEXT(instance_fixture->instance,
                                                       instance_fixture->messenger, NULL);
    instance_fixture->vk.DestroyInstance(instance_fixture->instance, NULL);
}

unsigned instance_fixture_count_extension(const struct instance_fixture *instance_fixture,
                                          const char *name)
{
    unsigned found = 0;
    for (uint32_t i = 0; i < instance_fixture->extension_count; i++)
        found += strcmp(instance_fixture->extensions[i].extensionName, name) == 0;
    return found;
}

bool instance_fixture_has_conditions(const struct instance_fixture *instance_fixture)
{
    return instance_fixture_count_extension(instance_fixture,
                                            VK_EXT_CONDITIONAL_RENDERING_EXTENSION_NAME) != 0;
}

VkResult instance_fixture_create_device(const struct instance_fixture *instance_fixture,
                                        const void *chain, const char *const *extensions,
                                        uint32_t extension_count, VkDevice *device,
                                        VkuDeviceDispatchTable *vk)
{
    const char *enabled[INSTANCE_FIXTURE_ENABLED_MAX];
    VkPhysicalDeviceConditionalRenderingFeaturesEXT conditional = {
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_CONDITIONAL_RENDERING_FEATURES_EXT,
        .pNext = (void *)(uintptr_t)chain,
        .conditionalRendering = VK_TRUE,
    };
    assert_true(extension_count < INSTANCE_FIXTURE_ENABLED_MAX);
    for (uint32_t i = 0; i < extension_count; i++)
        enabled[i] = extensions[i];
    if (instance_fixture_has_conditions(instance_fixture)) {
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
    const VkResult result =
        instance_fixture->vk.CreateDevice(instance_fixture->physical, &info, NULL, device);
    if (result == VK_SUCCESS)
        vkuInitDeviceDispatchTable(*device, vk, instance_fixture->get_device_proc_addr);
    return result;
}

VkDevice instance_fixture_open_device(const struct instance_fixture *instance_fixture,
                                      VkuDeviceDispatchTable *vk)
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
    assert_int_equal(instance_fixture_create_device(instance_fixture, &structures, extensions,
                                                    sizeof(extensions) / sizeof(extensions[0]),
                                                    &device, vk),
                     VK_SUCCESS);
    return device;
}
