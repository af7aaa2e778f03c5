/* SPDX-License-Identifier: Apache-2.0 */
/* Rays for an input: aimed at its edges and vertices, at its primitives, and at random. */
#ifndef ASSAY_COMPARE_RAYS_H
#define ASSAY_COMPARE_RAYS_H

#include "src/compare/reference.h"
#include "src/compare/trace_data.h"

enum aim_at {
    AIM_ANYWHERE,  /* within the bounds */
    AIM_PRIMITIVE, /* a point of it */
    AIM_EDGE,      /* from `corner` to the next one */
    AIM_VERTEX,    /* `corner` */
    AIM_LIMIT,     /* a face of a box, which the ray meets exactly at tmin or tmax */
};

struct aim {
    enum aim_at at;
    uint32_t geometry, primitive, corner;
};

/* Triangles that meet at an edge or around a vertex. */
enum { RING_MAX = 24 };
struct ring {
    uint32_t geometry, count; /* 0: nothing is promised there */
    uint32_t primitives[RING_MAX];
};

/* One of each a ray; owned. The same input and count, the same rays. */
struct rays {
    uint32_t count;
    struct compare_ray *rays;
    struct aim *aims;
    struct ring *rings; /* of aims at edges and vertices */
    double scale;       /* what is rounded is at least as large as this */
    bool is_moved;      /* by a transform, so that nothing is exact in the driver's arithmetic */
};

VkResult rays_create(const struct reference *reference, uint32_t count, struct rays *rays);
void rays_free(struct rays *rays);

/* Fills in the fans (fans.c): edges that exactly two triangles of one geometry share in opposite
 * directions, vertices around which triangles of one geometry form one closed ring. */
VkResult rays_find_rings(const struct reference *reference, struct rays *rays);

#endif
