/* SPDX-License-Identifier: Apache-2.0 */
/* What becomes of something that a ray meets: opacity, culling, and the visitor's answer
 * ("Ray Intersection Culling"). */
#ifndef ASSAY_BVH_TRACE_CANDIDATE_H
#define ASSAY_BVH_TRACE_CANDIDATE_H

#include "src/bvh/trace/ray.h"

struct walk {
    const struct trace_scene *scene;
    const struct trace_ray *ray;
    const struct trace_visitor *visitor;
    struct trace_counters counters;
    double t_max; /* in the caller's distances; what has been accepted shortens it */
    bool is_stopped;
};

/* The instance that a BLAS is seen through; NULL: none. */
struct view {
    const struct structure_header *blas;
    const struct instance_record *instance;
    struct local_ray ray;
};

/* "Ray Opacity Micromap": sets what the instance and the ray may then override; false: ignored. */
bool candidate_opacity(struct walk *walk, const struct view *view,
                       const struct triangle_record *triangle, const struct local_hit *local,
                       bool *opaque);

/* `opaque` in the hit is what its geometry or micromap says; `t` in the caller's distances. */
void candidate_offer(struct walk *walk, struct view *view, struct trace_hit *hit, double t);

#endif
