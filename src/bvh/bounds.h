/* SPDX-License-Identifier: Apache-2.0 */
/* Bounds of records and nodes. */
#ifndef ASSAY_BVH_BOUNDS_H
#define ASSAY_BVH_BOUNDS_H

#include "src/bvh/instance.h"
#include "src/bvh/motion.h"
#include "src/bvh/structure.h"
#include "src/bvh/vector.h"
#include "src/bvh/workers.h"

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

struct box bounds_of_sphere(const float center[3], float radius);

/* `blas` is the structure of an instance and may be NULL. */
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
        return instance_bounds(&instance->instance.transform, blas);
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

/* Computes the bounds of all nodes and of the root from the records. `resolver` finds the
 * structures of instances; an unresolved instance counts as empty. */
void bounds_update(struct structure_header *header, const struct builder_resolver *resolver,
                   struct workers *workers);

#endif
