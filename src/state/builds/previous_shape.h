/* SPDX-License-Identifier: Apache-2.0 */
/* The previous build on the same device. Consecutive builds often differ only in their addresses;
 * such builds need no look-up in the size cache, and no evaluation of rules that depend only on the
 * members compared here. */
#ifndef ASSAY_STATE_BUILDS_PREVIOUS_SHAPE_H
#define ASSAY_STATE_BUILDS_PREVIOUS_SHAPE_H

#include "src/state/builds/small_shape.h"
#include "src/state/facts.h"

/* The shape of a build of one geometry without chains. Zero-initialized: none. */
struct previous_shape {
    struct small_shape shape;
    /* Members that rules depend on, but sizes don't. */
    VkStructureType stype, geometry_stype, data_stype;
    VkBuildAccelerationStructureModeKHR mode;
    struct size_facts sizes; /* unknown: there is no previous build */
    bool passes;             /* all rules about its parameters hold */
};

/* Returns whether a build of one geometry has the same shape, and so the same sizes. */
static inline bool previous_shape_is_same(const struct previous_shape *previous,
                                          const VkAccelerationStructureBuildGeometryInfoKHR *info,
                                          uint32_t primitive_count,
                                          VkAccelerationStructureBuildTypeKHR build_type)
{
    struct small_shape shape;
    /* Builds of different shapes usually differ in the primitive count. */
    if (!previous->sizes.known || previous->shape.first.primitive_count != primitive_count)
        return false;
    return small_shape_of(info, &primitive_count, build_type, &shape) &&
           small_shapes_are_equal(&previous->shape, &shape);
}

/* For a build with the same shape: returns whether the rules that depend only on the shape hold for
 * it, too. All members of a geometry's data begin with sType. */
static inline bool previous_shape_matches(const struct previous_shape *previous,
                                          const VkAccelerationStructureBuildGeometryInfoKHR *info)
{
    const VkAccelerationStructureGeometryKHR *geometry = build_geometry(info, 0);
    return previous->passes && previous->stype == info->sType && previous->mode == info->mode &&
           previous->geometry_stype == geometry->sType &&
           previous->data_stype == geometry->geometry.triangles.sType;
}

/* Stores the shape of a build, or none if the build has a chain. */
void previous_shape_set(struct previous_shape *previous,
                        const VkAccelerationStructureBuildGeometryInfoKHR *info,
                        uint32_t primitive_count, VkAccelerationStructureBuildTypeKHR build_type,
                        const struct size_facts *sizes, bool passes);

#endif
