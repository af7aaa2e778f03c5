/* SPDX-License-Identifier: Apache-2.0 */
/* Reading the parameters of a build, once they were found readable. */
#ifndef ASSAY_STATE_BUILDS_BUILD_INFO_H
#define ASSAY_STATE_BUILDS_BUILD_INFO_H

#include <stdbool.h>
#include <vulkan/vulkan.h>

/* The geometry-th geometry, by the array that is given. */
static inline const VkAccelerationStructureGeometryKHR *
build_geometry(const VkAccelerationStructureBuildGeometryInfoKHR *info, uint32_t geometry)
{
    return info->pGeometries ? &info->pGeometries[geometry] : info->ppGeometries[geometry];
}

static inline bool build_is_update(const VkAccelerationStructureBuildGeometryInfoKHR *info)
{
    return info->mode == VK_BUILD_ACCELERATION_STRUCTURE_MODE_UPDATE_KHR;
}

/* A dense geometry takes no build range: its primitiveCount is what its chain says. */
static inline bool geometry_is_dense(const VkAccelerationStructureGeometryKHR *geometry)
{
    return (int)geometry->geometryType == VK_GEOMETRY_TYPE_DENSE_GEOMETRY_FORMAT_TRIANGLES_AMDX;
}

#endif
