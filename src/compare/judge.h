/* SPDX-License-Identifier: Apache-2.0 */
/* Whether what a driver says of a ray can be right.
 *
 * Only what the specification's rules decide is a difference (docs/compare.md). Hits of the
 * reference are exact: candidates at TRACE_EXACT. */
#ifndef ASSAY_COMPARE_JUDGE_H
#define ASSAY_COMPARE_JUDGE_H

#include "src/bvh/trace.h"
#include "src/compare/placing.h"
#include "src/compare/rays.h"
#include "src/report/difference.h"

/* Why the verdict stands. */
enum judge_reason {
    REASON_MEETS,     /* by exact arithmetic the ray meets the primitive, not near its boundary */
    REASON_SHARED,    /* it passes near an edge or vertex that the fan's triangles share */
    REASON_PASSES,    /* by exact arithmetic it doesn't meet the primitive */
    REASON_BEYOND,    /* the primitive's plane lies before tmin or behind tmax there */
    REASON_INACTIVE,  /* the primitive is inactive */
    REASON_NO_SUCH,   /* the input has no such geometry, primitive or instance */
    REASON_LIMIT,     /* a box is met at tmin or tmax itself, which count */
    REASON_NOT_FIRST, /* another candidate of the driver's own is nearer */
};

struct judgement {
    enum difference difference;
    enum judge_reason reason;
    uint32_t instance, geometry, primitive; /* that it is about; the instance of a TLAS */
    bool has_reference, has_driver;
    struct trace_hit reference;
    struct compare_hit driver;
    double t, u, v; /* exact ones of the driver's primitive, where the difference is in them */
};

/* Of two differences of one ray; DIFFERENCE_COUNT is none. */
bool judgement_outweighs(const struct judgement *judgement, const struct judgement *other);

/* Of one ray the most telling difference; false: none. */
bool judge_ray(const struct reference *reference, const struct rays *rays, uint32_t ray,
               const struct compare_answer *answer, struct judgement *judgement);

#endif
