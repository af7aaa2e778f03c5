/* SPDX-License-Identifier: Apache-2.0 */
#include "src/scene/driver.h"

#include <dlfcn.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <vulkan/vk_enum_string_helper.h>

#define LAYER "VK_LAYER_ASSAY_validation"
#define COUNT_OF(array) (sizeof(array) / sizeof((array)[0]))

static bool fail(struct capture_error *error, const char *text)
{
    snprintf(error->text, sizeof(error->text), "%s", text);
    return false;
}

bool driver_fail(struct capture_error *error, const char *call, VkResult result)
{
    snprintf(error->text, sizeof(error->text), "%s returned %s", call, string_VkResult(result));
    return false;
}

/* ---- instance */

static bool create_instance(struct driver *driver, bool layer,
                            const VkDebugUtilsMessengerCreateInfoEXT *messenger,
                            PFN_vkGetInstanceProcAddr get, struct capture_error *error)
{
    static const char *const layers[] = {LAYER};
    static const char *const extensions[] = {VK_EXT_DEBUG_UTILS_EXTENSION_NAME};
    const VkApplicationInfo application = {.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO,
                                           .pApplicationName = "assay-scene",
                                           .apiVersion = VK_API_VERSION_1_2};
    const VkInstanceCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO,
        .pNext = layer ? messenger : NULL,
        .pApplicationInfo = &application,
        .enabledLayerCount = layer,
        .ppEnabledLayerNames = layers,
        .enabledExtensionCount = layer,
        .ppEnabledExtensionNames = extensions,
    };
    PFN_vkCreateInstance create = (PFN_vkCreateInstance)get(VK_NULL_HANDLE, "vkCreateInstance");
    const VkResult result =
        create ? create(&info, NULL, &driver->instance) : VK_ERROR_INITIALIZATION_FAILED;
    if (result == VK_ERROR_INCOMPATIBLE_DRIVER)
        return fail(error,
                    "the Vulkan loader found no driver; Mesa's lavapipe needs no GPU (on "
                    "Debian: mesa-vulkan-drivers)");
    if (result == VK_ERROR_LAYER_NOT_PRESENT)
        return fail(error, "the Vulkan loader found no " LAYER
                           "; VK_LAYER_PATH names the folder "
                           "of its manifest");
    return result == VK_SUCCESS || driver_fail(error, "vkCreateInstance", result);
}

static bool open_instance(struct driver *driver, bool layer,
                          PFN_vkDebugUtilsMessengerCallbackEXT on_message, void *user,
                          struct capture_error *error)
{
    const VkDebugUtilsMessengerCreateInfoEXT messenger = {
        .sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT,
        .messageSeverity = VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT |
                           VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT,
        .messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT |
                       VK_DEBUG_UTILS_MESSAGE_TYPE_PERFORMANCE_BIT_EXT |
                       VK_DEBUG_UTILS_MESSAGE_TYPE_GENERAL_BIT_EXT,
        .pfnUserCallback = on_message,
        .pUserData = user,
    };
    driver->library = dlopen("libvulkan.so.1", RTLD_NOW | RTLD_LOCAL);
    PFN_vkGetInstanceProcAddr get =
        driver->library ? (PFN_vkGetInstanceProcAddr)dlsym(driver->library, "vkGetInstanceProcAddr")
                        : NULL;
    if (!get)
        return fail(error, "no Vulkan loader (libvulkan.so.1) can be opened");
    if (!create_instance(driver, layer, &messenger, get, error))
        return false;
    vkuInitInstanceDispatchTable(driver->instance, &driver->instance_vk, get);
    driver->get_device_command =
        (PFN_vkGetDeviceProcAddr)get(driver->instance, "vkGetDeviceProcAddr");
    if (layer)
        driver->instance_vk.CreateDebugUtilsMessengerEXT(driver->instance, &messenger, NULL,
                                                         &driver->messenger);
    return true;
}

/* ---- device */

static const char *const device_extensions[] = {VK_KHR_ACCELERATION_STRUCTURE_EXTENSION_NAME,
                                                VK_KHR_DEFERRED_HOST_OPERATIONS_EXTENSION_NAME,
                                                VK_KHR_RAY_QUERY_EXTENSION_NAME};

/* The last extension is for tracing. */
static uint32_t extension_count(const struct driver *driver)
{
    return COUNT_OF(device_extensions) - !driver->traces;
}

static bool has_extensions(const struct driver *driver, VkPhysicalDevice physical)
{
    uint32_t count = 0, found = 0;
    driver->instance_vk.EnumerateDeviceExtensionProperties(physical, NULL, &count, NULL);
    VkExtensionProperties *extensions = capture_allocate(NULL, count + 1, sizeof(*extensions));
    driver->instance_vk.EnumerateDeviceExtensionProperties(physical, NULL, &count, extensions);
    for (uint32_t i = 0; i < count; i++)
        for (size_t n = 0; n < extension_count(driver); n++)
            found += strcmp(extensions[i].extensionName, device_extensions[n]) == 0;
    free(extensions);
    return found == extension_count(driver);
}

static bool find_queue(struct driver *driver, VkPhysicalDevice physical)
{
    enum { FAMILIES = 64 };
    VkQueueFamilyProperties families[FAMILIES];
    uint32_t count = FAMILIES;
    driver->instance_vk.GetPhysicalDeviceQueueFamilyProperties(physical, &count, families);
    for (uint32_t i = 0; i < count; i++)
        if (families[i].queueFlags & VK_QUEUE_COMPUTE_BIT) {
            driver->queue_family = i;
            driver->timestamp_bits = families[i].timestampValidBits;
            return true;
        }
    return false;
}

/* The first device that builds acceleration structures. */
static bool find_physical(struct driver *driver, struct capture_error *error)
{
    enum { DEVICES = 64 };
    VkPhysicalDevice devices[DEVICES];
    uint32_t count = DEVICES;
    driver->instance_vk.EnumeratePhysicalDevices(driver->instance, &count, devices);
    for (uint32_t i = 0; i < count; i++) {
        driver->instance_vk.GetPhysicalDeviceProperties(devices[i], &driver->properties);
        if (driver->properties.apiVersion < VK_API_VERSION_1_2 ||
            (driver->wanted && !strstr(driver->properties.deviceName, driver->wanted)) ||
            !has_extensions(driver, devices[i]) || !find_queue(driver, devices[i]))
            continue;
        VkPhysicalDeviceAccelerationStructurePropertiesKHR limits = {
            .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_ACCELERATION_STRUCTURE_PROPERTIES_KHR};
        driver->driver = (VkPhysicalDeviceDriverProperties){
            .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DRIVER_PROPERTIES, .pNext = &limits};
        VkPhysicalDeviceProperties2 properties = {
            .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2, .pNext = &driver->driver};
        driver->physical = devices[i];
        driver->instance_vk.GetPhysicalDeviceProperties2(devices[i], &properties);
        driver->instance_vk.GetPhysicalDeviceMemoryProperties(devices[i], &driver->memory);
        driver->scratch_alignment = limits.minAccelerationStructureScratchOffsetAlignment;
        return true;
    }
    return fail(error,
                driver->wanted
                    ? "no device of that name has Vulkan 1.2 and VK_KHR_acceleration_structure"
                    : "no device has Vulkan 1.2 and VK_KHR_acceleration_structure");
}

static bool create_device(struct driver *driver, struct capture_error *error)
{
    const float priority = 1;
    VkPhysicalDeviceRayQueryFeaturesKHR queries = {
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_RAY_QUERY_FEATURES_KHR, .rayQuery = VK_TRUE};
    VkPhysicalDeviceAccelerationStructureFeaturesKHR structures = {
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_ACCELERATION_STRUCTURE_FEATURES_KHR,
        .pNext = driver->traces ? &queries : NULL,
        .accelerationStructure = VK_TRUE};
    VkPhysicalDeviceVulkan12Features features = {
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES,
        .pNext = &structures,
        .bufferDeviceAddress = VK_TRUE};
    const VkDeviceQueueCreateInfo queue = {.sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO,
                                           .queueFamilyIndex = driver->queue_family,
                                           .queueCount = 1,
                                           .pQueuePriorities = &priority};
    const VkDeviceCreateInfo info = {.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO,
                                     .pNext = &features,
                                     .queueCreateInfoCount = 1,
                                     .pQueueCreateInfos = &queue,
                                     .enabledExtensionCount = extension_count(driver),
                                     .ppEnabledExtensionNames = device_extensions};
    PFN_vkCreateDevice create = (PFN_vkCreateDevice)driver->instance_vk.GetInstanceProcAddr(
        driver->instance, "vkCreateDevice");
    const VkResult result = create(driver->physical, &info, NULL, &driver->device);
    if (result != VK_SUCCESS)
        return driver_fail(error, "vkCreateDevice", result);
    vkuInitDeviceDispatchTable(driver->device, &driver->vk, driver->get_device_command);
    driver->vk.GetDeviceQueue(driver->device, driver->queue_family, 0, &driver->queue);
    return true;
}

static bool create_commands(struct driver *driver, struct capture_error *error)
{
    const VkCommandPoolCreateInfo pool = {.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO,
                                          .flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT,
                                          .queueFamilyIndex = driver->queue_family};
    VkResult result = driver->vk.CreateCommandPool(driver->device, &pool, NULL, &driver->pool);
    if (result != VK_SUCCESS)
        return driver_fail(error, "vkCreateCommandPool", result);
    const VkCommandBufferAllocateInfo info = {.sType =
                                                  VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
                                              .commandPool = driver->pool,
                                              .level = VK_COMMAND_BUFFER_LEVEL_PRIMARY,
                                              .commandBufferCount = 1};
    result = driver->vk.AllocateCommandBuffers(driver->device, &info, &driver->commands);
    if (result != VK_SUCCESS)
        return driver_fail(error, "vkAllocateCommandBuffers", result);
    const VkQueryPoolCreateInfo times = {.sType = VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO,
                                         .queryType = VK_QUERY_TYPE_TIMESTAMP,
                                         .queryCount = 2};
    if (driver->timestamp_bits)
        driver->vk.CreateQueryPool(driver->device, &times, NULL, &driver->times);
    return true;
}

bool driver_open(struct driver *driver, bool layer, PFN_vkDebugUtilsMessengerCallbackEXT on_message,
                 void *user, struct capture_error *error)
{
    *driver = (struct driver){0};
    return open_instance(driver, layer, on_message, user, error) && find_physical(driver, error) &&
           create_device(driver, error) && create_commands(driver, error);
}

bool driver_open_to_trace(struct driver *driver, const char *name, struct capture_error *error)
{
    *driver = (struct driver){.traces = true, .wanted = name};
    if (!open_instance(driver, false, NULL, NULL, error))
        return false;
    driver->traces = find_physical(driver, error);
    return (driver->traces || find_physical(driver, error)) && create_device(driver, error) &&
           create_commands(driver, error);
}

void driver_close(struct driver *driver)
{
    if (driver->device) {
        driver->vk.DestroyQueryPool(driver->device, driver->times, NULL);
        driver->vk.DestroyCommandPool(driver->device, driver->pool, NULL);
        driver->vk.DestroyDevice(driver->device, NULL);
    }
    if (driver->messenger)
        driver->instance_vk.DestroyDebugUtilsMessengerEXT(driver->instance, driver->messenger,
                                                          NULL);
    if (driver->instance)
        driver->instance_vk.DestroyInstance(driver->instance, NULL);
    if (driver->library)
        dlclose(driver->library);
}

/* ---- memory and buffers */

/* The mapped type that is fastest for the device. Returns UINT32_MAX if there is none. */
static uint32_t find_memory_type(const struct driver *driver, uint32_t types)
{
    const VkMemoryPropertyFlags mapped =
        VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
    const VkMemoryPropertyFlags wanted[] = {mapped | VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT, mapped};
    for (size_t n = 0; n < COUNT_OF(wanted); n++)
        for (uint32_t i = 0; i < driver->memory.memoryTypeCount; i++)
            if (types & 1u << i &&
                (driver->memory.memoryTypes[i].propertyFlags & wanted[n]) == wanted[n])
                return i;
    return UINT32_MAX;
}

bool driver_allocate(struct driver *driver, VkDeviceSize size, uint32_t types,
                     struct driver_memory *memory, struct capture_error *error)
{
    const VkMemoryAllocateFlagsInfo flags = {.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_FLAGS_INFO,
                                             .flags = VK_MEMORY_ALLOCATE_DEVICE_ADDRESS_BIT};
    const VkMemoryAllocateInfo info = {.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO,
                                       .pNext = &flags,
                                       .allocationSize = size,
                                       .memoryTypeIndex = find_memory_type(driver, types)};
    void *bytes = NULL;
    *memory = (struct driver_memory){0};
    if (info.memoryTypeIndex == UINT32_MAX)
        return fail(error, "the device has no memory for buffers that the host can map");
    VkResult result = driver->vk.AllocateMemory(driver->device, &info, NULL, &memory->handle);
    if (result != VK_SUCCESS)
        return driver_fail(error, "vkAllocateMemory", result);
    result = driver->vk.MapMemory(driver->device, memory->handle, 0, VK_WHOLE_SIZE, 0, &bytes);
    memory->bytes = bytes;
    return result == VK_SUCCESS || driver_fail(error, "vkMapMemory", result);
}

void driver_free(struct driver *driver, struct driver_memory *memory)
{
    driver->vk.FreeMemory(driver->device, memory->handle, NULL);
    *memory = (struct driver_memory){0};
}

VkDeviceAddress driver_buffer_address(const struct driver *driver, VkBuffer buffer)
{
    return driver->vk.GetBufferDeviceAddress(
        driver->device,
        &(VkBufferDeviceAddressInfo){.sType = VK_STRUCTURE_TYPE_BUFFER_DEVICE_ADDRESS_INFO,
                                     .buffer = buffer});
}

bool driver_make_buffer(struct driver *driver, VkDeviceSize size, VkBufferUsageFlags usage,
                        struct driver_buffer *buffer, struct capture_error *error)
{
    const VkBufferCreateInfo info = {.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO,
                                     .size = size,
                                     .usage = usage | VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT};
    VkMemoryRequirements requirements;
    *buffer = (struct driver_buffer){.size = size};
    VkResult result = driver->vk.CreateBuffer(driver->device, &info, NULL, &buffer->handle);
    if (result != VK_SUCCESS)
        return driver_fail(error, "vkCreateBuffer", result);
    driver->vk.GetBufferMemoryRequirements(driver->device, buffer->handle, &requirements);
    if (!driver_allocate(driver, requirements.size, requirements.memoryTypeBits, &buffer->memory,
                         error))
        return false;
    result = driver->vk.BindBufferMemory(driver->device, buffer->handle, buffer->memory.handle, 0);
    if (result != VK_SUCCESS)
        return driver_fail(error, "vkBindBufferMemory", result);
    buffer->address = driver_buffer_address(driver, buffer->handle);
    return true;
}

void driver_destroy_buffer(struct driver *driver, struct driver_buffer *buffer)
{
    driver->vk.DestroyBuffer(driver->device, buffer->handle, NULL);
    driver_free(driver, &buffer->memory);
    *buffer = (struct driver_buffer){0};
}

/* ---- commands */

bool driver_begin(struct driver *driver, struct capture_error *error)
{
    const VkCommandBufferBeginInfo info = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO,
                                           .flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT};
    const VkResult result = driver->vk.BeginCommandBuffer(driver->commands, &info);
    return result == VK_SUCCESS || driver_fail(error, "vkBeginCommandBuffer", result);
}

bool driver_run(struct driver *driver, struct capture_error *error)
{
    const VkSubmitInfo info = {.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO,
                               .commandBufferCount = 1,
                               .pCommandBuffers = &driver->commands};
    VkResult result = driver->vk.EndCommandBuffer(driver->commands);
    if (result != VK_SUCCESS)
        return driver_fail(error, "vkEndCommandBuffer", result);
    result = driver->vk.QueueSubmit(driver->queue, 1, &info, VK_NULL_HANDLE);
    if (result != VK_SUCCESS)
        return driver_fail(error, "vkQueueSubmit", result);
    result = driver->vk.QueueWaitIdle(driver->queue);
    return result == VK_SUCCESS || driver_fail(error, "vkQueueWaitIdle", result);
}

void driver_order_all(const struct driver *driver)
{
    const VkMemoryBarrier barrier = {.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER,
                                     .srcAccessMask = VK_ACCESS_MEMORY_WRITE_BIT,
                                     .dstAccessMask =
                                         VK_ACCESS_MEMORY_READ_BIT | VK_ACCESS_MEMORY_WRITE_BIT};
    driver->vk.CmdPipelineBarrier(driver->commands, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT,
                                  VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, 0, 1, &barrier, 0, NULL, 0,
                                  NULL);
}

/* ---- time */

void driver_begin_time(const struct driver *driver)
{
    if (!driver->times)
        return;
    driver->vk.CmdResetQueryPool(driver->commands, driver->times, 0, 2);
    driver->vk.CmdWriteTimestamp(driver->commands, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT,
                                 driver->times, 0);
}

void driver_end_time(const struct driver *driver)
{
    if (driver->times)
        driver->vk.CmdWriteTimestamp(driver->commands, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT,
                                     driver->times, 1);
}

double driver_read_time(const struct driver *driver)
{
    uint64_t ticks[2] = {0};
    if (!driver->times ||
        driver->vk.GetQueryPoolResults(driver->device, driver->times, 0, 2, sizeof(ticks), ticks,
                                       sizeof(ticks[0]), VK_QUERY_RESULT_64_BIT) != VK_SUCCESS)
        return (double)NAN;
    const uint64_t mask =
        driver->timestamp_bits < 64 ? (UINT64_C(1) << driver->timestamp_bits) - 1 : UINT64_MAX;
    return (double)((ticks[1] - ticks[0]) & mask) *
           (double)driver->properties.limits.timestampPeriod;
}
