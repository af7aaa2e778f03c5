/* SPDX-License-Identifier: Apache-2.0 */
/* Rays for an input: aimed at its edges and vertices, at its primitives, and at random. */
#ifndef ASSAY_COMPARE_RAYS_H
#define ASSAY_COMPARE_RAYS_H

#include "src/compare/reference.h"
#include "src/compare/trace_data.h"

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
