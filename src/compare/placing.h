/* SPDX-License-Identifier: Apache-2.0 */
/* The position of a ray relative to a primitive, and its certainty.
 *
 * The specification defines no precision for intersections, so a driver is only held to the
 * accuracy of any float arithmetic: a result within PLACING_TOLERANCE of a boundary, relative to
 * the largest coordinate of the ray's origin and the primitive, is undecided. */
#ifndef ASSAY_COMPARE_PLACING_H
#define ASSAY_COMPARE_PLACING_H

#include "src/bvh/structure.h"
#include "src/compare/trace_data.h"

#define PLACING_TOLERANCE 0x1p-16 /* 256 times the rounding error of a float */
#define PLACING_EDGE_ON 0x1p-6    /* the smallest cosine between ray and normal that is judged */

enum placing_side {
    PLACING_OUT,       /* certain */
    PLACING_UNDECIDED, /* near a boundary or a limit, edge-on, or a primitive without area */
    PLACING_IN,        /* certain */
};

struct placing {
    enum placing_side side;
    bool is_well_formed;    /* neither edge-on nor without area; the members below are valid */
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

#endif
