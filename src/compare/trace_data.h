/* SPDX-License-Identifier: Apache-2.0 */
/* Rays that go to a driver, and what it answers: laid out as the shader has them
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
    float t, u, v; /* of AABBs none of them */
    uint32_t kind; /* COMPARE_HIT and more; 0: none */
    uint32_t geometry, primitive, instance, spare;
};

enum { COMPARE_CANDIDATES = 14 };

/* Of an answer that is part of another: not all candidates are there; the nearest triangle is in
 * another instance. */
enum { COMPARE_CUT = 1, COMPARE_ELSEWHERE = 2 };

struct compare_answer {
    struct compare_hit closest; /* of triangles */
    uint32_t candidate_count;   /* different ones, those that there was no room for included */
    uint32_t flags;             /* the host's own: COMPARE_CUT, COMPARE_ELSEWHERE */
    uint32_t spare[6];
    struct compare_hit candidates[COMPARE_CANDIDATES];
};

#endif
