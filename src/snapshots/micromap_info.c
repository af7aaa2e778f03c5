/* SPDX-License-Identifier: Apache-2.0 */
/* Translates VkMicromapBuildInfoEXT to the parameters of a build. */
#include "src/snapshots/micromap_info.h"

#include <stdlib.h>
#include <string.h>

static VkResult copy_input(struct readable_cache *cache, const VkMicromapBuildInfoEXT *info,
                           struct build_parameters *copy)
{
    copy->chained = calloc(1, sizeof(*copy->chained));
    if (!copy->chained)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    copy->geometries[0].geometryType = VK_GEOMETRY_TYPE_MICROMAP_KHR;
    copy->chained[0].micromap = (struct micromap_parameters){
        .type = info->type,
        .data = info->data,
        .triangles = info->triangleArray,
        .stride = info->triangleArrayStride,
    };
    return micromap_usages_copy(cache, info->usageCountsCount, info->pUsageCounts,
                                info->ppUsageCounts, &copy->chained[0].micromap);
}

VkResult micromap_info_copy(struct readable_cache *cache, const VkMicromapBuildInfoEXT *from,
                            struct build_parameters *copy)
{
    *copy = (struct build_parameters){0}; /* info.mode: BUILD */
    if (!readable(cache, from, sizeof(*from)))
        return VK_ERROR_VALIDATION_FAILED;
    VkMicromapBuildInfoEXT own, *info = &own;
    memcpy(info, from, sizeof(*info));
    copy->had_chains = true; /* the members alone do not describe the build */
    copy->info.type = VK_ACCELERATION_STRUCTURE_TYPE_OPACITY_MICROMAP_KHR;
    copy->info.dstAccelerationStructure = (VkAccelerationStructureKHR)info->dstMicromap;
    copy->info.scratchData = info->scratchData;
    VkResult result = build_parameters_allocate(copy, 1);
    if (result == VK_SUCCESS)
        result = copy_input(cache, info, copy);
    if (result != VK_SUCCESS)
        build_parameters_release(copy);
    return result;
}
