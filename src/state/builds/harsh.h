/* SPDX-License-Identifier: Apache-2.0 */
/* Setting limits = harsh: the limits and sizes that the layer reports in place of the driver's.
 *
 * Alignments and sizes only grow and counts only shrink, so a driver gets what it needs from every
 * application that keeps to these figures. A size is a function of the driver's size and of what
 * the size was queried for. It never shrinks if the driver's size grows, and a size for
 * VK_ACCELERATION_STRUCTURE_BUILD_TYPE_HOST_OR_DEVICE_KHR suffices for either type, as the
 * specification demands (vkGetAccelerationStructureBuildSizesKHR). docs/harsh.md has the reasons.
 */
#ifndef ASSAY_STATE_BUILDS_HARSH_H
#define ASSAY_STATE_BUILDS_HARSH_H

#include <stdbool.h>
#include <vulkan/vulkan_core.h>

void harsh_limit_structures(VkPhysicalDeviceAccelerationStructurePropertiesKHR *limits);

/* The structure has at least twice the driver's size, so that a compacted copy, which the driver
 * sizes itself, has at most half of it. A structure of 0 bytes leaves all sizes unchanged. No size
 * that grows is a multiple of an alignment, so that whoever puts one structure right behind another
 * one misaligns it. */
struct harsh_build {
    VkAccelerationStructureBuildTypeKHR build_type;
    VkAccelerationStructureTypeKHR type;
    VkBuildAccelerationStructureFlagsKHR flags;
    bool has_transform; /* triangles of one of its geometries have a transform */
};
void harsh_grow_build_sizes(const struct harsh_build *build,
                            VkAccelerationStructureBuildSizesInfoKHR *sizes);

void harsh_grow_micromap_sizes(VkAccelerationStructureBuildTypeKHR build_type,
                               VkBuildMicromapFlagsEXT flags, VkMicromapBuildSizesInfoEXT *sizes);

/* For VK_NV_ray_tracing, whose query names a structure instead of a build. */
void harsh_grow_requirements(VkAccelerationStructureMemoryRequirementsTypeNV type,
                             VkMemoryRequirements *requirements);

#endif
