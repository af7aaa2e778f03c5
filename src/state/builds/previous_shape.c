/* SPDX-License-Identifier: Apache-2.0 */
/* Keeping the build before. */
#include "src/state/builds/previous_shape.h"

void previous_shape_set(struct previous_shape *recent,
                        const VkAccelerationStructureBuildGeometryInfoKHR *info,
                        uint32_t primitive_count, VkAccelerationStructureBuildTypeKHR build_type,
                        const struct size_facts *sizes, bool passes)
{
    const VkAccelerationStructureGeometryKHR *geometry = build_geometry(info, 0);
    recent->sizes = *sizes;
    recent->stype = info->sType;
    recent->geometry_stype = geometry->sType;
    recent->data_stype = geometry->geometry.triangles.sType;
    recent->mode = info->mode;
    recent->passes = passes;
    if (!small_shape_of(info, &primitive_count, build_type, &recent->shape))
        recent->sizes.known = false;
}
