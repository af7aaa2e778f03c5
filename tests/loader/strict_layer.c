/* SPDX-License-Identifier: Apache-2.0 */
/* A layer for tests. It asks the next layer for vkCreateDevice without an instance, as old layers
 * do, and counts calls of commands that the application itself may not call: its version and the
 * extensions that it enables don't have them. One instance with one device at a time. */
#include <string.h>
#include <vulkan/utility/vk_dispatch_table.h>
#include <vulkan/vk_layer.h>
#include <vulkan/vulkan.h>

#include "strict_layer.h"

static struct {
    uint32_t api_version;
    bool has_properties2; /* VK_KHR_get_physical_device_properties2 */
    VkuInstanceDispatchTable next;
    PFN_vkGetDeviceProcAddr next_of_device;
    PFN_vkGetBufferDeviceAddress next_address;
    bool has_core_address; /* the device has vkGetBufferDeviceAddress without an extension */
    unsigned violations;
} layer;

unsigned strict_layer_violations(void)
{
    return layer.violations;
}

static uint32_t usable_version(VkPhysicalDevice physical_device)
{
    VkPhysicalDeviceProperties properties;
    layer.next.GetPhysicalDeviceProperties(physical_device, &properties);
    return properties.apiVersion < layer.api_version ? properties.apiVersion : layer.api_version;
}

/* ---- commands of Vulkan 1.1, and of the extension that it took them from */

#define QUERY(name, parameters, arguments)                                                         \
    static VKAPI_ATTR void VKAPI_CALL strict_##name parameters                                     \
    {                                                                                              \
        layer.violations += usable_version(device) < VK_API_VERSION_1_1;                           \
        layer.next.name arguments;                                                                 \
    }                                                                                              \
    static VKAPI_ATTR void VKAPI_CALL strict_##name##KHR parameters                                \
    {                                                                                              \
        layer.violations += !layer.has_properties2;                                                \
        layer.next.name##KHR arguments;                                                            \
    }

QUERY(GetPhysicalDeviceFeatures2, (VkPhysicalDevice device, VkPhysicalDeviceFeatures2 *out),
      (device, out))
QUERY(GetPhysicalDeviceProperties2, (VkPhysicalDevice device, VkPhysicalDeviceProperties2 *out),
      (device, out))
QUERY(GetPhysicalDeviceMemoryProperties2,
      (VkPhysicalDevice device, VkPhysicalDeviceMemoryProperties2 *out), (device, out))
QUERY(GetPhysicalDeviceFormatProperties2,
      (VkPhysicalDevice device, VkFormat format, VkFormatProperties2 *out), (device, format, out))

static VKAPI_ATTR VkDeviceAddress VKAPI_CALL
strict_GetBufferDeviceAddress(VkDevice device, const VkBufferDeviceAddressInfo *info)
{
    layer.violations += !layer.has_core_address;
    return layer.next_address(device, info);
}

/* ---- creation */

static const void *find_link(const void *chain, VkStructureType type)
{
    for (const VkLayerInstanceCreateInfo *info = chain; info; info = info->pNext)
        if (info->sType == type && info->function == VK_LAYER_LINK_INFO)
            return info;
    return NULL;
}

static VKAPI_ATTR VkResult VKAPI_CALL strict_CreateInstance(const VkInstanceCreateInfo *info,
                                                            const VkAllocationCallbacks *allocator,
                                                            VkInstance *instance)
{
    VkLayerInstanceCreateInfo *link = (VkLayerInstanceCreateInfo *)find_link(
        info->pNext, VK_STRUCTURE_TYPE_LOADER_INSTANCE_CREATE_INFO);
    const VkApplicationInfo *application = info->pApplicationInfo;
    memset(&layer, 0, sizeof(layer));
    layer.api_version =
        application && application->apiVersion ? application->apiVersion : VK_API_VERSION_1_0;
    for (uint32_t i = 0; i < info->enabledExtensionCount; i++)
        layer.has_properties2 |=
            strcmp(info->ppEnabledExtensionNames[i],
                   VK_KHR_GET_PHYSICAL_DEVICE_PROPERTIES_2_EXTENSION_NAME) == 0;
    const PFN_vkGetInstanceProcAddr next = link->u.pLayerInfo->pfnNextGetInstanceProcAddr;
    link->u.pLayerInfo = link->u.pLayerInfo->pNext;
    const VkResult result =
        ((PFN_vkCreateInstance)next(NULL, "vkCreateInstance"))(info, allocator, instance);
    if (result == VK_SUCCESS)
        vkuInitInstanceDispatchTable(*instance, &layer.next, next);
    return result;
}

static VKAPI_ATTR VkResult VKAPI_CALL strict_CreateDevice(VkPhysicalDevice physical_device,
                                                          const VkDeviceCreateInfo *info,
                                                          const VkAllocationCallbacks *allocator,
                                                          VkDevice *device)
{
    VkLayerDeviceCreateInfo *link = (VkLayerDeviceCreateInfo *)find_link(
        info->pNext, VK_STRUCTURE_TYPE_LOADER_DEVICE_CREATE_INFO);
    const PFN_vkCreateDevice create =
        (PFN_vkCreateDevice)link->u.pLayerInfo->pfnNextGetInstanceProcAddr(NULL, "vkCreateDevice");
    if (!create)
        return VK_ERROR_INITIALIZATION_FAILED;
    layer.next_of_device = link->u.pLayerInfo->pfnNextGetDeviceProcAddr;
    layer.has_core_address = usable_version(physical_device) >= VK_API_VERSION_1_2;
    link->u.pLayerInfo = link->u.pLayerInfo->pNext;
    const VkResult result = create(physical_device, info, allocator, device);
    if (result == VK_SUCCESS)
        layer.next_address =
            (PFN_vkGetBufferDeviceAddress)layer.next_of_device(*device, "vkGetBufferDeviceAddress");
    return result;
}

/* ---- by name */

#define NAMED(name)                                                                                \
    {                                                                                              \
        "vk" #name, (PFN_vkVoidFunction)strict_##name                                              \
    }
static const struct named_command {
    const char *name;
    PFN_vkVoidFunction function;
} commands[] = {
    NAMED(CreateInstance),
    NAMED(CreateDevice),
    NAMED(GetPhysicalDeviceFeatures2),
    NAMED(GetPhysicalDeviceFeatures2KHR),
    NAMED(GetPhysicalDeviceProperties2),
    NAMED(GetPhysicalDeviceProperties2KHR),
    NAMED(GetPhysicalDeviceMemoryProperties2),
    NAMED(GetPhysicalDeviceMemoryProperties2KHR),
    NAMED(GetPhysicalDeviceFormatProperties2),
    NAMED(GetPhysicalDeviceFormatProperties2KHR),
};

static PFN_vkVoidFunction find(const char *name)
{
    for (size_t i = 0; i < sizeof(commands) / sizeof(commands[0]); i++)
        if (strcmp(commands[i].name, name) == 0)
            return commands[i].function;
    return NULL;
}

static VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL strict_GetDeviceProcAddr(VkDevice device,
                                                                         const char *name)
{
    if (strcmp(name, "vkGetBufferDeviceAddress") == 0)
        return (PFN_vkVoidFunction)strict_GetBufferDeviceAddress;
    return layer.next_of_device(device, name);
}

static VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL strict_GetInstanceProcAddr(VkInstance instance,
                                                                           const char *name)
{
    if (strcmp(name, "vkGetInstanceProcAddr") == 0)
        return (PFN_vkVoidFunction)strict_GetInstanceProcAddr;
    if (strcmp(name, "vkGetDeviceProcAddr") == 0)
        return (PFN_vkVoidFunction)strict_GetDeviceProcAddr;
    const PFN_vkVoidFunction own = find(name);
    return own || !instance ? own : layer.next.GetInstanceProcAddr(instance, name);
}

VkResult vkNegotiateLoaderLayerInterfaceVersion(VkNegotiateLayerInterface *interface)
{
    interface->loaderLayerInterfaceVersion = 2;
    interface->pfnGetInstanceProcAddr = strict_GetInstanceProcAddr;
    interface->pfnGetDeviceProcAddr = strict_GetDeviceProcAddr;
    interface->pfnGetPhysicalDeviceProcAddr = NULL;
    return VK_SUCCESS;
}
