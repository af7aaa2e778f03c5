/* SPDX-License-Identifier: Apache-2.0 */
/* Stores the previous build. */
#include "src/state/builds/previous_shape.h"

void previous_shape_set(struct previous_shape *previous,
                        const VkAccelerationStructureBuildGeometryInfoKHR *info,
                        uint32_t primitive_count, VkAccelerationStructureBuildTypeKHR build_type,
                        const struct size_facts *sizes, bool passes)
{
    const VkAccelerationStructureGeometryKHR *geometry = build_geometry(info, 0);
    previous->sizes = *sizes;
    previous->stype = info->sType;
    previous->geometry_stype = geometry->sType;
    previous->data_stype = geometry->geometry.triangles.sType;
    previous->mode = info->mode;
    previous->passes = passes;
    if (!small_shape_of(info, &primitive_count, build_type, &previous->shape))
        previous->sizes.known = false;
}
