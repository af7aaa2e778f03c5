/* SPDX-License-Identifier: Apache-2.0 */
/* Rays that pass near a shared edge or the vertex of a closed ring. */
#include "src/compare/vertex_ring.h"

#include <math.h>
#include <string.h>

#include "src/compare/placing.h"

struct ring_view {
    const struct compare_ray *ray;
    double scale; /* as in struct rays */
    bool is_edge;
    float at[3], end[3]; /* the vertex, or both ends of the edge */
    double angle;        /* sum of the angles around the vertex, as seen along the ray */
    double nearest_edge; /* the smallest height over the outer edges */
    double margin;
};

static bool same_position(const float a[3], const float b[3])
{
    return a[0] == b[0] && a[1] == b[1] && a[2] == b[2];
}

/* Returns the corner at the vertex or, for an edge, the corner that is not on it. */
static int special_corner(const struct ring_view *view, const float *const corners[3])
{
    for (int i = 0; i < 3; i++) {
        bool is_at = same_position(corners[i], view->at);
        if (view->is_edge ? !is_at && !same_position(corners[i], view->end) : is_at)
            return i;
    }
    return 0;
}

/* Returns the distance between the ray and the vertex. */
static double distance_from(const struct compare_ray *ray, const float at[3])
{
    double square = 0, length = 0;
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        double part = ((double)at[j] - ray->origin[j]) * ray->direction[k] -
                      ((double)at[k] - ray->origin[k]) * ray->direction[j];
        square += part * part;
        length += (double)ray->direction[i] * ray->direction[i];
    }
    return sqrt(square / length);
}

/* Returns the angle between the two edges of a corner, as seen along the ray. */
static double angle_of(const struct compare_ray *ray, const float *const corners[3], int corner)
{
    double e[3], f[3], ef = 0, ed = 0, fd = 0, dd = 0, turn = 0;
    for (int i = 0; i < 3; i++) {
        double d = ray->direction[i];
        e[i] = (double)corners[(corner + 1) % 3][i] - corners[corner][i];
        f[i] = (double)corners[(corner + 2) % 3][i] - corners[corner][i];
        ef += e[i] * f[i];
        ed += e[i] * d;
        fd += f[i] * d;
        dd += d * d;
    }
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        turn += ray->direction[i] * (e[j] * f[k] - e[k] * f[j]);
    }
    return atan2(fabs(turn) / sqrt(dd), ef - ed * fd / dd);
}

static bool add_triangle(struct ring_view *view, const struct triangle_record *triangle,
                         bool *is_front, bool is_first)
{
    const float *const corners[3] = {triangle->a, triangle->b, triangle->c};
    struct placing placing;
    placing_of_triangle(view->ray, triangle, view->scale, &placing);
    if (!placing.is_well_formed || !placing.is_within ||
        (!is_first && placing.is_front != *is_front))
        return false;
    *is_front = placing.is_front;
    int corner = special_corner(view, corners);
    if (view->is_edge)
        return placing.inside[(corner + 1) % 3] > placing.margin &&
               placing.inside[(corner + 2) % 3] > placing.margin;
    view->angle += angle_of(view->ray, corners, corner);
    if (placing.height[corner] < view->nearest_edge)
        view->nearest_edge = placing.height[corner];
    if (placing.margin > view->margin)
        view->margin = placing.margin;
    return true;
}

bool ring_is_hit_once(const struct reference *reference, const struct rays *rays, uint32_t ray)
{
    const struct aim *aim = &rays->aims[ray];
    const struct ring *ring = &rays->rings[ray];
    struct ring_view view = {.ray = &rays->rays[ray],
                             .scale = rays->scale,
                             .is_edge = aim->at == AIM_EDGE,
                             .nearest_edge = INFINITY};
    struct triangle_record triangle;
    bool is_front = false;
    if (ring->count == 0 ||
        reference_triangle(reference, aim->geometry, aim->primitive, &triangle) != SOURCE_ACTIVE)
        return false;
    const float *const corners[3] = {triangle.a, triangle.b, triangle.c};
    memcpy(view.at, corners[aim->corner], sizeof(view.at));
    memcpy(view.end, corners[(aim->corner + 1) % 3], sizeof(view.end));
    for (uint32_t i = 0; i < ring->count; i++)
        if (reference_triangle(reference, ring->geometry, ring->primitives[i], &triangle) !=
                SOURCE_ACTIVE ||
            !add_triangle(&view, &triangle, &is_front, i == 0))
            return false;
    if (view.is_edge)
        return true;
    const double around = 6.283185307179586;
    return fabs(view.angle - around) < 0.1 &&
           distance_from(view.ray, view.at) + view.margin < view.nearest_edge;
}
