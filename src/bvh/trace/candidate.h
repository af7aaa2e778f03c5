/* SPDX-License-Identifier: Apache-2.0 */
/* Processes a candidate: opacity, culling, and the visitor's answer ("Ray Intersection
 * Culling"). */
#ifndef ASSAY_BVH_TRACE_CANDIDATE_H
#define ASSAY_BVH_TRACE_CANDIDATE_H

#include "src/bvh/trace/ray.h"

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
