/* SPDX-License-Identifier: Apache-2.0 */
/* The instance and the device of the application, its ears, and its objects. */
#include "application_parts.h"
#include "tests/fixture/make.h"

#include <stdio.h>
#include <string.h>

PFN_vkVoidFunction vkGetInstanceProcAddr(VkInstance instance, const char *pName); /* the loader's */

void complain(struct application *app, const char *what, int result)
{
    char *wrong = app->outcome->wrong;
    if (!wrong[0])
        snprintf(wrong, sizeof(app->outcome->wrong), "%s: %d", what, result);
}

/* ---- messages */

static void hear(struct application *app, const char *text)
{
    char *wrong = app->outcome->wrong;
    if (strstr(text, "ASSAY-warning") || strstr(text, "assay_validation."))
        return; /* about the bad setting, or what level content leaves out */
    if (strstr(text, "micromap-11555"))
        return; /* data is all zeros, which is no format of a micromap's triangle */
    if (app->expected_id && strstr(text, app->expected_id))
        app->heard++;
    else if (!wrong[0])
        snprintf(wrong, sizeof(app->outcome->wrong), "%s", text);
}

static VKAPI_ATTR VkBool32 VKAPI_CALL hear_messenger(
    VkDebugUtilsMessageSeverityFlagBitsEXT severity, VkDebugUtilsMessageTypeFlagsEXT types,
    const VkDebugUtilsMessengerCallbackDataEXT *data, void *user)
{
    char text[4096];
    snprintf(text, sizeof(text), "%s: %s", data->pMessageIdName ? data->pMessageIdName : "",
             data->pMessage);
    hear(user, text);
    return VK_FALSE;
}

static VKAPI_ATTR VkBool32 VKAPI_CALL hear_callback(VkDebugReportFlagsEXT flags,
                                                    VkDebugReportObjectTypeEXT type,
                                                    uint64_t object, size_t location, int32_t code,
                                                    const char *layer, const char *message,
                                                    void *user)
{
    struct application *app = user;
    if (strcmp(layer, "Assay") == 0 && !(app->expected_id && strstr(message, app->expected_id)))
        hear(user, message);
    return VK_FALSE;
}

void expect(struct application *app, const char *id)
{
    app->expected_id = id;
    app->heard = 0;
    app->outcome->mistakes++;
}

void expect_nothing_more(struct application *app)
{
    if (app->heard > 1)
        complain(app, app->expected_id, (int)app->heard);
    app->outcome->expected += app->heard;
    app->expected_id = NULL;
}

/* ---- instance and device */

static void create_instance(struct application *app)
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
    VkDebugUtilsMessengerCreateInfoEXT messenger = app->messenger_info;
    const STRUCT(VkApplicationInfo, application, .apiVersion = VK_API_VERSION_1_3);
    const STRUCT(VkInstanceCreateInfo, info,
                 .pNext = &MAKE(VkLayerSettingsCreateInfoEXT, .pNext = &messenger,
                                .settingCount = 2, .pSettings = settings),
                 .pApplicationInfo = &application, .enabledLayerCount = 1,
                 .ppEnabledLayerNames = layers, .enabledExtensionCount = 2,
                 .ppEnabledExtensionNames = extensions);
    PFN_vkCreateInstance create =
        (PFN_vkCreateInstance)vkGetInstanceProcAddr(VK_NULL_HANDLE, "vkCreateInstance");
    app->outcome->is_creating_instance = true;
    GET(app, "vkCreateInstance", create(&info, NULL, &app->instance));
    app->outcome->is_creating_instance = false;
    if (!app->instance)
        return;
    vkuInitInstanceDispatchTable(app->instance, &app->instance_vk, vkGetInstanceProcAddr);
    app->instance_vk.CreateDevice =
        (PFN_vkCreateDevice)vkGetInstanceProcAddr(app->instance, "vkCreateDevice");
}

static void create_device(struct application *app)
{
    static const char *const extensions[] = {VK_KHR_ACCELERATION_STRUCTURE_EXTENSION_NAME,
                                             VK_KHR_DEFERRED_HOST_OPERATIONS_EXTENSION_NAME,
                                             VK_NV_RAY_TRACING_EXTENSION_NAME,
                                             VK_NV_RAY_TRACING_MOTION_BLUR_EXTENSION_NAME,
                                             VK_EXT_OPACITY_MICROMAP_EXTENSION_NAME,
                                             VK_KHR_OPACITY_MICROMAP_EXTENSION_NAME,
                                             VK_NV_DISPLACEMENT_MICROMAP_EXTENSION_NAME,
                                             VK_KHR_DEVICE_ADDRESS_COMMANDS_EXTENSION_NAME};
    STRUCT(VkPhysicalDeviceDisplacementMicromapFeaturesNV, displacement,
           .displacementMicromap = VK_TRUE);
    STRUCT(VkPhysicalDeviceOpacityMicromapFeaturesEXT, micromaps_ext, .pNext = &displacement,
           .micromap = VK_TRUE);
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
    const STRUCT(VkDeviceQueueCreateInfo, queue, .queueCount = 1, .pQueuePriorities = &priority);
    const STRUCT(VkDeviceCreateInfo, info, .pNext = &structures, .queueCreateInfoCount = 1,
                 .pQueueCreateInfos = &queue, .enabledExtensionCount = 8,
                 .ppEnabledExtensionNames = extensions, .pEnabledFeatures = &core);
    VkPhysicalDevice physical = VK_NULL_HANDLE;
    uint32_t count = 1;
    app->instance_vk.EnumeratePhysicalDevices(app->instance, &count, &physical);
    GET(app, "vkCreateDevice", app->instance_vk.CreateDevice(physical, &info, NULL, &app->device));
    if (!app->device)
        return;
    vkuInitDeviceDispatchTable(
        app->device, &app->vk,
        (PFN_vkGetDeviceProcAddr)vkGetInstanceProcAddr(app->instance, "vkGetDeviceProcAddr"));
    app->vk.GetDeviceQueue(app->device, 0, 0, &app->queue);
}

static void create_ears(struct application *app)
{
    const STRUCT(VkDebugReportCallbackCreateInfoEXT, callback,
                 .flags = VK_DEBUG_REPORT_ERROR_BIT_EXT, .pfnCallback = hear_callback,
                 .pUserData = app);
    GET(app, "vkCreateDebugUtilsMessengerEXT",
        app->instance_vk.CreateDebugUtilsMessengerEXT(app->instance, &app->messenger_info, NULL,
                                                      &app->messenger));
    GET(app, "vkCreateDebugReportCallbackEXT",
        app->instance_vk.CreateDebugReportCallbackEXT(app->instance, &callback, NULL,
                                                      &app->callback));
}

static void destroy_ears(struct application *app)
{
    app->instance_vk.DestroyDebugReportCallbackEXT(app->instance, app->callback, NULL);
    app->instance_vk.DestroyDebugUtilsMessengerEXT(app->instance, app->messenger, NULL);
}

/* ---- objects */

void name_object(struct application *app, VkObjectType type, uint64_t handle, const char *name,
                 unsigned n)
{
    char text[64];
    snprintf(text, sizeof(text), "%s %u", name, n);
    app->vk.SetDebugUtilsObjectNameEXT(app->device,
                                       &MAKE(VkDebugUtilsObjectNameInfoEXT, .objectType = type,
                                             .objectHandle = handle, .pObjectName = text));
}

VkBuffer create_buffer(struct application *app, VkDeviceSize size, VkBufferUsageFlags usage,
                       VkBufferCreateFlags flags)
{
    VkBuffer buffer = VK_NULL_HANDLE;
    const STRUCT(VkBufferCreateInfo, info, .flags = flags, .size = size,
                 .usage = usage | VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT);
    CALL(app, CreateBuffer, app->device, &info, NULL, &buffer);
    return buffer;
}

VkDeviceMemory allocate(struct application *app, VkDeviceSize size, enum memory_type type)
{
    VkDeviceMemory memory = VK_NULL_HANDLE;
    const STRUCT(VkMemoryAllocateFlagsInfo, flags, .flags = VK_MEMORY_ALLOCATE_DEVICE_ADDRESS_BIT);
    const STRUCT(VkMemoryAllocateInfo, info, .pNext = &flags, .allocationSize = size,
                 .memoryTypeIndex = type);
    CALL(app, AllocateMemory, app->device, &info, NULL, &memory);
    return memory;
}

void bind_buffer(struct application *app, VkBuffer buffer, VkDeviceMemory memory,
                 VkDeviceSize offset)
{
    CALL(app, BindBufferMemory, app->device, buffer, memory, offset);
}

VkDeviceAddress address_of(struct application *app, VkBuffer buffer)
{
    const STRUCT(VkBufferDeviceAddressInfo, info, .buffer = buffer);
    return app->vk.GetBufferDeviceAddress(app->device, &info);
}

VkAccelerationStructureKHR create_accel(struct application *app, VkBuffer buffer,
                                        VkDeviceSize offset, VkDeviceSize size,
                                        VkAccelerationStructureTypeKHR type)
{
    VkAccelerationStructureKHR accel = VK_NULL_HANDLE;
    const STRUCT(VkAccelerationStructureCreateInfoKHR, info, .buffer = buffer, .offset = offset,
                 .size = size, .type = type);
    CALL(app, CreateAccelerationStructureKHR, app->device, &info, NULL, &accel);
    return accel;
}

VkMicromapEXT create_micromap(struct application *app, VkBuffer buffer, VkDeviceSize offset,
                              VkDeviceSize size, VkMicromapTypeEXT type)
{
    VkMicromapEXT micromap = VK_NULL_HANDLE;
    const STRUCT(VkMicromapCreateInfoEXT, info, .buffer = buffer, .offset = offset, .size = size,
                 .type = type);
    CALL(app, CreateMicromapEXT, app->device, &info, NULL, &micromap);
    return micromap;
}

VkQueryPool create_queries(struct application *app, VkQueryType type)
{
    VkQueryPool queries = VK_NULL_HANDLE;
    CALL(app, CreateQueryPool, app->device,
         &MAKE(VkQueryPoolCreateInfo, .queryType = type, .queryCount = QUERIES), NULL, &queries);
    return queries;
}

/* ---- commands */

void create_commands(struct application *app, VkCommandPool *pool, VkCommandBuffer *primary,
                     VkCommandBuffer *secondary)
{
    const STRUCT(VkCommandPoolCreateInfo, pool_info,
                 .flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT);
    CALL(app, CreateCommandPool, app->device, &pool_info, NULL, pool);
    STRUCT(VkCommandBufferAllocateInfo, info, .commandPool = *pool,
           .level = VK_COMMAND_BUFFER_LEVEL_PRIMARY, .commandBufferCount = 1);
    CALL(app, AllocateCommandBuffers, app->device, &info, primary);
    info.level = VK_COMMAND_BUFFER_LEVEL_SECONDARY;
    CALL(app, AllocateCommandBuffers, app->device, &info, secondary);
}

VkResult begin_commands(const struct application *app, VkCommandBuffer commands)
{
    const STRUCT(VkCommandBufferBeginInfo, info,
                 .pInheritanceInfo = &MAKE(VkCommandBufferInheritanceInfo));
    return app->vk.BeginCommandBuffer(commands, &info);
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

static bool is_well(const struct application *app)
{
    return !app->outcome->wrong[0];
}

void application_live(struct outcome *outcome)
{
    struct application app = {.outcome = outcome};
    app.messenger_info = MAKE(VkDebugUtilsMessengerCreateInfoEXT,
                              .messageSeverity = VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT |
                                                 VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT,
                              .messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT,
                              .pfnUserCallback = hear_messenger, .pUserData = &app);
    create_instance(&app);
    if (is_well(&app))
        create_device(&app);
    if (is_well(&app)) {
        create_ears(&app);
        create_objects(&app);
        if (is_well(&app))
            record_all(&app);
        destroy_objects(&app);
        app.vk.DestroyDevice(app.device, NULL);
        destroy_ears(&app);
    }
    if (app.instance)
        app.instance_vk.DestroyInstance(app.instance, NULL);
}
