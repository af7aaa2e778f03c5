/* SPDX-License-Identifier: Apache-2.0 */
/* Records of primitives: their bounds, and how they are read. */
#ifndef ASSAY_BVH_RECORDS_H
#define ASSAY_BVH_RECORDS_H

#include "src/bvh/input/displaced.h"
#include "src/bvh/input/source.h"
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

/* ---- records: the data of a primitive in the form that traversal reads */

#define RECORD_CHUNK 4096u /* records that a thread writes at a time */

union any_record {
    struct triangle_record triangle;
    struct aabb_record aabb;
    struct instance_record instance;
    struct motion_triangle_record motion_triangle;
    struct motion_instance_record motion_instance;
    struct sphere_record sphere;
    struct swept_record swept;
    struct dense_record dense;
    struct displaced_record displaced;
    struct motion_displaced_record motion_displaced;
};

/* Inline, so that loops over one kind of record, if the kind is a constant, test it only once. */

/* Reads the positions or the instance from application memory. */
static ALWAYS_INLINE enum source_state record_read(const struct builder_input *input,
                                                   enum structure_kind kind,
                                                   const struct source *source, uint32_t primitive,
                                                   union any_record *record)
{
    switch (kind) {
    case STRUCTURE_TRIANGLES:
        return source_triangle(source, primitive, &record->triangle);
    case STRUCTURE_AABBS:
        return source_aabb(source, primitive, &record->aabb);
    case STRUCTURE_INSTANCES:
        return source_instance(source, primitive, &input->memory, &record->instance);
    case STRUCTURE_MOTION_TRIANGLES:
        return source_motion_triangle(source, primitive, &record->motion_triangle);
    case STRUCTURE_MOTION_INSTANCES:
        return source_motion_instance(source, primitive, &input->memory, &record->motion_instance);
    case STRUCTURE_SPHERES:
        return source_sphere(source, primitive, &record->sphere);
    case STRUCTURE_SWEPT_SPHERES:
        return source_swept(source, primitive, &record->swept);
    case STRUCTURE_DENSE:
        return source_dense(source, primitive, &record->dense);
    case STRUCTURE_DISPLACED:
        return displaced_read(source, primitive, &record->displaced);
    case STRUCTURE_MOTION_DISPLACED:
        return displaced_read_motion(source, primitive, &record->motion_displaced);
    }
    return SOURCE_INACTIVE;
}

/* As record_read(), and resolves the reference of an instance. Returns SOURCE_UNRESOLVED if the
 * resolver does not find it. */
static ALWAYS_INLINE enum source_state record_resolve(const struct builder_input *input,
                                                      enum structure_kind kind,
                                                      const struct source *source,
                                                      uint32_t primitive, union any_record *record,
                                                      const void **blas)
{
    const struct builder_resolver *resolver = &input->resolver;
    enum source_state found = record_read(input, kind, source, primitive, record);
    *blas = NULL;
    if (found != SOURCE_ACTIVE || !structure_is_top(kind))
        return found;
    *blas =
        resolver->find(resolver->context, record->instance.instance.accelerationStructureReference);
    return *blas ? SOURCE_ACTIVE : SOURCE_UNRESOLVED;
}

/* `number` is the index into the opacities. */
static ALWAYS_INLINE void finish_triangle(struct builder_place place, const struct source *source,
                                          uint32_t number, struct triangle_record *triangle)
{
    triangle->geometry = place.geometry;
    triangle->primitive = place.primitive;
    triangle->opacity = source->opacity.is_present ? source_opacity(source, number) : 0;
}

static ALWAYS_INLINE void finish_displaced(struct builder_place place, const struct source *source,
                                           struct triangle_record *triangle)
{
    place.primitive = triangle->primitive;
    finish_triangle(place, source, place.primitive, triangle);
}

/* Completes a record that was read: the numbers, the opacity of a triangle, the inverse of an
 * instance. */
static ALWAYS_INLINE void record_finish(enum structure_kind kind, struct builder_place place,
                                        const struct source *source, union any_record *record)
{
    switch (kind) {
    case STRUCTURE_TRIANGLES:
        finish_triangle(place, source, place.primitive, &record->triangle);
        return;
    case STRUCTURE_MOTION_TRIANGLES:
        finish_triangle(place, source, place.primitive, &record->motion_triangle.at[0]);
        finish_triangle(place, source, place.primitive, &record->motion_triangle.at[1]);
        return;
    case STRUCTURE_DENSE:
        finish_triangle(place, source, record->dense.primitive, &record->dense.triangle);
        return;
    case STRUCTURE_DISPLACED: /* the record already has the number of the base triangle */
        finish_displaced(place, source, &record->displaced.triangle);
        return;
    case STRUCTURE_MOTION_DISPLACED:
        finish_displaced(place, source, &record->motion_displaced.triangle.at[0]);
        finish_displaced(place, source, &record->motion_displaced.triangle.at[1]);
        return;
    case STRUCTURE_AABBS:
    case STRUCTURE_SPHERES:
    case STRUCTURE_SWEPT_SPHERES:
        record->aabb.geometry = place.geometry; /* all three store the numbers at the same offset */
        record->aabb.primitive = place.primitive;
        return;
    case STRUCTURE_MOTION_INSTANCES:
        motion_instance_at(&record->motion_instance, 0, &record->instance);
        /* fall through */
    case STRUCTURE_INSTANCES:
        instance_invert(&record->instance.instance.transform, record->instance.inverse);
        record->instance.primitive = place.primitive;
        record->instance.spare = 0;
        return;
    }
}

#endif
