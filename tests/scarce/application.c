/* SPDX-License-Identifier: Apache-2.0 */
/* The instance and the device of the application, its messengers, and its objects. */
#include "application_parts.h"
#include "tests/fixture/make.h"
#include "tests/fixture/messenger.h"

#include <stdio.h>
#include <string.h>

enum { OWNED_MOST = 1024, HOST_MEMORY = 1 /* type of the null driver */ };

PFN_vkVoidFunction vkGetInstanceProcAddr(VkInstance instance, const char *pName); /* the loader's */

struct outcome outcome;
VkuDeviceDispatchTable vk;
VkDevice device;
VkQueue queue;

static VkuInstanceDispatchTable instance_vk;
static VkInstance instance;
static VkDebugUtilsMessengerEXT messenger;
static VkDebugReportCallbackEXT callback;

void complain(const char *what, int result)
{
    char *wrong = outcome.wrong;
    if (!wrong[0])
        snprintf(wrong, sizeof(outcome.wrong), "%s: %d", what, result);
}

/* ---- messages */

static void hear(const char *text)
{
    char *wrong = outcome.wrong;
    if (strstr(text, "ASSAY-warning") || strstr(text, "assay_validation."))
        return; /* about the bad setting, or what level content leaves out */
    if (strstr(text, "micromap-11555"))
        return; /* data is all zeros, which is no format of a micromap's triangle */
    if (!wrong[0])
        snprintf(wrong, sizeof(outcome.wrong), "%s", text);
}

MESSENGER_CALLBACK(hear_messenger)
{
    char text[4096];
    snprintf(text, sizeof(text), "%s: %s", data->pMessageIdName ? data->pMessageIdName : "",
             data->pMessage);
    hear(text);
    return VK_FALSE;
}

static VKAPI_ATTR VkBool32 VKAPI_CALL hear_callback(VkDebugReportFlagsEXT flags,
                                                    VkDebugReportObjectTypeEXT type,
                                                    uint64_t object, size_t location, int32_t code,
                                                    const char *layer, const char *message,
                                                    void *user)
{
    if (strcmp(layer, "Assay") == 0)
        hear(message);
    return VK_FALSE;
}

static const STRUCT(VkDebugUtilsMessengerCreateInfoEXT, messenger_info,
                    .messageSeverity = VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT |
                                       VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT,
                    .messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT,
                    .pfnUserCallback = hear_messenger);

/* ---- instance and device */

static void create_instance(void)
{
    static const char *const layers[] = {"VK_LAYER_ASSAY_validation"};
    static const char *const extensions[] = {VK_EXT_DEBUG_UTILS_EXTENSION_NAME,
                                             VK_EXT_DEBUG_REPORT_EXTENSION_NAME};
    static const char *const filter[] = {"VUID-none-such", "03674"};
    static const uint32_t limit = 0;
    const VkLayerSettingEXT settings[] = {
        {layers[0], "duplicate_message_limit", VK_LAYER_SETTING_TYPE_UINT32_EXT, 1, &limit},
        {layers[0], "message_id_filter", VK_LAYER_SETTING_TYPE_STRING_EXT, 2, filter},
    };
    const STRUCT(VkApplicationInfo, application, .apiVersion = VK_API_VERSION_1_3);
    const STRUCT(VkInstanceCreateInfo, info,
                 .pNext = &MAKE(VkLayerSettingsCreateInfoEXT, .pNext = &messenger_info,
                                .settingCount = 2, .pSettings = settings),
                 .pApplicationInfo = &application, .enabledLayerCount = 1,
                 .ppEnabledLayerNames = layers, .enabledExtensionCount = 2,
                 .ppEnabledExtensionNames = extensions);
    PFN_vkCreateInstance create =
        (PFN_vkCreateInstance)vkGetInstanceProcAddr(VK_NULL_HANDLE, "vkCreateInstance");
    outcome.is_creating_instance = true;
    GET("vkCreateInstance", create(&info, NULL, &instance));
    outcome.is_creating_instance = false;
    if (!instance)
        return;
    vkuInitInstanceDispatchTable(instance, &instance_vk, vkGetInstanceProcAddr);
    instance_vk.CreateDevice =
        (PFN_vkCreateDevice)vkGetInstanceProcAddr(instance, "vkCreateDevice");
}

static void create_device(void)
{
    static const char *const extensions[] = {VK_KHR_ACCELERATION_STRUCTURE_EXTENSION_NAME,
                                             VK_KHR_DEFERRED_HOST_OPERATIONS_EXTENSION_NAME,
                                             VK_NV_RAY_TRACING_EXTENSION_NAME,
                                             VK_NV_RAY_TRACING_MOTION_BLUR_EXTENSION_NAME,
                                             VK_EXT_OPACITY_MICROMAP_EXTENSION_NAME,
                                             VK_KHR_OPACITY_MICROMAP_EXTENSION_NAME,
                                             VK_NV_DISPLACEMENT_MICROMAP_EXTENSION_NAME,
                                             VK_KHR_DEVICE_ADDRESS_COMMANDS_EXTENSION_NAME};
    STRUCT(VkPhysicalDeviceDeviceAddressCommandsFeaturesKHR, commands,
           .deviceAddressCommands = VK_TRUE);
    STRUCT(VkPhysicalDeviceDisplacementMicromapFeaturesNV, displacement, .pNext = &commands,
           .displacementMicromap = VK_TRUE);
    STRUCT(VkPhysicalDeviceOpacityMicromapFeaturesEXT, micromaps_ext, .pNext = &displacement,
           .micromap = VK_TRUE, .micromapHostCommands = VK_TRUE);
    STRUCT(VkPhysicalDeviceOpacityMicromapFeaturesKHR, micromaps, .pNext = &micromaps_ext,
           .micromap = VK_TRUE);
    STRUCT(VkPhysicalDeviceBufferDeviceAddressFeatures, addresses,
           .pNext = &MAKE(VkPhysicalDeviceRayTracingMotionBlurFeaturesNV, .pNext = &micromaps,
                          .rayTracingMotionBlur = VK_TRUE),
           .bufferDeviceAddress = VK_TRUE);
    STRUCT(VkPhysicalDeviceAccelerationStructureFeaturesKHR, structures, .pNext = &addresses,
           .accelerationStructure = VK_TRUE, .accelerationStructureHostCommands = VK_TRUE);
    const VkPhysicalDeviceFeatures core = {.sparseBinding = VK_TRUE};
    static const float priority = 1;
    const STRUCT(VkDeviceQueueCreateInfo, queues, .queueCount = 1, .pQueuePriorities = &priority);
    const STRUCT(VkDeviceCreateInfo, info, .pNext = &structures, .queueCreateInfoCount = 1,
                 .pQueueCreateInfos = &queues, .enabledExtensionCount = 8,
                 .ppEnabledExtensionNames = extensions, .pEnabledFeatures = &core);
    VkPhysicalDevice physical = VK_NULL_HANDLE;
    uint32_t count = 1;
    instance_vk.EnumeratePhysicalDevices(instance, &count, &physical);
    GET("vkCreateDevice", instance_vk.CreateDevice(physical, &info, NULL, &device));
    if (!device)
        return;
    vkuInitDeviceDispatchTable(
        device, &vk,
        (PFN_vkGetDeviceProcAddr)vkGetInstanceProcAddr(instance, "vkGetDeviceProcAddr"));
    vk.GetDeviceQueue(device, 0, 0, &queue);
}

static void create_ears(void)
{
    const STRUCT(VkDebugReportCallbackCreateInfoEXT, info, .flags = VK_DEBUG_REPORT_ERROR_BIT_EXT,
                 .pfnCallback = hear_callback);
    GET("vkCreateDebugUtilsMessengerEXT",
        instance_vk.CreateDebugUtilsMessengerEXT(instance, &messenger_info, NULL, &messenger));
    GET("vkCreateDebugReportCallbackEXT",
        instance_vk.CreateDebugReportCallbackEXT(instance, &info, NULL, &callback));
}

/* ---- objects */

static struct owned {
    PFN_vkVoidFunction destroy;
    uint64_t handle;
} owned[OWNED_MOST];
static size_t owned_count;

void own(PFN_vkVoidFunction destroy, uint64_t handle)
{
    if (owned_count < OWNED_MOST)
        owned[owned_count++] = (struct owned){destroy, handle};
    else
        complain("too many objects", OWNED_MOST);
}

/* Handles are pointers here, so that one type stands for all commands. */
static void destroy(const struct owned *object)
{
    ((PFN_vkDestroyFence)object->destroy)(device, (VkFence)object->handle, NULL);
}

VkBuffer create_bound_buffer(VkDeviceSize size, VkBufferUsageFlags usage)
{
    VkDeviceMemory memory = VK_NULL_HANDLE;
    VkBuffer buffer = VK_NULL_HANDLE;
    const STRUCT(VkMemoryAllocateFlagsInfo, flags, .flags = VK_MEMORY_ALLOCATE_DEVICE_ADDRESS_BIT);
    const STRUCT(VkMemoryAllocateInfo, allocation, .pNext = &flags, .allocationSize = size,
                 .memoryTypeIndex = HOST_MEMORY);
    const STRUCT(VkBufferCreateInfo, info, .size = size,
                 .usage = usage | VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT);
    CALL(AllocateMemory, device, &allocation, NULL, &memory);
    OWN(FreeMemory, memory);
    CREATE(Buffer, &info, &buffer);
    CALL(BindBufferMemory, device, buffer, memory, 0);
    return buffer;
}

VkMicromapEXT create_micromap(VkBuffer buffer, VkDeviceSize offset, VkDeviceSize size,
                              VkMicromapTypeEXT type)
{
    VkMicromapEXT micromap = VK_NULL_HANDLE;
    const STRUCT(VkMicromapCreateInfoEXT, info, .buffer = buffer, .offset = offset, .size = size,
                 .type = type);
    CREATE(MicromapEXT, &info, &micromap);
    return micromap;
}

VkAccelerationStructureGeometryKHR describe_triangles(VkDeviceOrHostAddressConstKHR vertices,
                                                      const void *next)
{
    return MAKE(VkAccelerationStructureGeometryKHR, .geometryType = VK_GEOMETRY_TYPE_TRIANGLES_KHR,
                .geometry.triangles =
                    MAKE(VkAccelerationStructureGeometryTrianglesDataKHR, .pNext = next,
                         .vertexFormat = VK_FORMAT_R32G32B32_SFLOAT, .vertexData = vertices,
                         .vertexStride = 12, .maxVertex = 2, .indexType = VK_INDEX_TYPE_NONE_KHR));
}

/* ---- life */

static bool is_well(void)
{
    return !outcome.wrong[0];
}

void application_live(void)
{
    create_instance();
    if (is_well())
        create_device();
    if (is_well()) {
        create_ears();
        create_objects();
        if (is_well())
            record_all();
        vk.DeviceWaitIdle(device);
        while (owned_count > 0)
            destroy(&owned[--owned_count]);
        vk.DestroyDevice(device, NULL);
        instance_vk.DestroyDebugReportCallbackEXT(instance, callback, NULL);
        instance_vk.DestroyDebugUtilsMessengerEXT(instance, messenger, NULL);
    }
    if (instance)
        instance_vk.DestroyInstance(instance, NULL);
}
