/* SPDX-License-Identifier: Apache-2.0 */
/* A ray in the space of one structure, prepared for slab tests and for the triangle test of each
 * accuracy. */
#ifndef ASSAY_BVH_TRACE_RAY_H
#define ASSAY_BVH_TRACE_RAY_H

#include "src/bvh/structure.h"
#include "src/bvh/trace.h"
#include "src/bvh/vector.h"

struct slab {
    float4 near_origin[3], far_origin[3], near_scale[3], far_scale[3];
    uint32_t near_plane[3], far_plane[3]; /* offsets within a node, in floats */
    float t_min, t_max;
};

/* The direction is scaled by a power of two so that its largest component is in [1, 2). A distance
 * in this "unit" is exactly the caller's distance times `unit`. */
struct local_ray {
    double origin[3], direction[3];
    double unit, t_min; /* t_min is in units */
    /* axis[2] is the direction's largest component; axis[0] and axis[1] preserve the winding. */
    uint32_t axis[3];
    /* near_origin and near_direction: origin and direction in float, for accuracies fast and
     * robust. */
    float near_origin[3];
    float near_direction[3], shear[3];
    struct slab slab;
};

/* A hit with a triangle; `t` is in units. */
struct local_hit {
    double t;
    float u, v;
    bool front_face;
};

/* Returns false if the ray cannot hit anything. `is_world` pads for the rounding of rays that enter
 * instances. */
bool ray_make(struct local_ray *local, const struct trace_ray *ray, enum trace_accuracy accuracy,
              bool is_world);
/* Returns false if the matrix of the instance is singular. */
bool ray_enter(struct local_ray *local, const struct trace_ray *ray, enum trace_accuracy accuracy,
               const struct instance_record *instance);
void ray_limit(struct local_ray *local, double t_max); /* t_max is in the caller's distances */

/* Return whether the ray hits the triangle at t_min < t < t_max, in units. */
bool triangle_fast(const struct local_ray *ray, const struct triangle_record *triangle,
                   double t_max, struct local_hit *hit);
bool triangle_robust(const struct local_ray *ray, const struct triangle_record *triangle,
                     double t_max, struct local_hit *hit);
bool triangle_exact(const struct local_ray *ray, const struct triangle_record *triangle,
                    double t_max, struct local_hit *hit, uint64_t *exact_calls);
/* Return whether the ray enters the shape from outside at t_min <= t <= t_max. For swept spheres u
 * is the position along the axis. */
bool sphere_hit(const struct local_ray *ray, const struct sphere_record *sphere, bool is_exact,
                double t_max, struct local_hit *hit, uint64_t *exact_calls);
bool swept_hit(const struct local_ray *ray, const struct swept_record *swept, bool is_exact,
               double t_max, struct local_hit *hit, uint64_t *exact_calls);
/* Returns whether [t_min, t_max] intersects the ray's interval within the box. t is the start of
 * the intersection. */
bool aabb_hit(const struct local_ray *ray, const struct aabb_record *box, double t_max, double *t);

/* Returns one bit for each child whose box the ray may hit, and the entry distances. If a ray lies
 * in a plane, 0 times infinity gives NaN, which leaves the interval unchanged. */
static inline unsigned slab_test(const struct slab *slab, const struct wide_node *node,
                                 float4 *enter)
{
    const float *planes = &node->lower[0][0];
    float4 near = float4_all(slab->t_min), far = float4_all(slab->t_max);
    for (int axis = 0; axis < 3; axis++) {
        float4 low = float4_load(planes + slab->near_plane[axis]) - slab->near_origin[axis];
        float4 high = float4_load(planes + slab->far_plane[axis]) - slab->far_origin[axis];
        near = float4_max(low * slab->near_scale[axis], near);
        far = float4_min(high * slab->far_scale[axis], far);
    }
    /* A distance that overflowed to infinity was finite; `far` is then infinite, too. */
    near = float4_min(near, float4_all(FLT_MAX));
    *enter = near;
    return int4_mask(near <= far);
}

/* ---- Processes a candidate: opacity, culling, and the visitor's answer ("Ray Intersection
 * Culling"). */

struct walk {
    const struct trace_scene *scene;
    const struct trace_ray *ray;
    const struct trace_visitor *visitor;
    struct trace_counters counters;
    double t_max; /* in the caller's distances; an accepted hit reduces it */
    bool is_stopped;
};

/* A BLAS and the instance that refers to it; NULL if the BLAS is traced directly. */
struct view {
    const struct structure_header *blas;
    const struct instance_record *instance;
    struct local_ray ray;
};

/* "Ray Opacity Micromap": sets `opaque`, which the instance and the ray may then override. Returns
 * false if the candidate is ignored. */
bool candidate_opacity(struct walk *walk, const struct view *view,
                       const struct triangle_record *triangle, const struct local_hit *local,
                       bool *opaque);

/* Passes a candidate to the visitor. `opaque` in the hit is the value of its geometry or micromap;
 * `t` is in the caller's distances. */
void candidate_visit(struct walk *walk, struct view *view, struct trace_hit *hit, double t);

#endif
