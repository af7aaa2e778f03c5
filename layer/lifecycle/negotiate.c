/* SPDX-License-Identifier: Apache-2.0 */
/* The loader's interface: the one exported function, and commands by name. */
#include <string.h>

#include "layer/cpu/overlay.h"
#include "layer/hazards/commands.h"
#include "layer/intercepts/call_sites.h"
#include "layer/intercepts/intercepts.h"
#include "layer/layer.h"
#include "layer/lifecycle/arguments.h"
#include "layer/snapshots/snapshots.h"

enum { LOADER_INTERFACE_VERSION = 2 };

struct named_command {
    const char *name;
    PFN_vkVoidFunction function;
};

#define NAMED(name) {"vk" #name, (PFN_vkVoidFunction)assay_##name},
static const struct named_command global_commands[] = {ASSAY_GLOBAL_INTERCEPTS(NAMED)};
static const struct named_command instance_commands[] = {ASSAY_INSTANCE_INTERCEPTS(NAMED)};
static const struct named_command device_commands[] = {ASSAY_DEVICE_INTERCEPTS(NAMED)};
#undef NAMED

#define FIND(commands, name) find_command(commands, sizeof(commands) / sizeof((commands)[0]), name)

static PFN_vkVoidFunction find_command(const struct named_command *commands, size_t count,
                                       const char *name)
{
    for (size_t i = 0; i < count; i++)
        if (strcmp(commands[i].name, name) == 0)
            return commands[i].function;
    return NULL;
}

static PFN_vkVoidFunction find_intercept(const char *name)
{
    PFN_vkVoidFunction own = FIND(global_commands, name);
    if (!own)
        own = FIND(instance_commands, name);
    return own ? own : FIND(device_commands, name);
}

/* Old layers query vkCreateDevice, among others, without an instance. The layer then returns any
 * intercept, as the Khronos layer does. With an instance, it returns NULL for a command that the
 * next layer lacks. */
VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL assay_GetInstanceProcAddr(VkInstance instance,
                                                                   const char *pName)
{
    if (!arguments_can_read_string(pName))
        return NULL;
    PFN_vkVoidFunction own = find_intercept(pName);
    struct layer_instance *state = instance ? layer_find_instance(instance) : NULL;
    if (!state || FIND(global_commands, pName))
        return arguments_checked(own);
    own = hazards_command(state, pName, call_sites_command(state, pName, own));
    PFN_vkVoidFunction next = state->vk.GetInstanceProcAddr(instance, pName);
    if (state->backend == BACKEND_CPU)
        next = cpu_overlay_instance_command(pName, next);
    return arguments_checked(next && own ? own : next);
}

VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL assay_GetDeviceProcAddr(VkDevice device, const char *pName)
{
    struct layer_device *state = layer_find_device(device);
    if (!state || !arguments_can_read_string(pName))
        return NULL;
    PFN_vkVoidFunction own =
        call_sites_command(state->instance, pName, FIND(device_commands, pName));
    own = hazards_command(state->instance, pName, own);
    PFN_vkVoidFunction next = state->vk.GetDeviceProcAddr(device, pName);
    if (state->cpu)
        next = cpu_overlay_command(state->cpu, pName, next);
    if (state->snapshots)
        next = snapshots_command(state->snapshots, pName, next);
    return arguments_checked(next && own ? own : next);
}

PFN_vkVoidFunction VKAPI_CALL assay_GetPhysicalDeviceProcAddr(VkInstance instance,
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
    pVersionStruct->pfnGetPhysicalDeviceProcAddr = assay_GetPhysicalDeviceProcAddr;
    return VK_SUCCESS;
}
