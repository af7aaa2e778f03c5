/* SPDX-License-Identifier: Apache-2.0 */
/* Loads the Vulkan commands that the demo uses. */
#include "calls.h"
#include "fail.h"

static PFN_vkVoidFunction calls_require(PFN_vkVoidFunction found, const char *name)
{
    if (!found)
        demo_fail("the loader or the driver has no %s", name);
    return found;
}

#define CALLS_LOAD(owner, name)                                                                    \
    calls->name = (PFN_vk##name)calls_require(get(owner, "vk" #name), "vk" #name);

void calls_load_instance(struct instance_calls *calls, PFN_vkGetInstanceProcAddr get,
                         VkInstance instance)
{
#define CALLS_LOAD_INSTANCE(name) CALLS_LOAD(instance, name)
    CALLS_OF_INSTANCE(CALLS_LOAD_INSTANCE)
}

void calls_load_device(struct device_calls *calls, PFN_vkGetDeviceProcAddr get, VkDevice device)
{
#define CALLS_LOAD_DEVICE(name) CALLS_LOAD(device, name)
    CALLS_OF_DEVICE(CALLS_LOAD_DEVICE)
}
