/* SPDX-License-Identifier: Apache-2.0 */
/* elevated_probe LIBRARY: opens the layer's library and creates an instance over a driver that is
 * none. It needs no loader, which ignores the environment in a process with elevated privileges.
 * The layer says which settings it doesn't understand: the probe itself gives one of them. */
#include <dlfcn.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <sys/auxv.h>
#include <vulkan/vk_layer.h>
#include <vulkan/vulkan.h>

#include "tests/fixture/make.h"

static VKAPI_ATTR VkResult VKAPI_CALL create(const VkInstanceCreateInfo *info,
                                             const VkAllocationCallbacks *allocator,
                                             VkInstance *instance)
{
    static void *key; /* what dispatchable objects begin with */
    static void *object = &key;
    *instance = (VkInstance)&object;
    return VK_SUCCESS;
}

static VKAPI_ATTR void VKAPI_CALL destroy(VkInstance instance,
                                          const VkAllocationCallbacks *allocator)
{
}

static VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL find(VkInstance instance, const char *name)
{
    if (strcmp(name, "vkCreateInstance") == 0)
        return (PFN_vkVoidFunction)create;
    if (strcmp(name, "vkDestroyInstance") == 0)
        return (PFN_vkVoidFunction)destroy;
    return NULL;
}

static int use_layer(PFN_vkGetInstanceProcAddr layer)
{
    static const char *const value = "bogus-given";
    const VkLayerSettingEXT setting = {"VK_LAYER_ASSAY_validation", "content_when_full",
                                       VK_LAYER_SETTING_TYPE_STRING_EXT, 1, &value};
    const STRUCT(VkLayerSettingsCreateInfoEXT, settings, .settingCount = 1, .pSettings = &setting);
    VkLayerInstanceLink next = {.pfnNextGetInstanceProcAddr = find};
    VkLayerInstanceCreateInfo link = {
        .sType = VK_STRUCTURE_TYPE_LOADER_INSTANCE_CREATE_INFO,
        .pNext = &settings,
        .function = VK_LAYER_LINK_INFO,
        .u.pLayerInfo = &next,
    };
    const STRUCT(VkInstanceCreateInfo, info, .pNext = &link);
    const PFN_vkCreateInstance create_instance =
        (PFN_vkCreateInstance)layer(NULL, "vkCreateInstance");
    VkInstance instance;
    if (!create_instance || create_instance(&info, NULL, &instance) != VK_SUCCESS)
        return 1;
    const PFN_vkDestroyInstance destroy_instance =
        (PFN_vkDestroyInstance)layer(instance, "vkDestroyInstance");
    if (!destroy_instance)
        return 1;
    destroy_instance(instance, NULL);
    return 0;
}

int main(int argc, char **argv)
{
    if (argc != 2) {
        fprintf(stderr, "usage: %s LIBRARY\n", argv[0]);
        return 2;
    }
    printf("%s\n", getauxval(AT_SECURE) ? "elevated" : "plain");
    void *library = dlopen(argv[1], RTLD_NOW | RTLD_LOCAL);
    if (!library) {
        fprintf(stderr, "%s\n", dlerror());
        return 1;
    }
    VkNegotiateLayerInterface interface = {.sType = LAYER_NEGOTIATE_INTERFACE_STRUCT,
                                           .loaderLayerInterfaceVersion = 2};
    const PFN_vkNegotiateLoaderLayerInterfaceVersion negotiate =
        (PFN_vkNegotiateLoaderLayerInterfaceVersion)dlsym(library,
                                                          "vkNegotiateLoaderLayerInterfaceVersion");
    if (!negotiate || negotiate(&interface) != VK_SUCCESS)
        return 1;
    return use_layer(interface.pfnGetInstanceProcAddr);
}
