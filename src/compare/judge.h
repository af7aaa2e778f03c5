/* SPDX-License-Identifier: Apache-2.0 */
/* Decides whether a driver's answer for a ray can be correct.
 *
 * Only what the rules of the specification decide is a difference (docs/compare.md). Hits of the
 * reference are exact: candidates at TRACE_EXACT. */
#ifndef ASSAY_COMPARE_JUDGE_H
#define ASSAY_COMPARE_JUDGE_H

#include "src/bvh/trace.h"
#include "src/compare/rays.h"
#include "src/report/ids/message_id.h"

/* The reason for a judgement. */
enum judge_reason {
    /* By exact arithmetic the ray hits the primitive, away from its boundary. */
    REASON_MEETS,
    REASON_SHARED,    /* the ray passes near an edge or vertex that the triangles of a ring share */
    REASON_PASSES,    /* by exact arithmetic the ray misses the primitive */
    REASON_BEYOND,    /* the primitive's plane lies before tmin or beyond tmax at the ray */
    REASON_INACTIVE,  /* the primitive is inactive */
    REASON_NO_SUCH,   /* the input has no such geometry, primitive or instance */
    REASON_LIMIT,     /* the ray hits a box only at tmin or tmax, which are included */
    REASON_NOT_FIRST, /* another candidate of the driver is nearer */
};

struct judgement {
    enum difference difference;
    enum judge_reason reason;
    uint32_t instance, geometry, primitive; /* the primitive concerned; `instance` is for a TLAS */
    bool has_reference, has_driver;
    struct trace_hit reference;
    struct compare_hit driver;
    /* Exact values for the driver's primitive, if the difference is in them. */
    double t, u, v;
};

/* Returns whether one difference of a ray is more significant than another. DIFFERENCE_COUNT stands
 * for none. */
bool judgement_outweighs(const struct judgement *judgement, const struct judgement *other);

/* Finds the most significant difference of one ray. Returns false if there is none. */
bool judge_ray(const struct reference *reference, const struct rays *rays, uint32_t ray,
               const struct compare_answer *answer, struct judgement *judgement);

/* ---- Whether a ray hits a ring (rays.h) exactly once in any float arithmetic: the triangles face
 * the ray with the same side, none is edge-on, and the ray keeps its distance from the outer
 * boundary of the ring. */

/* Returns whether ray number `ray` certainly hits its ring exactly once. */
bool ring_is_hit_once(const struct reference *reference, const struct rays *rays, uint32_t ray);

#endif
