/* SPDX-License-Identifier: Apache-2.0 */
/* Intercepts of micromaps of VK_EXT_opacity_micromap. */
#include "intercepts.h"
#include "layer.h"
#include "submissions.h"

VKAPI_ATTR VkResult VKAPI_CALL assay_CreateMicromapEXT(VkDevice device,
                                                       const VkMicromapCreateInfoEXT *pCreateInfo,
                                                       const VkAllocationCallbacks *pAllocator,
                                                       VkMicromapEXT *pMicromap)
{
    struct layer_device *state = layer_find_device(device);
    VkResult result = state->vk.CreateMicromapEXT(device, pCreateInfo, pAllocator, pMicromap);
    if (result == VK_SUCCESS)
        resources_add_micromap(state->resources, *pMicromap, pCreateInfo->type);
    return result;
}

VKAPI_ATTR void VKAPI_CALL assay_DestroyMicromapEXT(VkDevice device, VkMicromapEXT micromap,
                                                    const VkAllocationCallbacks *pAllocator)
{
    struct layer_device *state = layer_find_device(device);
    submissions_forget(state->submissions, resources_remove_micromap(state->resources, micromap),
                       1);
    object_names_set(state->names, VK_OBJECT_TYPE_MICROMAP_EXT, (uint64_t)(uintptr_t)micromap,
                     NULL);
    state->vk.DestroyMicromapEXT(device, micromap, pAllocator);
}
