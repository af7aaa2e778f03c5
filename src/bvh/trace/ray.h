/* SPDX-License-Identifier: Apache-2.0 */
/* A ray in one structure's space, prepared for slabs and for each accuracy's triangle test. */
#ifndef ASSAY_BVH_TRACE_RAY_H
#define ASSAY_BVH_TRACE_RAY_H

#include "src/bvh/structure.h"
#include "src/bvh/trace.h"
#include "src/bvh/vector.h"

/* Each plane's distance is (plane - origin) * scale. Near and far planes have origins and scales of
 * their own, which are padded so that no box is missed. Distances are 2^24 unit distances: so small
 * ones don't become subnormal, where rounding is no longer relative. */
#define SLAB_UNITS 0x1p24
struct slab {
    float4 near_origin[3], far_origin[3], near_scale[3], far_scale[3];
    uint32_t near_plane[3], far_plane[3]; /* where in a node: floats from its start on */
    float t_min, t_max;
};

/* The direction is scaled by a power of two so that its largest component is in [1, 2); distances
 * in this "unit" are the caller's times `unit`, exactly. */
struct local_ray {
    double origin[3], direction[3];
    double unit, t_min; /* t_min in units */
    /* axes: [2] is the direction's largest component; [0] and [1] keep the winding */
    uint32_t axis[3];
    float near_origin[3]; /* origin and direction in float, for accuracies fast and robust */
    float near_direction[3], shear[3];
    struct slab slab;
};

/* A triangle as hit: distance in units. */
struct local_hit {
    double t;
    float u, v;
    bool front_face;
};

/* False for a ray that can hit nothing. `is_world` pads for the rounding of rays that go on into
 * instances. */
bool ray_make(struct local_ray *local, const struct trace_ray *ray, enum trace_accuracy accuracy,
              bool is_world);
/* False where the instance's matrix is singular. */
bool ray_enter(struct local_ray *local, const struct trace_ray *ray, enum trace_accuracy accuracy,
               const struct instance_record *instance);
void ray_limit(struct local_ray *local, double t_max); /* in the caller's distances */

/* Whether the line meets the triangle at all at t_min < t < t_max (in units). */
bool triangle_fast(const struct local_ray *ray, const struct triangle_record *triangle,
                   double t_max, struct local_hit *hit);
bool triangle_robust(const struct local_ray *ray, const struct triangle_record *triangle,
                     double t_max, struct local_hit *hit);
bool triangle_exact(const struct local_ray *ray, const struct triangle_record *triangle,
                    double t_max, struct local_hit *hit, uint64_t *exact_calls);
/* Where the ray enters from outside, at t_min <= t <= t_max; u is the place along a swept one. */
bool sphere_hit(const struct local_ray *ray, const struct sphere_record *sphere, bool is_exact,
                double t_max, struct local_hit *hit, uint64_t *exact_calls);
bool swept_hit(const struct local_ray *ray, const struct swept_record *swept, bool is_exact,
               double t_max, struct local_hit *hit, uint64_t *exact_calls);
/* Where [t_min, t_max] and the ray's interval within the box meet; t is where that begins. */
bool aabb_hit(const struct local_ray *ray, const struct aabb_record *box, double t_max, double *t);

/* A bit for each child whose box the ray may meet, and where it enters. NaN, which is 0 times
 * infinity where a ray runs in a plane, leaves the interval as it was. */
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
    /* What overflowed was still finite, and far is then infinite. */
    near = float4_min(near, float4_all(FLT_MAX));
    *enter = near;
    return int4_mask(near <= far);
}

#endif
