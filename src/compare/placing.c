/* SPDX-License-Identifier: Apache-2.0 */
/* Computes the position of rays relative to primitives, in double: its errors are far below the
 * tolerance. */
#include "src/compare/placing.h"

#include <math.h>
#include <string.h>

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void cross(const double a[3], const double b[3], double to[3])
{
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        to[i] = a[j] * b[k] - a[k] * b[j];
    }
}

static double larger(double a, double b)
{
    return a > b ? a : b;
}

/* Returns the largest absolute coordinate. */
static double scale_of(const struct compare_ray *ray, const float *const corners[], int count)
{
    double scale = 0;
    for (int axis = 0; axis < 3; axis++) {
        scale = larger(scale, fabs((double)ray->origin[axis]));
        for (int i = 0; i < count; i++)
            scale = larger(scale, fabs((double)corners[i][axis]));
    }
    return scale;
}

/* Computes distances from the edges, as seen along the ray: (d . (P x Q)) / |d| is twice the area
 * of the triangle that the origin and the edge form in the plane perpendicular to the ray. */
static void place_edges(const double corners[3][3], const double direction[3], double length,
                        double sign, struct placing *placing)
{
    for (int i = 0; i < 3; i++) {
        const double *p = corners[(i + 1) % 3], *q = corners[(i + 2) % 3];
        double normal[3], edge[3], across[3], to[3], other[3];
        cross(p, q, normal);
        for (int axis = 0; axis < 3; axis++) {
            edge[axis] = q[axis] - p[axis];
            to[axis] = corners[i][axis] - p[axis];
        }
        cross(edge, direction, across);
        double edge_length = sqrt(dot(across, across)) / length;
        cross(edge, to, other);
        placing->inside[i] = sign * dot(direction, normal) / length / edge_length;
        placing->height[i] = sign * dot(direction, other) / length / edge_length;
    }
}

/* Outside the triangle, the distance from it can exceed the distance from the nearest edge's line,
 * which is used here. More rays are then undecided than necessary. */
static enum placing_side side_of(const struct placing *placing)
{
    double least = placing->inside[0];
    for (int i = 1; i < 3; i++)
        least = placing->inside[i] < least ? placing->inside[i] : least;
    if (least < -placing->margin)
        return PLACING_OUT;
    return least > placing->margin && placing->is_within ? PLACING_IN : PLACING_UNDECIDED;
}

void placing_of_triangle(const struct compare_ray *ray, const struct triangle_record *triangle,
                         double scale, struct placing *placing)
{
    const float *const vertices[3] = {triangle->a, triangle->b, triangle->c};
    double corners[3][3], ab[3], ac[3], normal[3];
    const double direction[3] = {ray->direction[0], ray->direction[1], ray->direction[2]};
    *placing = (struct placing){.side = PLACING_UNDECIDED};
    for (int axis = 0; axis < 3; axis++) {
        for (int i = 0; i < 3; i++)
            corners[i][axis] = (double)vertices[i][axis] - ray->origin[axis];
        ab[axis] = corners[1][axis] - corners[0][axis];
        ac[axis] = corners[2][axis] - corners[0][axis];
    }
    cross(ab, ac, normal);
    double length = sqrt(dot(direction, direction)), size = sqrt(dot(normal, normal));
    double along = dot(direction, normal), cosine = fabs(along) / (length * size);
    placing->margin = PLACING_TOLERANCE * larger(scale, scale_of(ray, vertices, 3));
    if (!(cosine >= PLACING_EDGE_ON))
        return;
    place_edges(corners, direction, length, along > 0 ? 1 : -1, placing);
    for (int i = 0; i < 3; i++)
        if (!(placing->height[i] > 4 * placing->margin))
            return;
    placing->is_well_formed = true;
    placing->is_front = along < 0;
    placing->t = dot(corners[0], normal) / along;
    placing->t_tolerance =
        2 * placing->margin / (cosine * length) + PLACING_TOLERANCE * fabs(placing->t);
    placing->u = placing->inside[1] / placing->height[1];
    placing->v = placing->inside[2] / placing->height[2];
    placing->tolerance =
        2 * placing->margin * (1 / placing->height[1] + 1 / placing->height[2]) + PLACING_TOLERANCE;
    placing->is_within = placing->t > ray->t_min + placing->t_tolerance &&
                         placing->t < ray->t_max - placing->t_tolerance;
    placing->side = side_of(placing);
}

/* ---- boxes */

/* For an axis along which the ray does not move: returns whether the ray lies between the faces. */
static bool is_between(double at, double lower, double upper, double margin)
{
    return at > lower + margin && at < upper - margin;
}

/* Requires certainty along the other axes. Along `axis`, dividing by a power of two is exact in any
 * float arithmetic. */
static bool meets_exactly(const struct compare_ray *ray, const struct aabb_record *box, int axis,
                          double margin)
{
    double direction = ray->direction[axis];
    int exponent;
    for (int i = 0; i < 3; i++)
        if (i != axis && !is_between(ray->origin[i], box->lower[i], box->upper[i], margin))
            return false;
    double to[2] = {(double)box->lower[axis] - ray->origin[axis],
                    (double)box->upper[axis] - ray->origin[axis]};
    for (int i = 0; i < 2; i++)
        if ((float)to[i] != to[i])
            return false;
    if (fabs(frexp(direction, &exponent)) != 0.5)
        return false;
    double first = to[0] / direction, last = to[1] / direction;
    double enter = first < last ? first : last, leave = first < last ? last : first;
    return enter <= ray->t_max && leave >= ray->t_min;
}

bool placing_meets_box(const struct compare_ray *ray, const struct aabb_record *box, double scale,
                       bool is_moved)
{
    const float *const corners[2] = {box->lower, box->upper};
    double margin = PLACING_TOLERANCE * larger(scale, scale_of(ray, corners, 2));
    double enter = ray->t_min, leave = ray->t_max;
    int moving = 0, axis = 0;
    for (int i = 0; i < 3; i++) {
        double d = ray->direction[i], at = ray->origin[i];
        double lower = box->lower[i] + margin, upper = box->upper[i] - margin;
        if (!(lower < upper))
            return false;
        if (d == 0) {
            if (!is_between(at, box->lower[i], box->upper[i], margin))
                return false;
            continue;
        }
        moving++;
        axis = i;
        double first = (d > 0 ? lower : upper) - at, last = (d > 0 ? upper : lower) - at;
        enter = larger(enter, first / d);
        leave = last / d < leave ? last / d : leave;
    }
    if (enter < leave)
        return true;
    return moving == 1 && !is_moved && meets_exactly(ray, box, axis, margin);
}
