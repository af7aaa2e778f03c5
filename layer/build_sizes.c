/* SPDX-License-Identifier: Apache-2.0 */
/* Queries the sizes of builds, through the size cache. */
#include "layer/build_sizes.h"

#include "src/base/recording_path.h"

ON_RECORDING_PATH void
layer_find_build_sizes(struct layer_device *device,
                       const VkAccelerationStructureBuildGeometryInfoKHR *info,
                       const uint32_t *counts, VkAccelerationStructureBuildTypeKHR build_type,
                       struct size_facts *sizes)
{
    struct build_shape shape;
    bool has_shape = build_shape_of(info, counts, build_type, &shape);
    if (has_shape && size_cache_find(device->sizes, &shape, sizes))
        return;
    if (!device->may_query_structures || !device->vk.GetAccelerationStructureBuildSizesKHR)
        return;
    VkAccelerationStructureBuildSizesInfoKHR answer = {
        .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_BUILD_SIZES_INFO_KHR};
    bool is_micromap = info->type == VK_ACCELERATION_STRUCTURE_TYPE_OPACITY_MICROMAP_KHR;
    device->vk.GetAccelerationStructureBuildSizesKHR(device->handle, build_type, info,
                                                     is_micromap ? NULL : counts, &answer);
    *sizes = (struct size_facts){.known = true,
                                 .acceleration_structure = answer.accelerationStructureSize,
                                 .build_scratch = answer.buildScratchSize,
                                 .update_scratch = answer.updateScratchSize};
    if (has_shape)
        size_cache_add(device->sizes, &shape, sizes);
}
