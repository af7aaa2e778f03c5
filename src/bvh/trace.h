/* SPDX-License-Identifier: Apache-2.0 */
/* The reference traversal: rays against a structure of the reference builder.
 *
 * Follows "Ray Traversal" of the Vulkan specification: triangles are hit where tmin < t < tmax,
 * AABBs where [tmin, tmax] meets the ray's interval within the box, both ends included; spheres,
 * swept or not, where the ray enters them, at tmin <= t <= tmax. Distances
 * are in units of the direction's length. Uses no memory but its stack; any number of threads may
 * trace one structure. Expects the floating-point environment that C starts with: rounding to
 * nearest, subnormals not flushed. */
#ifndef ASSAY_BVH_TRACE_H
#define ASSAY_BVH_TRACE_H

#include "src/bvh/micromap.h"

enum trace_accuracy {
    TRACE_FAST,   /* float slab and Moeller-Trumbore (1997): may miss, and count edges twice */
    TRACE_ROBUST, /* padded slab (Ize 2013), watertight (Woop 2013): edges may count twice */
    TRACE_EXACT,  /* exact signs and symbolic ties: edges and closed fans count exactly once */
};

/* Values of SPIR-V's Ray Flags */
enum trace_ray_flag {
    TRACE_OPAQUE = 0x1,
    TRACE_NO_OPAQUE = 0x2,
    TRACE_TERMINATE_ON_FIRST_HIT = 0x4,
    TRACE_CULL_BACK_FACING = 0x10,
    TRACE_CULL_FRONT_FACING = 0x20,
    TRACE_CULL_OPAQUE = 0x40,
    TRACE_CULL_NO_OPAQUE = 0x80,
    TRACE_SKIP_TRIANGLES = 0x100, /* and spheres, swept or not (SkipBuiltinPrimitivesNV) */
    TRACE_SKIP_AABBS = 0x200,
    TRACE_FORCE_2_STATE = 0x400, /* opacity micromaps are never unsure */
};

struct trace_ray {
    float origin[3], t_min;
    float direction[3], t_max;
    uint32_t flags, cull_mask; /* of the cull mask the low 8 bits; unused for a BLAS by itself */
    float time;                /* from 0 to 1, for what moves */
};

struct trace_hit {
    float t;
    float u, v; /* weights of the second and third vertex, of the base where it is displaced; 0 for
                   AABBs */
    uint32_t geometry, primitive;
    uint32_t instance, custom_index, sbt_offset; /* 0 for a BLAS by itself */
    bool is_aabb, front_face, opaque;
    bool is_sphere, is_swept; /* u of the latter: 0 to 1 from its first end to its last */
};

/* Counts of what was done, added to what is there. */
struct trace_counters {
    uint64_t nodes, primitives, instances, exact_calls;
    uint64_t micromaps; /* opacities that were looked up */
};

struct trace_scene {
    const void *structure; /* BLAS or TLAS */
    enum trace_accuracy accuracy;
    struct builder_resolver resolver; /* for a TLAS */
    struct trace_counters *counters;  /* may be NULL */
    /* From builder_opacity::micromap to a micromap's block; triangles of those that it doesn't know
     * are as opaque as their geometry. */
    struct builder_resolver micromaps;
};

enum trace_answer {
    TRACE_IGNORE, /* goes on as if it hadn't been there */
    TRACE_ACCEPT, /* goes on with what is nearer */
    TRACE_STOP,
};

/* Called for each candidate, in any order, opaque or not (an application's ray query would accept
 * opaque triangles unasked). The t of an AABB is where the ray enters, or tmin; the visitor may
 * write the t that its shape has. */
struct trace_visitor {
    enum trace_answer (*visit)(void *context, struct trace_hit *candidate);
    void *context;
};

void trace_candidates(const struct trace_scene *scene, const struct trace_ray *ray,
                      const struct trace_visitor *visitor);

/* The nearest candidate, or the first found with TRACE_TERMINATE_ON_FIRST_HIT; every candidate
 * counts as a hit. A ray with a NaN, an infinite origin or direction, no direction or a negative
 * tmin hits nothing. */
bool trace_closest(const struct trace_scene *scene, const struct trace_ray *ray,
                   struct trace_hit *hit);

#endif
