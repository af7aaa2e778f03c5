/* SPDX-License-Identifier: Apache-2.0 */
/* A ray in the space of one structure, prepared for slab tests and for the triangle test of each
 * accuracy. */
#ifndef ASSAY_BVH_TRACE_RAY_H
#define ASSAY_BVH_TRACE_RAY_H

#include "src/bvh/structure.h"
#include "src/bvh/trace.h"
#include "src/bvh/vector.h"

typedef double double4 __attribute__((vector_size(32)));
typedef int64_t int64x4 __attribute__((vector_size(32)));
#define DOUBLE4_ABS(v) ((double4)((int64x4)(v)&INT64_MAX))

/* The distance of a plane is (plane - origin) * scale. Near and far planes have separate origins
 * and scales, padded so that no box is missed. Distances are scaled by 2^24, so that small ones do
 * not become subnormal, where rounding is no longer relative. */
#define SLAB_UNITS 0x1p24
struct slab {
    float4 near_origin, far_origin, near_scale, far_scale;
    int4 near_plane, far_plane; /* offsets within a node, in floats */
    float t_min, t_max;
};

/* The direction is scaled by a power of two so that its largest component is in [1, 2). A distance
 * in this "unit" is exactly the caller's distance times `unit`. */
struct local_ray {
    double origin[4], direction[4]; /* the fourth completes a vector */
    double unit, t_min;             /* t_min is in units */
    /* axis[2] is the direction's largest component; axis[0] and axis[1] preserve the winding. */
    uint32_t axis[3];
    /* near_origin and near_direction: origin and direction in float, for accuracies fast and
     * robust. */
    float4 near_origin, near_direction, shear;
    struct slab slab;
};

/* A hit with a triangle; `t` is in units. */
struct local_hit {
    double t;
    float u, v;
    bool front_face;
};

/* t_max is in units. */
static inline void ray_limit(struct local_ray *local, double t_max)
{
    local->slab.t_max = rounded_up(t_max * SLAB_UNITS);
}

/* For each edge, opposite vertex 0 to 2, a value whose sign says on which side the ray passes,
 * unless its magnitude is within the bound. */
struct exact_edges {
    double value[3], bound;
};

/* Return whether the ray hits the triangle at t_min < t < t_max, in units. The latter two follow
 * the tests of four triangles (four.h). */
bool triangle_fast(const struct local_ray *ray, const struct triangle_record *triangle,
                   double t_max, struct local_hit *hit);
bool triangle_robust(const struct local_ray *ray, const struct triangle_record *triangle,
                     double t_max, struct local_hit *hit);
bool triangle_exact(const struct local_ray *ray, const struct triangle_record *triangle,
                    const struct exact_edges *edges, double t_max, struct local_hit *hit,
                    uint64_t *exact_calls);
/* Return whether the ray enters the shape from outside at t_min <= t <= t_max. For swept spheres u
 * is the position along the axis. */
bool sphere_hit(const struct local_ray *ray, const struct sphere_record *sphere, bool is_exact,
                double t_max, struct local_hit *hit, uint64_t *exact_calls);
bool swept_hit(const struct local_ray *ray, const struct swept_record *swept, bool is_exact,
               double t_max, struct local_hit *hit, uint64_t *exact_calls);
/* Returns whether [t_min, t_max] intersects the ray's interval within the box. t is the start of
 * the intersection. */
bool aabb_hit(const struct local_ray *ray, const struct aabb_record *box, double t_max, double *t);

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

/* traverse.c, which is compiled once for each instruction set: visits the candidates of the scene's
 * structure. */
typedef void scene_walker(struct walk *walk);
scene_walker walk_plain, walk_avx2, walk_avx512;

/* What is known of up to four triangles. Sets have one bit per lane. */
struct four_hits {
    unsigned found; /* the triangles that are hit, and those that their own test has to decide */
    unsigned open;  /* these latter at accuracy robust */
    unsigned front; /* the ray meets their front face */
    float t[4], u[4], v[4]; /* t is in slab units */
    struct exact_edges edges[4];
};

/* A BLAS and the instance that refers to it; NULL if the BLAS is traced directly. Initialize the
 * members one by one: clearing the whole is slow. */
struct view {
    const struct structure_header *blas;
    const struct instance_record *instance;
    struct local_ray ray;
    struct four_hits hits;
    uint32_t lane; /* of the triangle being tested */
};

/* "Ray Opacity Micromap": sets `opaque`, which the instance and the ray may then override. Returns
 * false if the candidate is ignored. */
bool candidate_opacity(struct walk *walk, const struct view *view,
                       const struct triangle_record *triangle, const struct local_hit *local,
                       bool *opaque);

/* Passes a candidate to the visitor. `opaque` in the hit is the value of its geometry or micromap;
 * `t` is in units. */
void candidate_visit(struct walk *walk, struct view *view, struct trace_hit *hit, double t);

#endif
