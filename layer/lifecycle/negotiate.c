/* SPDX-License-Identifier: Apache-2.0 */
/* The loader's interface: the one exported function, and commands by name. */
#include <string.h>

#include "layer/assay.h"
#include "layer/commands/commands.h"
#include "layer/cpu/overlay.h"
#include "layer/snapshots/snapshots.h"
#include "observers.h"

enum { LOADER_INTERFACE_VERSION = 2 };

/* The commands of layer/assay.h, which no dispatch table has. Returns NULL for other names. */
static PFN_vkVoidFunction find_own_command(const char *name, bool is_on_backend)
{
    if (strcmp(name, "vkGetCountersASSAY") == 0)
        return is_on_backend ? (PFN_vkVoidFunction)cpu_GetCountersASSAY
                             : (PFN_vkVoidFunction)snapshots_GetCountersASSAY;
    if (is_on_backend && strcmp(name, "vkTraceRaysASSAY") == 0)
        return (PFN_vkVoidFunction)cpu_TraceRaysASSAY;
    return NULL;
}

/* Old layers query vkCreateDevice, among others, without an instance. The layer then returns any
 * intercept, as the Khronos layer does. With an instance, it returns NULL for a command that the
 * next layer lacks. */
VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL assay_GetInstanceProcAddr(VkInstance instance,
                                                                   const char *pName)
{
    if (!command_can_read_string(pName))
        return NULL;
    struct layer_instance *state = instance ? layer_find_instance(instance) : NULL;
    if (!state)
        return command_of_loader(pName, false);
    PFN_vkVoidFunction own = command_of_loader(pName, true);
    if (!own && state->backend == BACKEND_CPU)
        own = find_own_command(pName, true);
    return own ? own : command_of_instance(state, pName);
}

VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL assay_GetDeviceProcAddr(VkDevice device, const char *pName)
{
    struct layer_device *state = layer_find_device(device);
    if (!state || !command_can_read_string(pName))
        return NULL;
    PFN_vkVoidFunction own = NULL;
    if (state->cpu ? state->cpu->structures : state->snapshots != NULL)
        own = find_own_command(pName, state->cpu);
    return own ? own : command_of_device(state, pName);
}

static PFN_vkVoidFunction VKAPI_CALL get_physical_device_proc_addr(VkInstance instance,
                                                                   const char *pName)
{
    struct layer_instance *state = layer_find_instance(instance);
    return state && state->next_physical_device_proc_addr
               ? state->next_physical_device_proc_addr(instance, pName)
               : NULL;
}

__attribute__((visibility("default"))) VKAPI_ATTR VkResult VKAPI_CALL
vkNegotiateLoaderLayerInterfaceVersion(VkNegotiateLayerInterface *pVersionStruct)
{
    if (!pVersionStruct || pVersionStruct->sType != LAYER_NEGOTIATE_INTERFACE_STRUCT ||
        pVersionStruct->loaderLayerInterfaceVersion < LOADER_INTERFACE_VERSION)
        return VK_ERROR_INITIALIZATION_FAILED;
    pVersionStruct->loaderLayerInterfaceVersion = LOADER_INTERFACE_VERSION;
    pVersionStruct->pfnGetInstanceProcAddr = assay_GetInstanceProcAddr;
    pVersionStruct->pfnGetDeviceProcAddr = assay_GetDeviceProcAddr;
    pVersionStruct->pfnGetPhysicalDeviceProcAddr = get_physical_device_proc_addr;
    return VK_SUCCESS;
}
