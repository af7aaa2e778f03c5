/* SPDX-License-Identifier: Apache-2.0 */
/* What the loader does above the layer. tests/fuzz/calls/driver.c does the rest below. */
#include "linked.h"

#include <string.h>
#include <vulkan/vk_layer.h>

#include "tests/fixture/scarce_memory.h"
#include "tests/fuzz/calls/calls.h"

VKAPI_ATTR VkResult VKAPI_CALL
vkNegotiateLoaderLayerInterfaceVersion(VkNegotiateLayerInterface *pVersionStruct);

static VkNegotiateLayerInterface layer = {.sType = LAYER_NEGOTIATE_INTERFACE_STRUCT,
                                          .loaderLayerInterfaceVersion = 2};
static VkInstance current;

/* ---- allocations of the driver do not fail */

void *__real_driver_allocate(void *old, size_t size);
void *__wrap_driver_allocate(void *old, size_t size);

void *__wrap_driver_allocate(void *old, size_t size)
{
    const int before = memory_pause();
    void *block = __real_driver_allocate(old, size);
    memory_resume(before);
    return block;
}

static void fail_allocations(int after, bool for_good)
{
    if (after < 0)
        memory_fail_no_more();
    else if (for_good)
        memory_fail_from(after);
    else
        memory_fail_after(after);
}

/* ---- the loader */

static VKAPI_ATTR VkResult VKAPI_CALL create_instance(const VkInstanceCreateInfo *info,
                                                      const VkAllocationCallbacks *allocator,
                                                      VkInstance *instance)
{
    VkLayerInstanceLink below = {.pfnNextGetInstanceProcAddr = calls_driver_proc_addr};
    const VkLayerInstanceCreateInfo link = {.sType = VK_STRUCTURE_TYPE_LOADER_INSTANCE_CREATE_INFO,
                                            .pNext = info->pNext,
                                            .function = VK_LAYER_LINK_INFO,
                                            .u.pLayerInfo = &below};
    VkInstanceCreateInfo linked = *info;
    linked.pNext = &link;
    const PFN_vkCreateInstance create =
        (PFN_vkCreateInstance)layer.pfnGetInstanceProcAddr(NULL, "vkCreateInstance");
    const VkResult result = create(&linked, allocator, instance);
    current = *instance;
    return result;
}

static VKAPI_ATTR VkResult VKAPI_CALL create_device(VkPhysicalDevice physical,
                                                    const VkDeviceCreateInfo *info,
                                                    const VkAllocationCallbacks *allocator,
                                                    VkDevice *device)
{
    VkLayerDeviceLink below = {.pfnNextGetInstanceProcAddr = calls_driver_proc_addr,
                               .pfnNextGetDeviceProcAddr = calls_driver_device_proc_addr};
    const VkLayerDeviceCreateInfo callback = {.sType = VK_STRUCTURE_TYPE_LOADER_DEVICE_CREATE_INFO,
                                              .pNext = info->pNext,
                                              .function = VK_LOADER_DATA_CALLBACK,
                                              .u.pfnSetDeviceLoaderData = calls_set_loader_data};
    const VkLayerDeviceCreateInfo link = {.sType = VK_STRUCTURE_TYPE_LOADER_DEVICE_CREATE_INFO,
                                          .pNext = &callback,
                                          .function = VK_LAYER_LINK_INFO,
                                          .u.pLayerInfo = &below};
    VkDeviceCreateInfo linked = *info;
    linked.pNext = &link;
    const PFN_vkCreateDevice create =
        (PFN_vkCreateDevice)layer.pfnGetInstanceProcAddr(current, "vkCreateDevice");
    return create(physical, &linked, allocator, device);
}

static VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL find(VkInstance instance, const char *name)
{
    if (strcmp(name, "vkCreateInstance") == 0)
        return (PFN_vkVoidFunction)create_instance;
    if (strcmp(name, "vkCreateDevice") == 0)
        return (PFN_vkVoidFunction)create_device;
    if (strcmp(name, "vkGetDeviceProcAddr") == 0)
        return (PFN_vkVoidFunction)layer.pfnGetDeviceProcAddr;
    return layer.pfnGetInstanceProcAddr(instance, name);
}

struct platform linked_platform(bool is_cpu)
{
    vkNegotiateLoaderLayerInterfaceVersion(&layer);
    calls_configure_driver(is_cpu, true, true, 1);
    return (struct platform){
        .name = is_cpu ? "cpu_null" : "null",
        .is_null = true,
        .is_cpu = is_cpu,
        .null_driver = {.default_config = null_driver_default_config,
                        .configure = null_driver_configure,
                        .fail_next = null_driver_fail_next,
                        .fail_at = null_driver_fail_at,
                        .set_device_lost = null_driver_set_device_lost,
                        .set_executes_nothing = null_driver_set_executes_nothing,
                        .plan_fault = null_driver_plan_fault,
                        .end_hang = null_driver_end_hang,
                        .calls = null_driver_calls,
                        .reset = null_driver_reset},
        .get_instance_proc_addr = find,
        .fail_allocations = fail_allocations,
    };
}
