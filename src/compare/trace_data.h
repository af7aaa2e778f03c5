/* SPDX-License-Identifier: Apache-2.0 */
/* Rays for a driver, and its answers, in the layout of the shaders
 * (layer/compare/shaders/data.glsl). */
#ifndef ASSAY_COMPARE_TRACE_DATA_H
#define ASSAY_COMPARE_TRACE_DATA_H

#include <stdbool.h>
#include <stdint.h>

struct compare_ray {
    float origin[3], t_min;
    float direction[3], t_max;
};

enum { COMPARE_HIT = 1, COMPARE_AABB = 2, COMPARE_FRONT = 4 };

struct compare_hit {
    float t, u, v; /* unset for AABBs */
    uint32_t kind; /* COMPARE_HIT and other flags; 0 if there is no hit */
    uint32_t geometry, primitive, instance, spare;
};

enum { COMPARE_CANDIDATES = 14 };

/* Flags of an answer that was extracted from another. COMPARE_CUT: candidates are missing.
 * COMPARE_ELSEWHERE: the nearest triangle belongs to another instance. */
enum { COMPARE_CUT = 1, COMPARE_ELSEWHERE = 2 };

struct compare_answer {
    struct compare_hit closest; /* nearest triangle */
    uint32_t candidate_count; /* different candidates, including those beyond COMPARE_CANDIDATES */
    uint32_t flags;           /* set by the host: COMPARE_CUT, COMPARE_ELSEWHERE */
    uint32_t spare[6];
    struct compare_hit candidates[COMPARE_CANDIDATES];
};

#endif
