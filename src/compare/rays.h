/* SPDX-License-Identifier: Apache-2.0 */
/* Rays, what hits them, and where they lie relative to primitives. */
#ifndef ASSAY_COMPARE_RAYS_H
#define ASSAY_COMPARE_RAYS_H

#include <stdbool.h>
#include <stdint.h>

#include "src/bvh/structure.h"
#include "src/compare/input.h"

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

/* ---- The position of a ray relative to a primitive, and its certainty.
 *
 * The specification defines no precision for intersections, so a driver is only held to the
 * accuracy of any float arithmetic: a result within PLACING_TOLERANCE of a boundary, relative to
 * the largest coordinate of the ray's origin and the primitive, is undecided. */

#define PLACING_TOLERANCE 0x1p-16 /* 256 times the rounding error of a float */

enum placing_side {
    PLACING_OUT,       /* certain */
    PLACING_UNDECIDED, /* near a boundary or a limit, edge-on, or a primitive without area */
    PLACING_IN,        /* certain */
};

struct placing {
    enum placing_side side;
    bool is_well_formed;    /* not edge-on, nor without area, nor too far; those below are valid */
    double t, t_tolerance;  /* distance at which the ray hits the plane */
    double u, v, tolerance; /* barycentrics and their tolerance */
    bool is_front;
    double inside[3]; /* distance of the ray from the edge opposite each vertex; negative outside */
    double height[3]; /* distance of the vertex from that edge; both as seen along the ray */
    double margin;    /* distances below this are undecided */
    bool is_within;   /* t certainly lies between tmin and tmax */
};

/* `scale` is the magnitude of other numbers that the driver rounds, beside the coordinates; or
 * 0. */
void placing_of_triangle(const struct compare_ray *ray, const struct triangle_record *triangle,
                         double scale, struct placing *placing);
/* Returns whether the ray certainly hits a box, whose faces are included. */
bool placing_meets_box(const struct compare_ray *ray, const struct aabb_record *box, double scale,
                       bool is_moved);

/* ---- rays for an input: aimed at its edges and vertices, at its primitives, and at random */

enum aim_at {
    AIM_ANYWHERE,  /* a point within the bounds */
    AIM_PRIMITIVE, /* a point of a primitive */
    AIM_EDGE,      /* the edge from `corner` to the next corner */
    AIM_VERTEX,    /* the vertex `corner` */
    /* A face of a box that the ray hits exactly at tmin or tmax. */
    AIM_LIMIT,
};

struct aim {
    enum aim_at at;
    uint32_t geometry, primitive, corner;
};

/* Triangles that share an edge or surround a vertex. */
enum { RING_MAX = 24 };
struct ring {
    uint32_t geometry, count; /* 0 if the specification guarantees nothing at this point */
    uint32_t primitives[RING_MAX];
};

/* Arrays with one element per ray; owned. The same input and count give the same rays. */
struct rays {
    uint32_t count;
    struct compare_ray *rays;
    struct aim *aims;
    struct ring *rings; /* for aims at edges and vertices */
    double scale;       /* minimum magnitude of the numbers that a driver rounds */
    bool is_moved; /* the rays are transformed, so nothing is exact in the driver's arithmetic */
};

/* Creates at most `count` rays. Returns VK_ERROR_OUT_OF_HOST_MEMORY if memory runs out. The caller
 * calls rays_free(), also after a failure. */
VkResult rays_create(const struct reference *reference, uint32_t count, struct rays *rays);
void rays_free(struct rays *rays);

/* Fills the rings (vertex_rings.c): edges that exactly two triangles of one geometry share in
 * opposite directions, and vertices around which triangles of one geometry form one closed ring. */
VkResult rays_find_rings(const struct reference *reference, struct rays *rays);

#endif
