/* SPDX-License-Identifier: Apache-2.0 */
/* Bounds of records, nodes and instances. */
#ifndef ASSAY_BUILD_BOUNDS_H
#define ASSAY_BUILD_BOUNDS_H

#include "build/motion.h"
#include "build/structure.h"
#include "build/vector.h"
#include "build/workers.h"

static inline float4 bounds_point(const float position[3])
{
    return (float4){position[0], position[1], position[2], 0};
}

static inline struct box bounds_of_triangle(const struct triangle_record *record)
{
    struct box box = box_empty();
    float4 a = bounds_point(record->a), b = bounds_point(record->b), c = bounds_point(record->c);
    box_add(&box, a, a);
    box_add(&box, b, b);
    box_add(&box, c, c);
    return box;
}

/* World bounds of an instance, wide enough for every point of its structure and for the rounding of
 * rays that traversal takes into its space; a point where the structure is empty. */
struct box bounds_of_instance(const VkTransformMatrixKHR *transform, const void *blas);
/* The same for all matrices whose elements are from `low` to `high`. */
struct box bounds_of_matrices(double low[3][4], double high[3][4], const void *blas);

struct box bounds_of_sphere(const float center[3], float radius);

/* `blas` is that of an instance, and may be NULL. */
static ALWAYS_INLINE struct box bounds_of_record(enum structure_kind kind, const void *record,
                                                 const void *blas)
{
    switch (kind) {
    case STRUCTURE_TRIANGLES:
    case STRUCTURE_DENSE:
    case STRUCTURE_DISPLACED:
        return bounds_of_triangle(record);
    case STRUCTURE_AABBS: {
        const struct aabb_record *aabb = record;
        return (struct box){bounds_point(aabb->lower), bounds_point(aabb->upper)};
    }
    case STRUCTURE_INSTANCES: {
        const struct instance_record *instance = record;
        return bounds_of_instance(&instance->instance.transform, blas);
    }
    case STRUCTURE_MOTION_TRIANGLES:
    case STRUCTURE_MOTION_DISPLACED: {
        const struct motion_triangle_record *moving = record;
        struct box box = bounds_of_triangle(&moving->at[0]);
        struct box then = bounds_of_triangle(&moving->at[1]);
        box_add(&box, then.lower, then.upper);
        return box;
    }
    case STRUCTURE_MOTION_INSTANCES:
        return motion_bounds(record, blas);
    case STRUCTURE_SPHERES: {
        const struct sphere_record *sphere = record;
        return bounds_of_sphere(sphere->center, sphere->radius);
    }
    case STRUCTURE_SWEPT_SPHERES: {
        const struct swept_record *swept = record;
        struct box box = bounds_of_sphere(swept->a, swept->radius[0]);
        struct box other = bounds_of_sphere(swept->b, swept->radius[1]);
        box_add(&box, other.lower, other.upper);
        return box;
    }
    }
    return box_empty();
}

/* Bounds of all nodes and of the root from the records. For instances, `resolver` finds their
 * structures; those that it doesn't find count as empty. */
void bounds_update(struct structure_header *header, const struct builder_resolver *resolver,
                   struct workers *workers);

#endif
