/* SPDX-License-Identifier: Apache-2.0 */
/* The reference traversal: traces rays against structures of the reference builder.
 *
 * It follows "Ray Traversal" of the Vulkan specification. A ray hits a triangle if tmin < t < tmax.
 * It hits an AABB if [tmin, tmax] intersects the ray's interval within the box, both ends included.
 * It hits a sphere or a linear swept sphere where it enters the shape, if tmin <= t <= tmax.
 * Distances are in units of the direction's length. Traversal uses no memory except its stack; any
 * number of threads may trace one structure. It expects the default floating-point environment of
 * C: rounding to nearest, subnormals not flushed. */
#ifndef ASSAY_BVH_TRACE_H
#define ASSAY_BVH_TRACE_H

#include "src/bvh/micromap.h"

enum trace_accuracy {
    /* Float slab and Moeller-Trumbore (1997): may miss, and may hit a shared edge twice. */
    TRACE_FAST,
    /* Padded slab (Ize 2013), watertight (Woop 2013): may hit a shared edge twice. */
    TRACE_ROBUST,
    /* Exact signs and symbolic ties: hits edges and closed fans exactly once. */
    TRACE_EXACT,
};

/* Values of SPIR-V's Ray Flags. */
enum trace_ray_flag {
    TRACE_OPAQUE = 0x1,
    TRACE_NO_OPAQUE = 0x2,
    TRACE_TERMINATE_ON_FIRST_HIT = 0x4,
    TRACE_CULL_BACK_FACING = 0x10,
    TRACE_CULL_FRONT_FACING = 0x20,
    TRACE_CULL_OPAQUE = 0x40,
    TRACE_CULL_NO_OPAQUE = 0x80,
    /* Also skips spheres and linear swept spheres (SkipBuiltinPrimitivesNV). */
    TRACE_SKIP_TRIANGLES = 0x100,
    TRACE_SKIP_AABBS = 0x200,
    TRACE_FORCE_2_STATE = 0x400, /* opacity micromaps have no unknown states */
};

struct trace_ray {
    float origin[3], t_min;
    float direction[3], t_max;
    /* Only the low 8 bits of cull_mask count. It is unused if a BLAS is traced directly. */
    uint32_t flags, cull_mask;
    float time; /* 0 to 1, for motion */
};

struct trace_hit {
    float t;
    /* Barycentric weights of the second and third vertex, for displaced triangles of the base
     * triangle; 0 for AABBs. */
    float u, v;
    uint32_t geometry, primitive;
    uint32_t instance, custom_index, sbt_offset; /* 0 if a BLAS is traced directly */
    bool is_aabb, front_face, opaque;
    /* For swept spheres, u runs from 0 at the first end to 1 at the last. */
    bool is_sphere, is_swept;
};

/* Counts of the work done. Traversal adds to the existing values. */
struct trace_counters {
    uint64_t nodes, primitives, instances, exact_calls;
    uint64_t micromaps; /* opacity look-ups */
};

/* The instruction sets of traversal. All find the same hits. */
enum trace_vectors {
    TRACE_VECTORS_BEST, /* the best one that the processor has */
    TRACE_VECTORS_AVX2, /* at most AVX2 */
    TRACE_VECTORS_PLAIN,
};

struct trace_scene {
    const void *structure; /* BLAS or TLAS */
    enum trace_accuracy accuracy;
    struct builder_resolver resolver; /* for a TLAS */
    struct trace_counters *counters;  /* may be NULL */
    /* Maps builder_opacity::micromap to the block of a micromap. If it finds none, the triangle has
     * the opacity of its geometry. */
    struct builder_resolver micromaps;
    enum trace_vectors vectors;
};

enum trace_answer {
    TRACE_IGNORE, /* continues as if the candidate did not exist */
    TRACE_ACCEPT, /* continues with nearer candidates only */
    TRACE_STOP,
};

/* Called for each candidate in any order, opaque or not (a ray query of an application would commit
 * opaque triangles without a call). For an AABB, t is the distance at which the ray enters, or
 * tmin; the visitor may replace it with the t of its own shape. */
struct trace_visitor {
    enum trace_answer (*visit)(void *context, struct trace_hit *candidate);
    void *context;
};

void trace_candidates(const struct trace_scene *scene, const struct trace_ray *ray,
                      const struct trace_visitor *visitor);

/* Finds the nearest candidate, or the first candidate found with TRACE_TERMINATE_ON_FIRST_HIT.
 * Every candidate counts as a hit. Returns false if there is none. A ray hits nothing if it
 * contains a NaN, has an infinite origin or direction, a zero direction, or a negative tmin. */
bool trace_closest(const struct trace_scene *scene, const struct trace_ray *ray,
                   struct trace_hit *hit);

#endif
