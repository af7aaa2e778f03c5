/* SPDX-License-Identifier: Apache-2.0 */
/* The layer as a tool: vkGetPhysicalDeviceToolProperties and its equivalent of
 * VK_EXT_tooling_info. */
#include <string.h>

#include "observers.h"

/* Keeps sType and pNext, which are the application's. */
static void fill_properties(VkPhysicalDeviceToolProperties *properties, enum backend backend)
{
    VkPhysicalDeviceToolProperties own = {
        .sType = properties->sType,
        .pNext = properties->pNext,
        .name = "Assay",
        .version = ASSAY_VERSION,
        .purposes = VK_TOOL_PURPOSE_VALIDATION_BIT | VK_TOOL_PURPOSE_DEBUG_REPORTING_BIT_EXT,
        .description = ASSAY_LAYER_DESCRIPTION,
        .layer = ASSAY_LAYER_NAME,
    };
    if (backend == BACKEND_CPU)
        own.purposes |=
            VK_TOOL_PURPOSE_ADDITIONAL_FEATURES_BIT | VK_TOOL_PURPOSE_MODIFYING_FEATURES_BIT;
    *properties = own;
}

/* Lists the layer, then the tools below. `next` is NULL if the driver lacks the command. The loader
 * may return success without a count if the driver lacks it, so the count begins as 0. */
VkResult list_tools(struct layer_instance *instance, PFN_vkGetPhysicalDeviceToolProperties next,
                    VkPhysicalDevice physical_device, uint32_t *count,
                    VkPhysicalDeviceToolProperties *properties)
{
    uint32_t below = 0, room = *count;
    VkResult result = next ? next(physical_device, &below, NULL) : VK_SUCCESS;
    if (result < VK_SUCCESS)
        return result;
    if (!properties) {
        *count = below + 1;
        return VK_SUCCESS;
    }
    *count = 0;
    if (room == 0)
        return VK_INCOMPLETE;
    if (below) {
        below = room - 1;
        result = next(physical_device, &below, properties + 1);
        if (result < VK_SUCCESS)
            return result;
    }
    fill_properties(&properties[0], instance->backend);
    *count = below + 1;
    return result;
}
