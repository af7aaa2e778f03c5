/* SPDX-License-Identifier: Apache-2.0 */
/* The smoke test's fixture, made through the installed loader. */
#include "smoke.h"

PFN_vkVoidFunction vkGetInstanceProcAddr(VkInstance instance, const char *pName); /* the loader's */

struct null_driver_api driver;
VkuInstanceDispatchTable vki;
VkuDeviceDispatchTable vk;
VkPhysicalDevice physical[NULL_DRIVER_MAX_PHYSICAL_DEVICES];
VkInstance instance;
VkDevice device;
VkQueue queue;

static void *library;

const char *unit_test_open(const char *argument)
{
    library = null_driver_load(NULL_DRIVER_LIBRARY, &driver);
    return library ? NULL : dlerror();
}

void unit_test_close(void)
{
    dlclose(library);
}

void make_instance(void)
{
    PFN_vkCreateInstance create =
        (PFN_vkCreateInstance)vkGetInstanceProcAddr(NULL, "vkCreateInstance");
    const STRUCT(VkApplicationInfo, application, .apiVersion = VK_API_VERSION_1_3);
    static const char *const extensions[] = {VK_EXT_DEBUG_UTILS_EXTENSION_NAME};
    const STRUCT(VkInstanceCreateInfo, info, .enabledExtensionCount = 1,
                 .ppEnabledExtensionNames = extensions, .pApplicationInfo = &application);
    uint32_t count = NULL_DRIVER_MAX_PHYSICAL_DEVICES;
    GET(create(&info, NULL, &instance));
    vkuInitInstanceDispatchTable(instance, &vki, vkGetInstanceProcAddr);
    GET(vki.EnumeratePhysicalDevices(instance, &count, physical));
}

VkResult make_device(const void *pNext)
{
    static const char *const extensions[] = {VK_KHR_ACCELERATION_STRUCTURE_EXTENSION_NAME,
                                             VK_KHR_DEFERRED_HOST_OPERATIONS_EXTENSION_NAME,
                                             VK_NV_RAY_TRACING_EXTENSION_NAME,
                                             VK_EXT_OPACITY_MICROMAP_EXTENSION_NAME,
                                             VK_KHR_DEVICE_ADDRESS_COMMANDS_EXTENSION_NAME,
                                             VK_KHR_VIDEO_QUEUE_EXTENSION_NAME};
    const float priorities[] = {1, 1};
    const STRUCT(VkDeviceQueueCreateInfo, queues, .queueCount = 2, .pQueuePriorities = priorities);
    const STRUCT(VkDeviceCreateInfo, info, .pNext = pNext, .queueCreateInfoCount = 1,
                 .pQueueCreateInfos = &queues, .enabledExtensionCount = ARRAY_COUNT(extensions),
                 .ppEnabledExtensionNames = extensions);
    PFN_vkCreateDevice create =
        (PFN_vkCreateDevice)vkGetInstanceProcAddr(instance, "vkCreateDevice");
    PFN_vkGetDeviceProcAddr get_address =
        (PFN_vkGetDeviceProcAddr)vkGetInstanceProcAddr(instance, "vkGetDeviceProcAddr");
    const VkResult result = create(physical[0], &info, NULL, &device);
    if (result != VK_SUCCESS)
        return result;
    vkuInitDeviceDispatchTable(device, &vk, get_address);
    vk.GetDeviceQueue(device, 0, 1, &queue);
    assert_non_null(queue);
    return VK_SUCCESS;
}

void tear_down(void)
{
    if (device != VK_NULL_HANDLE)
        vk.DestroyDevice(device, NULL);
    vki.DestroyInstance(instance, NULL);
}

void set_up(void)
{
    device = VK_NULL_HANDLE;
    driver.reset();
    driver.configure(NULL);
}

void set_up_device(void)
{
    set_up();
    make_instance();
    STRUCT(VkPhysicalDeviceAccelerationStructureFeaturesKHR, features,
           .accelerationStructure = VK_TRUE, .accelerationStructureHostCommands = VK_TRUE);
    GET(make_device(&MAKE(VkPhysicalDeviceBufferDeviceAddressFeatures, .pNext = &features,
                          .bufferDeviceAddress = VK_TRUE)));
}

VkBuffer make_buffer(VkBufferCreateFlags flags, VkDeviceSize size)
{
    const STRUCT(VkBufferCreateInfo, info, .flags = flags, .size = size,
                 .usage = VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT |
                          VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_STORAGE_BIT_KHR);
    VkBuffer buffer;
    GET(vk.CreateBuffer(device, &info, NULL, &buffer));
    return buffer;
}

VkDeviceMemory make_memory(uint32_t type, VkDeviceSize size)
{
    return memory_create(&vk, device, type, size);
}

VkBuffer make_bound_buffer(VkDeviceSize size, uint32_t type, void **mapped)
{
    const VkBuffer buffer = make_buffer(0, size);
    const VkDeviceMemory memory = make_memory(type, size);
    GET(vk.BindBufferMemory(device, buffer, memory, 0));
    if (mapped != NULL)
        GET(vk.MapMemory(device, memory, 0, VK_WHOLE_SIZE, 0, mapped));
    return buffer;
}

VkDeviceAddress address_of(VkBuffer buffer)
{
    return buffer_address(&vk, device, buffer);
}

VkCommandBuffer make_command_buffer(VkCommandPool pool)
{
    return commands_begin(&vk, device, pool, VK_COMMAND_BUFFER_LEVEL_PRIMARY, 0, NULL);
}
