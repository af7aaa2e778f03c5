/* SPDX-License-Identifier: Apache-2.0 */
/* Accessors for the parameters of a build, which must be readable. */
#ifndef ASSAY_STATE_BUILDS_BUILD_INFO_H
#define ASSAY_STATE_BUILDS_BUILD_INFO_H

#include <stdbool.h>
#include <vulkan/vulkan.h>

/* Returns a geometry by its index, from the array that the application gives. */
static inline const VkAccelerationStructureGeometryKHR *
build_geometry(const VkAccelerationStructureBuildGeometryInfoKHR *info, uint32_t geometry)
{
    return info->pGeometries ? &info->pGeometries[geometry] : info->ppGeometries[geometry];
}

static inline bool build_is_update(const VkAccelerationStructureBuildGeometryInfoKHR *info)
{
    return info->mode == VK_BUILD_ACCELERATION_STRUCTURE_MODE_UPDATE_KHR;
}

/* Returns whether a build updates its dst in place. */
static inline bool build_is_in_place(const VkAccelerationStructureBuildGeometryInfoKHR *info)
{
    return build_is_update(info) && info->srcAccelerationStructure &&
           info->srcAccelerationStructure == info->dstAccelerationStructure;
}

/* A dense geometry takes no build range: its primitive count is in its chain. */
static inline bool geometry_is_dense(const VkAccelerationStructureGeometryKHR *geometry)
{
    return (int)geometry->geometryType == VK_GEOMETRY_TYPE_DENSE_GEOMETRY_FORMAT_TRIANGLES_AMDX;
}

#endif
