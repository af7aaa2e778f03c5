/* SPDX-License-Identifier: Apache-2.0 */
/* The parameters of a build and of its geometries: accessors, and which member of a geometry's
 * union is used. The parameters must be readable. */
#ifndef ASSAY_MODEL_GEOMETRY_H
#define ASSAY_MODEL_GEOMETRY_H

#include <stdbool.h>
#include <stddef.h>
#include <vulkan/vulkan.h>
#include <vulkan/vulkan_beta.h>

#include "src/bvh/input/formats.h"

/* ---- builds */

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

/* ---- types of geometries */

static inline bool type_is_triangles(VkGeometryTypeKHR type)
{
    return type == VK_GEOMETRY_TYPE_TRIANGLES_KHR;
}

static inline bool type_is_aabbs(VkGeometryTypeKHR type)
{
    return type == VK_GEOMETRY_TYPE_AABBS_KHR;
}

static inline bool type_is_instances(VkGeometryTypeKHR type)
{
    return type == VK_GEOMETRY_TYPE_INSTANCES_KHR;
}

static inline bool type_is_spheres(VkGeometryTypeKHR type)
{
    return type == VK_GEOMETRY_TYPE_SPHERES_NV;
}

static inline bool type_is_swept_spheres(VkGeometryTypeKHR type)
{
    return type == VK_GEOMETRY_TYPE_LINEAR_SWEPT_SPHERES_NV;
}

static inline bool type_is_dense(VkGeometryTypeKHR type)
{
    return (int)type == VK_GEOMETRY_TYPE_DENSE_GEOMETRY_FORMAT_TRIANGLES_AMDX;
}

static inline bool type_is_micromap(VkGeometryTypeKHR type)
{
    return (int)type == VK_GEOMETRY_TYPE_MICROMAP_KHR;
}

/* Returns whether a geometry takes a build range. The others have their primitive count in their
 * chains. */
static inline bool type_takes_range(VkGeometryTypeKHR type)
{
    return !type_is_dense(type) && !type_is_micromap(type);
}

/* ---- the union: each function returns NULL unless geometryType and sType both select the member
 */

static inline const VkAccelerationStructureGeometryTrianglesDataKHR *
triangles_in(const VkAccelerationStructureGeometryKHR *geometry)
{
    const VkAccelerationStructureGeometryTrianglesDataKHR *triangles =
        &geometry->geometry.triangles;
    return type_is_triangles(geometry->geometryType) &&
                   triangles->sType ==
                       VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_TRIANGLES_DATA_KHR
               ? triangles
               : NULL;
}

static inline const VkAccelerationStructureGeometryAabbsDataKHR *
aabbs_in(const VkAccelerationStructureGeometryKHR *geometry)
{
    const VkAccelerationStructureGeometryAabbsDataKHR *aabbs = &geometry->geometry.aabbs;
    return type_is_aabbs(geometry->geometryType) &&
                   aabbs->sType == VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_AABBS_DATA_KHR
               ? aabbs
               : NULL;
}

static inline const VkAccelerationStructureGeometryInstancesDataKHR *
instances_in(const VkAccelerationStructureGeometryKHR *geometry)
{
    const VkAccelerationStructureGeometryInstancesDataKHR *instances =
        &geometry->geometry.instances;
    return type_is_instances(geometry->geometryType) &&
                   instances->sType ==
                       VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_INSTANCES_DATA_KHR
               ? instances
               : NULL;
}

/* Returns whether the instances of a geometry are behind an array of pointers; false for other
 * geometries. */
static inline bool has_instance_pointers(const VkAccelerationStructureGeometryKHR *geometry)
{
    return type_is_instances(geometry->geometryType) &&
           geometry->geometry.instances.arrayOfPointers;
}

#endif
