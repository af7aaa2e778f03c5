/* SPDX-License-Identifier: Apache-2.0 */
/* A Vulkan loader for the tests on Windows: the application, the layer if it is enabled, and the
 * null driver, whose handles it passes on. Debian has no loader for Windows, and the one of Wine
 * loads no layers. It reads no manifest and no environment. */
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>
#include <windows.h>

#include <vulkan/vk_icd.h>
#include <vulkan/vk_layer.h>
#include <vulkan/vulkan_core.h>

#define LAYER_NAME "VK_LAYER_ASSAY_validation"
#define EXPORT __declspec(dllexport)

enum { LAYER_EXTENSIONS = 3 };

static PFN_vk_icdGetInstanceProcAddr driver_get;
static VkNegotiateLayerInterface layer;
static VkInstance
    current; /* instances of the tests come one after the other, except where none ends */

static void set_key(void *handle, const void *key)
{
    *(const void **)handle = key;
}

static PFN_vkVoidFunction driver_command(VkInstance instance, const char *name)
{
    return driver_get(instance, name);
}

/* ---- below the layer */

static VKAPI_ATTR VkResult VKAPI_CALL driver_create_instance(const VkInstanceCreateInfo *info,
                                                             const VkAllocationCallbacks *allocator,
                                                             VkInstance *instance)
{
    const char *names[64];
    VkInstanceCreateInfo below = *info;
    below.enabledLayerCount = 0;
    below.enabledExtensionCount = 0;
    below.ppEnabledExtensionNames = names;
    for (uint32_t i = 0; i < info->enabledExtensionCount; i++) /* those of the layer alone */
        if (strcmp(info->ppEnabledExtensionNames[i], "VK_EXT_debug_report") != 0 &&
            strcmp(info->ppEnabledExtensionNames[i], "VK_EXT_layer_settings") != 0)
            names[below.enabledExtensionCount++] = info->ppEnabledExtensionNames[i];
    VkResult result = ((PFN_vkCreateInstance)driver_command(NULL, "vkCreateInstance"))(
        &below, allocator, instance);
    if (result == VK_SUCCESS)
        set_key(*instance, malloc(1));
    return result;
}

static VKAPI_ATTR VkResult VKAPI_CALL driver_enumerate(VkInstance instance, uint32_t *count,
                                                       VkPhysicalDevice *devices)
{
    VkResult result = ((PFN_vkEnumeratePhysicalDevices)driver_command(
        instance, "vkEnumeratePhysicalDevices"))(instance, count, devices);
    for (uint32_t i = 0; devices && result >= 0 && i < *count; i++)
        set_key(devices[i], *(void **)instance);
    return result;
}

static VKAPI_ATTR VkResult VKAPI_CALL driver_enumerate_groups(
    VkInstance instance, uint32_t *count, VkPhysicalDeviceGroupProperties *groups)
{
    VkResult result = ((PFN_vkEnumeratePhysicalDeviceGroups)driver_command(
        instance, "vkEnumeratePhysicalDeviceGroups"))(instance, count, groups);
    for (uint32_t i = 0; groups && result >= 0 && i < *count; i++)
        for (uint32_t j = 0; j < groups[i].physicalDeviceCount; j++)
            set_key(groups[i].physicalDevices[j], *(void **)instance);
    return result;
}

static VKAPI_ATTR VkResult VKAPI_CALL driver_create_device(VkPhysicalDevice physical_device,
                                                           const VkDeviceCreateInfo *info,
                                                           const VkAllocationCallbacks *allocator,
                                                           VkDevice *device)
{
    VkDeviceCreateInfo below = *info;
    below.enabledLayerCount = 0;
    VkResult result = ((PFN_vkCreateDevice)driver_command(current, "vkCreateDevice"))(
        physical_device, &below, allocator, device);
    if (result == VK_SUCCESS)
        set_key(*device, malloc(1));
    return result;
}

static VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL driver_device_command(VkDevice device,
                                                                      const char *name)
{
    return ((PFN_vkGetDeviceProcAddr)driver_command(current, "vkGetDeviceProcAddr"))(device, name);
}

static VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL next_command(VkInstance instance, const char *name)
{
    static const struct {
        const char *name;
        PFN_vkVoidFunction function;
    } own[] = {
        {"vkCreateInstance", (PFN_vkVoidFunction)driver_create_instance},
        {"vkEnumeratePhysicalDevices", (PFN_vkVoidFunction)driver_enumerate},
        {"vkEnumeratePhysicalDeviceGroups", (PFN_vkVoidFunction)driver_enumerate_groups},
        {"vkEnumeratePhysicalDeviceGroupsKHR", (PFN_vkVoidFunction)driver_enumerate_groups},
        {"vkCreateDevice", (PFN_vkVoidFunction)driver_create_device},
        {"vkGetDeviceProcAddr", (PFN_vkVoidFunction)driver_device_command},
    };
    for (size_t i = 0; i < sizeof(own) / sizeof(own[0]); i++)
        if (strcmp(name, own[i].name) == 0)
            return own[i].function;
    return driver_command(instance, name);
}

static VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL next_physical_command(VkInstance instance,
                                                                      const char *name)
{
    (void)instance;
    (void)name;
    return NULL;
}

/* ---- above the layer */

static bool has_layer; /* of the current instance */

static PFN_vkVoidFunction first_command(VkInstance instance, const char *name)
{
    return has_layer ? layer.pfnGetInstanceProcAddr(instance, name) : next_command(instance, name);
}

static PFN_vkVoidFunction first_device_command(VkDevice device, const char *name)
{
    return has_layer ? layer.pfnGetDeviceProcAddr(device, name)
                     : driver_device_command(device, name);
}

static VKAPI_ATTR VkResult VKAPI_CALL create_instance(const VkInstanceCreateInfo *info,
                                                      const VkAllocationCallbacks *allocator,
                                                      VkInstance *instance)
{
    VkLayerInstanceLink link = {NULL, next_command, next_physical_command};
    const VkLayerInstanceCreateInfo chain = {
        .sType = VK_STRUCTURE_TYPE_LOADER_INSTANCE_CREATE_INFO,
        .pNext = info->pNext,
        .function = VK_LAYER_LINK_INFO,
        .u.pLayerInfo = &link,
    };
    VkInstanceCreateInfo above = *info;
    above.pNext = &chain;
    has_layer = false;
    for (uint32_t i = 0; i < info->enabledLayerCount; i++) {
        if (strcmp(info->ppEnabledLayerNames[i], LAYER_NAME) != 0)
            return VK_ERROR_LAYER_NOT_PRESENT;
        has_layer = true;
    }
    VkResult result = ((PFN_vkCreateInstance)first_command(NULL, "vkCreateInstance"))(
        &above, allocator, instance);
    if (result == VK_SUCCESS)
        current = *instance;
    return result;
}

static VKAPI_ATTR VkResult VKAPI_CALL set_device_data(VkDevice device, void *object)
{
    set_key(object, *(void **)device);
    return VK_SUCCESS;
}

static VKAPI_ATTR VkResult VKAPI_CALL create_device(VkPhysicalDevice physical_device,
                                                    const VkDeviceCreateInfo *info,
                                                    const VkAllocationCallbacks *allocator,
                                                    VkDevice *device)
{
    VkLayerDeviceLink link = {NULL, next_command, driver_device_command};
    const VkLayerDeviceCreateInfo callback = {
        .sType = VK_STRUCTURE_TYPE_LOADER_DEVICE_CREATE_INFO,
        .pNext = info->pNext,
        .function = VK_LOADER_DATA_CALLBACK,
        .u.pfnSetDeviceLoaderData = set_device_data,
    };
    const VkLayerDeviceCreateInfo chain = {
        .sType = VK_STRUCTURE_TYPE_LOADER_DEVICE_CREATE_INFO,
        .pNext = &callback,
        .function = VK_LAYER_LINK_INFO,
        .u.pLayerInfo = &link,
    };
    VkDeviceCreateInfo above = *info;
    above.pNext = &chain;
    return ((PFN_vkCreateDevice)first_command(current, "vkCreateDevice"))(physical_device, &above,
                                                                          allocator, device);
}

static VKAPI_ATTR void VKAPI_CALL get_queue(VkDevice device, uint32_t family, uint32_t index,
                                            VkQueue *queue)
{
    ((PFN_vkGetDeviceQueue)first_device_command(device, "vkGetDeviceQueue"))(device, family, index,
                                                                             queue);
    if (*queue)
        set_device_data(device, *queue);
}

static VKAPI_ATTR void VKAPI_CALL get_queue2(VkDevice device, const VkDeviceQueueInfo2 *info,
                                             VkQueue *queue)
{
    ((PFN_vkGetDeviceQueue2)first_device_command(device, "vkGetDeviceQueue2"))(device, info, queue);
    if (*queue)
        set_device_data(device, *queue);
}

static VKAPI_ATTR VkResult VKAPI_CALL allocate_command_buffers(
    VkDevice device, const VkCommandBufferAllocateInfo *info, VkCommandBuffer *command_buffers)
{
    VkResult result = ((PFN_vkAllocateCommandBuffers)first_device_command(
        device, "vkAllocateCommandBuffers"))(device, info, command_buffers);
    for (uint32_t i = 0; result == VK_SUCCESS && i < info->commandBufferCount; i++)
        set_device_data(device, command_buffers[i]);
    return result;
}

static VKAPI_ATTR VkResult VKAPI_CALL enumerate_layers(uint32_t *count, VkLayerProperties *layers)
{
    if (layers && *count)
        layers[0] = (VkLayerProperties){.layerName = LAYER_NAME};
    *count = 1;
    return VK_SUCCESS;
}

static VKAPI_ATTR VkResult VKAPI_CALL enumerate_extensions(const char *of_layer, uint32_t *count,
                                                           VkExtensionProperties *extensions)
{
    static const VkExtensionProperties own[LAYER_EXTENSIONS] = {
        {"VK_EXT_debug_report", 10}, {"VK_EXT_debug_utils", 2}, {"VK_EXT_layer_settings", 2}};
    if (!of_layer)
        return ((PFN_vkEnumerateInstanceExtensionProperties)driver_command(
            NULL, "vkEnumerateInstanceExtensionProperties"))(NULL, count, extensions);
    if (extensions && *count >= LAYER_EXTENSIONS)
        memcpy(extensions, own, sizeof(own));
    *count = LAYER_EXTENSIONS;
    return VK_SUCCESS;
}

static VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL device_command(VkDevice device, const char *name);

static PFN_vkVoidFunction own_device_command(const char *name)
{
    if (strcmp(name, "vkGetDeviceQueue") == 0)
        return (PFN_vkVoidFunction)get_queue;
    if (strcmp(name, "vkGetDeviceQueue2") == 0)
        return (PFN_vkVoidFunction)get_queue2;
    if (strcmp(name, "vkAllocateCommandBuffers") == 0)
        return (PFN_vkVoidFunction)allocate_command_buffers;
    if (strcmp(name, "vkGetDeviceProcAddr") == 0)
        return (PFN_vkVoidFunction)device_command;
    return NULL;
}

static VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL device_command(VkDevice device, const char *name)
{
    PFN_vkVoidFunction found = first_device_command(device, name), own = own_device_command(name);
    return found && own ? own : found;
}

static bool load(void)
{
    if (driver_get)
        return true;
    HMODULE driver = LoadLibraryA(NULL_DRIVER_LIBRARY), library = LoadLibraryA(LAYER_LIBRARY);
    PFN_vkNegotiateLoaderLayerInterfaceVersion negotiate =
        library ? (PFN_vkNegotiateLoaderLayerInterfaceVersion)(void *)GetProcAddress(
                      library, "vkNegotiateLoaderLayerInterfaceVersion")
                : NULL;
    layer.sType = LAYER_NEGOTIATE_INTERFACE_STRUCT;
    layer.loaderLayerInterfaceVersion = CURRENT_LOADER_LAYER_INTERFACE_VERSION;
    if (!driver || !negotiate || negotiate(&layer) != VK_SUCCESS)
        return false;
    driver_get =
        (PFN_vk_icdGetInstanceProcAddr)(void *)GetProcAddress(driver, "vk_icdGetInstanceProcAddr");
    return driver_get != NULL;
}

EXPORT VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL vkGetInstanceProcAddr(VkInstance instance,
                                                                      const char *name);

EXPORT VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL vkGetInstanceProcAddr(VkInstance instance,
                                                                      const char *name)
{
    static const struct {
        const char *name;
        PFN_vkVoidFunction function;
    } own[] = {
        {"vkGetInstanceProcAddr", (PFN_vkVoidFunction)vkGetInstanceProcAddr},
        {"vkCreateInstance", (PFN_vkVoidFunction)create_instance},
        {"vkCreateDevice", (PFN_vkVoidFunction)create_device},
        {"vkEnumerateInstanceLayerProperties", (PFN_vkVoidFunction)enumerate_layers},
        {"vkEnumerateInstanceExtensionProperties", (PFN_vkVoidFunction)enumerate_extensions},
    };
    if (!load())
        return NULL;
    for (size_t i = 0; i < sizeof(own) / sizeof(own[0]); i++)
        if (strcmp(name, own[i].name) == 0)
            return own[i].function;
    if (!instance)
        return next_command(NULL, name);
    PFN_vkVoidFunction device = own_device_command(name);
    return device ? device : first_command(instance, name);
}
