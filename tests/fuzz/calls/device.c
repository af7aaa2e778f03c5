/* SPDX-License-Identifier: Apache-2.0 */
/* The instance and the device of a stream, through the layer, and an ordinary scene. */
#include <string.h>
#include <vulkan/vk_layer.h>

#include "calls.h"
#include "tests/fixture/make.h"
#include "tests/fixture/messenger.h"

VKAPI_ATTR VkResult VKAPI_CALL
vkNegotiateLoaderLayerInterfaceVersion(VkNegotiateLayerInterface *pVersionStruct);

static PFN_vkGetInstanceProcAddr layer_proc_addr;
static PFN_vkGetDeviceProcAddr layer_device_proc_addr;

static void negotiate(void)
{
    VkNegotiateLayerInterface negotiation = {.sType = LAYER_NEGOTIATE_INTERFACE_STRUCT,
                                             .loaderLayerInterfaceVersion = 2};
    vkNegotiateLoaderLayerInterfaceVersion(&negotiation);
    layer_proc_addr = negotiation.pfnGetInstanceProcAddr;
    layer_device_proc_addr = negotiation.pfnGetDeviceProcAddr;
}

/* ---- the instance */

MESSENGER_CALLBACK(hear)
{
    const struct calls *calls = user;
    if (calls->hear)
        calls->hear(data);
    return strlen(data->pMessage) ? calls->answer : VK_FALSE;
}

static VkResult create_instance(struct calls *calls, const char *level, bool skips_when_full,
                                const VkDebugUtilsMessengerCreateInfoEXT *messenger)
{
    static const char *const layers[] = {"VK_LAYER_ASSAY_validation"};
    static const char *const extensions[] = {VK_EXT_DEBUG_UTILS_EXTENSION_NAME};
    const char *backend = calls->is_cpu ? "cpu" : "driver";
    const char *when_full = skips_when_full ? "skip" : "wait";
    const uint32_t budget_mib = 2, limit = calls->has_no_limit ? 0 : 3;
    const VkLayerSettingEXT settings[] = {
        {layers[0], "level", VK_LAYER_SETTING_TYPE_STRING_EXT, 1, &level},
        {layers[0], "backend", VK_LAYER_SETTING_TYPE_STRING_EXT, 1, &backend},
        {layers[0], "content_when_full", VK_LAYER_SETTING_TYPE_STRING_EXT, 1, &when_full},
        {layers[0], "content_budget_mib", VK_LAYER_SETTING_TYPE_UINT32_EXT, 1, &budget_mib},
        {layers[0], "duplicate_message_limit", VK_LAYER_SETTING_TYPE_UINT32_EXT, 1, &limit},
    };
    const STRUCT(VkLayerSettingsCreateInfoEXT, given, .pNext = messenger,
                 .settingCount = sizeof(settings) / sizeof(settings[0]), .pSettings = settings);
    VkLayerInstanceLink below = {.pfnNextGetInstanceProcAddr = calls_driver_proc_addr};
    VkLayerInstanceCreateInfo link = {.sType = VK_STRUCTURE_TYPE_LOADER_INSTANCE_CREATE_INFO,
                                      .pNext = &given,
                                      .function = VK_LAYER_LINK_INFO,
                                      .u.pLayerInfo = &below};
    const STRUCT(VkApplicationInfo, application, .apiVersion = VK_API_VERSION_1_3);
    const STRUCT(VkInstanceCreateInfo, info, .pNext = &link, .pApplicationInfo = &application,
                 .enabledExtensionCount = 1, .ppEnabledExtensionNames = extensions);
    PFN_vkCreateInstance create = (PFN_vkCreateInstance)layer_proc_addr(NULL, "vkCreateInstance");
    return create(&info, NULL, &calls->instance);
}

/* ---- the device */

static const char *const device_extensions[] = {
    VK_KHR_ACCELERATION_STRUCTURE_EXTENSION_NAME,
    VK_KHR_DEFERRED_HOST_OPERATIONS_EXTENSION_NAME,
    VK_NV_RAY_TRACING_EXTENSION_NAME,
    VK_NV_RAY_TRACING_MOTION_BLUR_EXTENSION_NAME,
    VK_NV_RAY_TRACING_LINEAR_SWEPT_SPHERES_EXTENSION_NAME,
    VK_EXT_OPACITY_MICROMAP_EXTENSION_NAME,
    VK_KHR_OPACITY_MICROMAP_EXTENSION_NAME,
    VK_NV_DISPLACEMENT_MICROMAP_EXTENSION_NAME,
    VK_KHR_MAINTENANCE_5_EXTENSION_NAME,
    VK_AMDX_DENSE_GEOMETRY_FORMAT_EXTENSION_NAME,
    VK_KHR_INDEX_TYPE_UINT8_EXTENSION_NAME,
    /* Backend cpu does without. */
    VK_KHR_RAY_TRACING_PIPELINE_EXTENSION_NAME,
    VK_KHR_DEVICE_ADDRESS_COMMANDS_EXTENSION_NAME,
};
enum {
    DEVICE_EXTENSIONS = sizeof(device_extensions) / sizeof(device_extensions[0]),
    OF_DRIVER = 2
};

static VkResult create_with(struct calls *calls, const void *features)
{
    static const float priorities[] = {1, 1};
    const VkDeviceQueueCreateInfo queues[] = {
        MAKE(VkDeviceQueueCreateInfo, .queueCount = 2, .pQueuePriorities = priorities),
        MAKE(VkDeviceQueueCreateInfo, .queueFamilyIndex = 1, .queueCount = 1,
             .pQueuePriorities = priorities),
    };
    VkLayerDeviceLink below = {.pfnNextGetInstanceProcAddr = calls_driver_proc_addr,
                               .pfnNextGetDeviceProcAddr = calls_driver_device_proc_addr};
    VkLayerDeviceCreateInfo link = {.sType = VK_STRUCTURE_TYPE_LOADER_DEVICE_CREATE_INFO,
                                    .pNext = features,
                                    .function = VK_LAYER_LINK_INFO,
                                    .u.pLayerInfo = &below};
    VkLayerDeviceCreateInfo loader_data = {.sType = VK_STRUCTURE_TYPE_LOADER_DEVICE_CREATE_INFO,
                                           .pNext = &link,
                                           .function = VK_LOADER_DATA_CALLBACK,
                                           .u.pfnSetDeviceLoaderData = calls_set_loader_data};
    const VkPhysicalDeviceFeatures core = {.sparseBinding = VK_TRUE,
                                           .sparseResidencyBuffer = VK_TRUE,
                                           .sparseResidencyAliased = VK_TRUE};
    const STRUCT(VkDeviceCreateInfo, info, .pNext = &loader_data, .queueCreateInfoCount = 2,
                 .pQueueCreateInfos = queues,
                 .enabledExtensionCount = DEVICE_EXTENSIONS - (calls->is_cpu ? OF_DRIVER : 0),
                 .ppEnabledExtensionNames = device_extensions, .pEnabledFeatures = &core);
    PFN_vkCreateDevice create =
        (PFN_vkCreateDevice)layer_proc_addr(calls->instance, "vkCreateDevice");
    return create(calls->physical, &info, NULL, &calls->device);
}

static VkResult create_device(struct calls *calls)
{
    STRUCT(VkPhysicalDeviceVulkan13Features, core_13,
           .pNext = &MAKE(VkPhysicalDeviceVulkan12Features, .timelineSemaphore = VK_TRUE,
                          .hostQueryReset = VK_TRUE, .bufferDeviceAddress = VK_TRUE),
           .synchronization2 = VK_TRUE, .dynamicRendering = VK_TRUE);
    STRUCT(VkPhysicalDeviceOpacityMicromapFeaturesEXT, micromap_ext, .pNext = &core_13,
           .micromap = VK_TRUE);
    STRUCT(VkPhysicalDeviceOpacityMicromapFeaturesKHR, micromap, .pNext = &micromap_ext,
           .micromap = VK_TRUE);
    STRUCT(VkPhysicalDeviceRayTracingMotionBlurFeaturesNV, motion,
           .pNext = &MAKE(VkPhysicalDeviceDisplacementMicromapFeaturesNV, .pNext = &micromap,
                          .displacementMicromap = VK_TRUE),
           .rayTracingMotionBlur = VK_TRUE);
    STRUCT(VkPhysicalDeviceDenseGeometryFormatFeaturesAMDX, dense,
           .pNext = &MAKE(VkPhysicalDeviceRayTracingLinearSweptSpheresFeaturesNV, .pNext = &motion,
                          .spheres = VK_TRUE, .linearSweptSpheres = VK_TRUE),
           .denseGeometryFormat = VK_TRUE);
    STRUCT(VkPhysicalDeviceMaintenance5Features, maintenance_5, .pNext = &dense,
           .maintenance5 = VK_TRUE);
    STRUCT(VkPhysicalDeviceAccelerationStructureFeaturesKHR, structures, .pNext = &maintenance_5,
           .accelerationStructure = VK_TRUE, .accelerationStructureIndirectBuild = VK_TRUE,
           .accelerationStructureHostCommands = VK_TRUE);
    return create_with(calls, &structures);
}

/* Of a backend and level the answers are always the same, and to ask for all takes longer than most
 * streams. */
static struct tables {
    bool are_known, has_device;
    VkuInstanceDispatchTable instance_vk;
    VkuDeviceDispatchTable vk;
    PFN_vkTraceRaysASSAY trace;
} all_tables[2][4];

static bool open_device(struct calls *calls, struct tables *tables)
{
    uint32_t count = 1;
    if (!tables->are_known)
        vkuInitInstanceDispatchTable(calls->instance, &tables->instance_vk, layer_proc_addr);
    tables->are_known = true;
    calls->instance_vk = tables->instance_vk;
    calls->instance_vk.EnumeratePhysicalDevices(calls->instance, &count, &calls->physical);
    if (create_device(calls) != VK_SUCCESS)
        return false;
    if (!tables->has_device) {
        vkuInitDeviceDispatchTable(calls->device, &tables->vk, layer_device_proc_addr);
        tables->trace =
            (PFN_vkTraceRaysASSAY)layer_device_proc_addr(calls->device, "vkTraceRaysASSAY");
    }
    tables->has_device = true;
    calls->vk = tables->vk;
    calls->trace = tables->trace;
    for (uint32_t i = 0; i < QUEUES; i++)
        calls->vk.GetDeviceQueue(calls->device, i / 2, i % 2, &calls->queues[i]);
    return true;
}

/* ---- the stream's beginning and end */

static VkDebugUtilsMessengerCreateInfoEXT messenger_info(struct calls *calls)
{
    return MAKE(VkDebugUtilsMessengerCreateInfoEXT,
                .messageSeverity = VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT |
                                   VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT,
                .messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT |
                               VK_DEBUG_UTILS_MESSAGE_TYPE_GENERAL_BIT_EXT,
                .pfnUserCallback = hear, .pUserData = calls);
}

bool calls_open(struct calls *calls)
{
    static const char *const levels[] = {"content", "execution", "content", "state"};
    uint8_t byte = take(calls);
    const VkDebugUtilsMessengerCreateInfoEXT messenger = messenger_info(calls);
    negotiate();
    calls->is_cpu = byte & 4;
    calls->recycles_handles = byte & 8;
    calls_configure_driver(calls->is_cpu, calls->recycles_handles, byte & 16, byte & 128 ? 2 : 0);
    if (create_instance(calls, calls->level ? calls->level : levels[byte & 3], byte & 64,
                        &messenger) != VK_SUCCESS)
        return false;
    bool is_open = open_device(calls, &all_tables[calls->is_cpu][byte & 3]);
    if (!is_open) {
        calls->instance_vk.DestroyInstance(calls->instance, NULL);
        return false;
    }
    calls->instance_vk.CreateDebugUtilsMessengerEXT(calls->instance, &messenger, NULL,
                                                    &calls->messenger);
    if (!(byte & 32))
        calls_prepare(calls);
    return true;
}

void calls_close(struct calls *calls)
{
    calls_recycle_all(calls->instance);
    calls->vk.DestroyDevice(calls->device, NULL);
    calls->instance_vk.DestroyDebugUtilsMessengerEXT(calls->instance, calls->messenger, NULL);
    calls->instance_vk.DestroyInstance(calls->instance, NULL);
    while (calls->deferred) {
        struct build_arguments *first = calls->deferred;
        calls->deferred = first->next;
        build_arguments_free(first);
    }
}
