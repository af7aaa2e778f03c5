/* SPDX-License-Identifier: Apache-2.0 */
/* The build before on the same device: builds that follow each other are often alike in all but
 * their addresses. It spares such builds the cache of sizes, and the rules that read no more than
 * what is compared here. */
#ifndef ASSAY_STATE_BUILDS_PREVIOUS_SHAPE_H
#define ASSAY_STATE_BUILDS_PREVIOUS_SHAPE_H

#include "src/state/builds/small_shape.h"
#include "src/state/facts.h"

/* A build of one geometry without chains. Zero-initialized: none. */
struct previous_shape {
    struct small_shape shape;
    /* What its sizes don't depend on, but rules do. */
    VkStructureType stype, geometry_stype, data_stype;
    VkBuildAccelerationStructureModeKHR mode;
    struct size_facts sizes; /* unknown: none */
    bool passes;             /* all rules of its parameters */
};

/* Whether a build of one geometry has the same sizes. */
static inline bool previous_shape_is_same(const struct previous_shape *recent,
                                          const VkAccelerationStructureBuildGeometryInfoKHR *info,
                                          uint32_t primitive_count,
                                          VkAccelerationStructureBuildTypeKHR build_type)
{
    struct small_shape shape;
    /* Builds of different shapes differ in this first. */
    if (!recent->sizes.known || recent->shape.first.primitive_count != primitive_count)
        return false;
    return small_shape_of(info, &primitive_count, build_type, &shape) &&
           small_shapes_are_equal(&recent->shape, &shape);
}

/* Of a build that is like it: whether the rules that read the shape alone hold of it, too. The
 * members of a geometry's data begin alike. */
static inline bool previous_shape_matches(const struct previous_shape *recent,
                                          const VkAccelerationStructureBuildGeometryInfoKHR *info)
{
    const VkAccelerationStructureGeometryKHR *geometry = build_geometry(info, 0);
    return recent->passes && recent->stype == info->sType && recent->mode == info->mode &&
           recent->geometry_stype == geometry->sType &&
           recent->data_stype == geometry->geometry.triangles.sType;
}

/* Keeps a build, or none where it can't. */
void previous_shape_set(struct previous_shape *recent,
                        const VkAccelerationStructureBuildGeometryInfoKHR *info,
                        uint32_t primitive_count, VkAccelerationStructureBuildTypeKHR build_type,
                        const struct size_facts *sizes, bool passes);

#endif
