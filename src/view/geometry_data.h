/* SPDX-License-Identifier: Apache-2.0 */
/* Access to the members of a geometry's union. Each function returns NULL unless geometryType and
 * sType both select the member. */
#ifndef ASSAY_VIEW_GEOMETRY_DATA_H
#define ASSAY_VIEW_GEOMETRY_DATA_H

#include <stddef.h>
#include <stdint.h>

#include "src/bvh/input/formats.h"
#include "src/view/view.h"

static inline const VkAccelerationStructureGeometryTrianglesDataKHR *
triangles_in(const VkAccelerationStructureGeometryKHR *geometry)
{
    const VkAccelerationStructureGeometryTrianglesDataKHR *triangles =
        &geometry->geometry.triangles;
    return geometry->geometryType == VK_GEOMETRY_TYPE_TRIANGLES_KHR &&
                   triangles->sType ==
                       VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_TRIANGLES_DATA_KHR
               ? triangles
               : NULL;
}

static inline const VkAccelerationStructureGeometryAabbsDataKHR *
aabbs_in(const VkAccelerationStructureGeometryKHR *geometry)
{
    const VkAccelerationStructureGeometryAabbsDataKHR *aabbs = &geometry->geometry.aabbs;
    return geometry->geometryType == VK_GEOMETRY_TYPE_AABBS_KHR &&
                   aabbs->sType == VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_AABBS_DATA_KHR
               ? aabbs
               : NULL;
}

static inline const VkAccelerationStructureGeometryInstancesDataKHR *
instances_in(const VkAccelerationStructureGeometryKHR *geometry)
{
    const VkAccelerationStructureGeometryInstancesDataKHR *instances =
        &geometry->geometry.instances;
    return geometry->geometryType == VK_GEOMETRY_TYPE_INSTANCES_KHR &&
                   instances->sType ==
                       VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_INSTANCES_DATA_KHR
               ? instances
               : NULL;
}

/* Returns the role that the address in `data` of struct geometry_view has in its build. */
static inline enum input_role data_role(const struct geometry_view *geometry)
{
    return geometry->geometry->geometryType == VK_GEOMETRY_TYPE_AABBS_KHR ? INPUT_AABBS
                                                                          : INPUT_INSTANCES;
}

#endif
