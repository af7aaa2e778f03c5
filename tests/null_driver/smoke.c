/* SPDX-License-Identifier: Apache-2.0 */
/* The smoke test's fixture, made through the installed loader. */
#include "smoke.h"

PFN_vkVoidFunction vkGetInstanceProcAddr(VkInstance instance, const char *pName); /* the loader's */

struct null_driver_api driver;

void make_instance(struct fixture *f)
{
    PFN_vkCreateInstance create =
        (PFN_vkCreateInstance)vkGetInstanceProcAddr(NULL, "vkCreateInstance");
    const VkApplicationInfo application = MAKE(VkApplicationInfo, .apiVersion = VK_API_VERSION_1_3);
    static const char *const extensions[] = {VK_EXT_DEBUG_UTILS_EXTENSION_NAME};
    const VkInstanceCreateInfo info =
        MAKE(VkInstanceCreateInfo, .enabledExtensionCount = 1,
             .ppEnabledExtensionNames = extensions, .pApplicationInfo = &application);
    uint32_t count = NULL_DRIVER_MAX_PHYSICAL_DEVICES;
    CHECK(create(&info, NULL, &f->instance));
    vkuInitInstanceDispatchTable(f->instance, &f->vki, vkGetInstanceProcAddr);
    CHECK(f->vki.EnumeratePhysicalDevices(f->instance, &count, f->physical));
}

VkResult make_device(struct fixture *f, const void *pNext)
{
    static const char *const extensions[] = {VK_KHR_ACCELERATION_STRUCTURE_EXTENSION_NAME,
                                             VK_KHR_DEFERRED_HOST_OPERATIONS_EXTENSION_NAME,
                                             VK_NV_RAY_TRACING_EXTENSION_NAME,
                                             VK_EXT_OPACITY_MICROMAP_EXTENSION_NAME,
                                             VK_KHR_DEVICE_ADDRESS_COMMANDS_EXTENSION_NAME,
                                             VK_KHR_VIDEO_QUEUE_EXTENSION_NAME};
    const float priorities[] = {1, 1};
    const VkDeviceQueueCreateInfo queues =
        MAKE(VkDeviceQueueCreateInfo, .queueCount = 2, .pQueuePriorities = priorities);
    const VkDeviceCreateInfo info = MAKE(
        VkDeviceCreateInfo, .pNext = pNext, .queueCreateInfoCount = 1, .pQueueCreateInfos = &queues,
        .enabledExtensionCount = COUNT_OF(extensions), .ppEnabledExtensionNames = extensions);
    PFN_vkCreateDevice create =
        (PFN_vkCreateDevice)vkGetInstanceProcAddr(f->instance, "vkCreateDevice");
    PFN_vkGetDeviceProcAddr get_address =
        (PFN_vkGetDeviceProcAddr)vkGetInstanceProcAddr(f->instance, "vkGetDeviceProcAddr");
    const VkResult result = create(f->physical[0], &info, NULL, &f->device);
    if (result != VK_SUCCESS)
        return result;
    vkuInitDeviceDispatchTable(f->device, &f->vk, get_address);
    f->vk.GetDeviceQueue(f->device, 0, 1, &f->queue);
    assert_non_null(f->queue);
    return VK_SUCCESS;
}

static void destroy(struct fixture *f)
{
    if (f->device != VK_NULL_HANDLE)
        f->vk.DestroyDevice(f->device, NULL);
    f->vki.DestroyInstance(f->instance, NULL);
}

int set_up(void **state)
{
    static struct fixture fixture;
    memset(&fixture, 0, sizeof(fixture));
    driver.reset();
    driver.configure(NULL);
    *state = &fixture;
    return 0;
}

/* An instance and a device of the default configuration. */
int set_up_device(void **state)
{
    set_up(state);
    make_instance(*state);
    VkPhysicalDeviceAccelerationStructureFeaturesKHR features =
        MAKE(VkPhysicalDeviceAccelerationStructureFeaturesKHR, .accelerationStructure = VK_TRUE,
             .accelerationStructureHostCommands = VK_TRUE);
    CHECK(make_device(*state, &MAKE(VkPhysicalDeviceBufferDeviceAddressFeatures, .pNext = &features,
                                    .bufferDeviceAddress = VK_TRUE)));
    return 0;
}

int tear_down(void **state)
{
    destroy(*state);
    return 0;
}

VkBuffer make_buffer(struct fixture *f, VkBufferCreateFlags flags, VkDeviceSize size)
{
    const VkBufferCreateInfo info =
        MAKE(VkBufferCreateInfo, .flags = flags, .size = size,
             .usage = VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT |
                      VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_STORAGE_BIT_KHR);
    VkBuffer buffer;
    CHECK(f->vk.CreateBuffer(f->device, &info, NULL, &buffer));
    return buffer;
}

VkDeviceMemory make_memory(struct fixture *f, uint32_t type, VkDeviceSize size)
{
    const VkMemoryAllocateInfo info =
        MAKE(VkMemoryAllocateInfo, .allocationSize = size, .memoryTypeIndex = type);
    VkDeviceMemory memory;
    CHECK(f->vk.AllocateMemory(f->device, &info, NULL, &memory));
    return memory;
}

VkDeviceAddress address_of(struct fixture *f, VkBuffer buffer)
{
    const VkBufferDeviceAddressInfo info = MAKE(VkBufferDeviceAddressInfo, .buffer = buffer);
    return f->vk.GetBufferDeviceAddress(f->device, &info);
}

VkCommandPool make_pool(struct fixture *f)
{
    VkCommandPool pool;
    CHECK(f->vk.CreateCommandPool(f->device, &MAKE(VkCommandPoolCreateInfo), NULL, &pool));
    return pool;
}

VkCommandBuffer make_command_buffer(struct fixture *f, VkCommandPool pool)
{
    const VkCommandBufferAllocateInfo info =
        MAKE(VkCommandBufferAllocateInfo, .commandPool = pool, .commandBufferCount = 1);
    VkCommandBuffer commands;
    CHECK(f->vk.AllocateCommandBuffers(f->device, &info, &commands));
    return commands;
}
