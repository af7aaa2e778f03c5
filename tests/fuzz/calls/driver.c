/* SPDX-License-Identifier: Apache-2.0 */
/* The null driver as a layer sees it: what the loader does to dispatchable handles is done here. */
#include "../../null_driver/internal.h"
#include "calls.h"

/* The driver's own command, which can be made to fail. */
#define DRIVER(name) ((PFN_vk##name)entry_find("vk" #name))

/* What handles of an instance begin with, and those of a device. */
static const int instance_key, device_key;

static void set_key(void *handle, const int *key)
{
    if (handle)
        *(const void **)handle = key;
}

static VKAPI_ATTR VkResult VKAPI_CALL create_instance(const VkInstanceCreateInfo *info,
                                                      const VkAllocationCallbacks *allocator,
                                                      VkInstance *instance)
{
    VkResult result = DRIVER(CreateInstance)(info, allocator, instance);
    if (result == VK_SUCCESS)
        set_key(*instance, &instance_key);
    return result;
}

static VKAPI_ATTR VkResult VKAPI_CALL enumerate_devices(VkInstance instance, uint32_t *count,
                                                        VkPhysicalDevice *devices)
{
    VkResult result = DRIVER(EnumeratePhysicalDevices)(instance, count, devices);
    for (uint32_t i = 0; devices && i < *count; i++)
        set_key(devices[i], &instance_key);
    return result;
}

static VKAPI_ATTR VkResult VKAPI_CALL create_device(VkPhysicalDevice physical,
                                                    const VkDeviceCreateInfo *info,
                                                    const VkAllocationCallbacks *allocator,
                                                    VkDevice *device)
{
    VkResult result = DRIVER(CreateDevice)(physical, info, allocator, device);
    if (result == VK_SUCCESS)
        set_key(*device, &device_key);
    return result;
}

static VKAPI_ATTR void VKAPI_CALL get_queue(VkDevice device, uint32_t family, uint32_t index,
                                            VkQueue *queue)
{
    DRIVER(GetDeviceQueue)(device, family, index, queue);
    set_key(*queue, &device_key);
}

static VKAPI_ATTR void VKAPI_CALL get_queue_2(VkDevice device, const VkDeviceQueueInfo2 *info,
                                              VkQueue *queue)
{
    DRIVER(GetDeviceQueue2)(device, info, queue);
    set_key(*queue, &device_key);
}

static VKAPI_ATTR VkResult VKAPI_CALL allocate_commands(VkDevice device,
                                                        const VkCommandBufferAllocateInfo *info,
                                                        VkCommandBuffer *buffers)
{
    VkResult result = DRIVER(AllocateCommandBuffers)(device, info, buffers);
    for (uint32_t i = 0; result == VK_SUCCESS && i < info->commandBufferCount; i++)
        set_key(buffers[i], &device_key);
    return result;
}

static PFN_vkVoidFunction find_command(VkDevice device, const char *name)
{
    if (strcmp(name, "vkGetDeviceQueue") == 0)
        return (PFN_vkVoidFunction)get_queue;
    if (strcmp(name, "vkGetDeviceQueue2") == 0)
        return (PFN_vkVoidFunction)get_queue_2;
    if (strcmp(name, "vkAllocateCommandBuffers") == 0)
        return (PFN_vkVoidFunction)allocate_commands;
    return DRIVER(GetDeviceProcAddr)(device, name);
}

/* The layer asks for all commands at each device's creation, by names that are constants, so that
 * their addresses tell them apart. Extensions differ by backend alone. */
enum { NAME_BITS = 13 };
static struct known_command {
    const char *name;
    PFN_vkVoidFunction function;
} known_commands[2][1 << NAME_BITS];
static bool is_cpu;

PFN_vkVoidFunction calls_driver_device_proc_addr(VkDevice device, const char *name)
{
    uint64_t hash = (uint64_t)(uintptr_t)name * 0x9e3779b97f4a7c15u;
    struct known_command *known = &known_commands[is_cpu][hash >> (64 - NAME_BITS)];
    if (known->name != name)
        *known = (struct known_command){name, find_command(device, name)};
    return known->function;
}

PFN_vkVoidFunction calls_driver_proc_addr(VkInstance instance, const char *name)
{
    if (strcmp(name, "vkCreateInstance") == 0)
        return (PFN_vkVoidFunction)create_instance;
    if (strcmp(name, "vkEnumeratePhysicalDevices") == 0)
        return (PFN_vkVoidFunction)enumerate_devices;
    if (strcmp(name, "vkCreateDevice") == 0)
        return (PFN_vkVoidFunction)create_device;
    return DRIVER(GetInstanceProcAddr)(instance, name);
}

VkResult calls_set_loader_data(VkDevice device, void *object)
{
    set_key(object, &device_key);
    return VK_SUCCESS;
}

/* Where the host has nothing, not even the memory of a sanitizer. */
#define FIRST_ADDRESS ((VkDeviceAddress)1 << 56)

void calls_configure_driver(bool is_below_cpu, bool recycles_handles, bool recycles_addresses,
                            uint32_t joins)
{
    struct null_driver_config config = null_driver_default_config();
    is_cpu = is_below_cpu;
    config.physical_device_count = 1;
    config.recycle_handles = recycles_handles;
    config.recycle_addresses = recycles_addresses;
    config.deferred_joins = joins;
    null_driver_configure(&config);
    null_driver_reset();
    address_start_over(FIRST_ADDRESS);
}

/* Slots of dispatchable objects are used again, however the driver treats them otherwise, as there
 * are streams without end. */
void calls_recycle_all(VkInstance instance)
{
    OBJECT(instance)->instance_config->recycle_handles = true;
}

void call_lose_device(struct calls *calls)
{
    null_driver_set_device_lost(take(calls) % 2 == 0);
}

/* One of the next calls of the application's, or of the layer's own, fails below. */
void call_fail_next(struct calls *calls)
{
    static const char *const names[] = {
        "vkCreateBuffer",       "vkAllocateMemory",
        "vkBindBufferMemory",   "vkMapMemory",
        "vkCreateFence",        "vkQueueSubmit",
        "vkQueueSubmit2",       "vkCreateComputePipelines",
        "vkCreateShaderModule", "vkCreatePipelineLayout",
        "vkBeginCommandBuffer", "vkEndCommandBuffer",
        "vkResetCommandBuffer", "vkAllocateCommandBuffers",
        "vkCreateCommandPool",  "vkCreateAccelerationStructureKHR",
        "vkWaitForFences",      "vkBuildAccelerationStructuresKHR",
        "vkGetFenceStatus",     "vkResetFences",
    };
    const char *name = TAKE(calls, names);
    const uint8_t how = take(calls);
    const bool can_time_out = strcmp(name, "vkWaitForFences") == 0;
    VkResult result = VK_ERROR_OUT_OF_HOST_MEMORY;
    if (how % 2)
        result = VK_ERROR_DEVICE_LOST;
    else if (how & 2)
        result = can_time_out ? VK_TIMEOUT : VK_ERROR_OUT_OF_DEVICE_MEMORY;
    null_driver_fail_at(name, 1 + how / 4 % 8, result);
}
