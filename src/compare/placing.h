/* SPDX-License-Identifier: Apache-2.0 */
/* Where a ray passes a primitive, with how sure one may be of it.
 *
 * The specification names no precision of intersections, so a driver is held to what any float
 * arithmetic gives: what lies within PLACING_TOLERANCE of a boundary, relative to the largest
 * coordinate of the ray's origin and the primitive, is open. */
#ifndef ASSAY_COMPARE_PLACING_H
#define ASSAY_COMPARE_PLACING_H

#include "src/bvh/structure.h"
#include "src/compare/trace_data.h"

#define PLACING_TOLERANCE 0x1p-16 /* 256 times the rounding of a float */
#define PLACING_EDGE_ON 0x1p-6    /* the least cosine of ray and normal that is judged */

enum placing_side {
    PLACING_OUT,  /* for certain */
    PLACING_OPEN, /* near a boundary or a limit, edge-on, or a primitive without area */
    PLACING_IN,   /* for certain */
};

struct placing {
    enum placing_side side;
    bool is_well_formed;    /* neither edge-on nor without area: */
    double t, t_tolerance;  /* where it meets the plane */
    double u, v, tolerance; /* of the barycentrics */
    bool is_front;
    double inside[3]; /* the ray's distance from the edge opposite each vertex, negative outside, */
    double height[3]; /* and the vertex's, both seen along the ray */
    double open;      /* what is open in such distances */
    bool is_within;   /* t lies between tmin and tmax for certain */
};

/* `scale`: beside coordinates, what the driver rounds is as large as this; or 0. */
void placing_of_triangle(const struct compare_ray *ray, const struct triangle_record *triangle,
                         double scale, struct placing *placing);
/* Whether the ray meets a box for certain, by the inclusive test. */
bool placing_meets_box(const struct compare_ray *ray, const struct aabb_record *box, double scale,
                       bool is_moved);

#endif
