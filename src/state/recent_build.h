/* SPDX-License-Identifier: Apache-2.0 */
/* The build before on the same device: builds that follow each other are often alike in all but
 * their addresses. It spares such builds the cache of sizes, and the rules that read no more than
 * what is compared here. */
#ifndef ASSAY_STATE_RECENT_BUILD_H
#define ASSAY_STATE_RECENT_BUILD_H

#include "state/facts.h"
#include "state/small_shape.h"

/* A build of one geometry without chains. Zero-initialized: none. */
struct recent_build {
    struct small_shape shape;
    /* What its sizes don't depend on, but rules do. */
    VkStructureType stype, geometry_stype, data_stype;
    VkBuildAccelerationStructureModeKHR mode;
    struct size_facts sizes; /* unknown: none */
    bool holds;              /* all rules of its parameters */
};

/* Member by member, so that a shape that is only compared need not be written. */
static inline bool recent_build_has_shape(const struct recent_build *recent,
                                          const struct small_shape *shape)
{
    const struct small_shape *a = &recent->shape, *b = shape;
    const struct shape_geometry *x = &a->first, *y = &b->first;
    uint32_t different =
        (a->build_type ^ b->build_type) | (a->type ^ b->type) | (a->flags ^ b->flags) |
        (a->geometry_count ^ b->geometry_count) | (x->type ^ y->type) | (x->flags ^ y->flags) |
        (x->primitive_count ^ y->primitive_count) | (x->vertex_format ^ y->vertex_format) |
        (x->max_vertex ^ y->max_vertex) | (x->index_type ^ y->index_type) |
        (x->has_transform ^ y->has_transform) | (x->array_of_pointers ^ y->array_of_pointers);
    return !different && x->stride == y->stride;
}

/* Whether a build of one geometry has the same sizes. */
static inline bool recent_build_is_like(const struct recent_build *recent,
                                        const VkAccelerationStructureBuildGeometryInfoKHR *info,
                                        uint32_t primitive_count,
                                        VkAccelerationStructureBuildTypeKHR build_type)
{
    struct small_shape shape;
    return recent->sizes.known && small_shape_of(info, &primitive_count, build_type, &shape) &&
           recent_build_has_shape(recent, &shape);
}

/* Of a build that is like it: whether the rules that read the shape alone hold of it, too. The
 * members of a geometry's data begin alike. */
static inline bool recent_build_holds(const struct recent_build *recent,
                                      const VkAccelerationStructureBuildGeometryInfoKHR *info)
{
    const VkAccelerationStructureGeometryKHR *geometry = build_geometry(info, 0);
    return recent->holds && recent->stype == info->sType && recent->mode == info->mode &&
           recent->geometry_stype == geometry->sType &&
           recent->data_stype == geometry->geometry.triangles.sType;
}

/* Keeps a build, or none where it can't. */
void recent_build_set(struct recent_build *recent,
                      const VkAccelerationStructureBuildGeometryInfoKHR *info,
                      uint32_t primitive_count, VkAccelerationStructureBuildTypeKHR build_type,
                      const struct size_facts *sizes, bool holds);

#endif
