/* SPDX-License-Identifier: Apache-2.0 */
/* Generates rays, and computes where they lie relative to primitives. */
#include "src/compare/rays.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define PLACING_EDGE_ON 0x1p-6 /* the smallest cosine between ray and normal that is judged */

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
    placing->t = dot(corners[0], normal) / along;
    if (!(fabs(placing->t) < FLT_MAX / 2)) /* a driver may round it to infinity */
        return;
    placing->is_well_formed = true;
    placing->is_front = along < 0;
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

/* ---- Generates rays. If the coordinates have few bits, some of the rays hit edges and vertices
 * exactly, because their directions have few bits, too. */

struct generator {
    const struct reference *reference;
    uint64_t state;          /* state of the random number generator */
    double lower[3], extent; /* bounds of the scene */
};

/* splitmix64 (Steele, Lea, Flood 2014). */
static uint64_t next_number(struct generator *generator)
{
    uint64_t z = generator->state += 0x9e3779b97f4a7c15u;
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
    z = (z ^ z >> 27) * 0x94d049bb133111ebu;
    return z ^ z >> 31;
}

static uint32_t random_below(struct generator *generator, uint32_t limit)
{
    return (uint32_t)((next_number(generator) >> 32) * limit >> 32);
}

/* Returns a random number from 0 to 1. */
static double random_fraction(struct generator *generator)
{
    return (double)(next_number(generator) >> 11) * 0x1p-53;
}

/* Picks a random primitive. Returns false if there is none. */
static bool pick_primitive(struct generator *generator, struct aim *aim)
{
    const struct reference *reference = generator->reference;
    if (reference->primitive_count == 0)
        return false;
    uint64_t left = next_number(generator) % reference->primitive_count;
    for (aim->geometry = 0; left >= reference->sources[aim->geometry].count; aim->geometry++)
        left -= reference->sources[aim->geometry].count;
    aim->primitive = (uint32_t)left;
    return true;
}

/* Picks a direction in eighths of a power of two near the extent, or an arbitrary one. */
static void pick_direction(struct generator *generator, float direction[3])
{
    bool is_short = random_below(generator, 2) == 0;
    int exponent = 0;
    frexp(generator->extent, &exponent);
    double length;
    do {
        length = 0;
        for (int i = 0; i < 3; i++) {
            double part = is_short ? ((double)random_below(generator, 17) - 8) / 8
                                   : 2 * random_fraction(generator) - 1;
            direction[i] = (float)ldexp(part, exponent);
            length += part * part;
        }
    } while (length < 0.25);
}

static bool is_edge_on(const struct triangle_record *triangle, const float direction[3])
{
    double normal[3], along = 0, size = 0, length = 0;
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        normal[i] =
            ((double)triangle->b[j] - triangle->a[j]) * ((double)triangle->c[k] - triangle->a[k]) -
            ((double)triangle->b[k] - triangle->a[k]) * ((double)triangle->c[j] - triangle->a[j]);
        along += normal[i] * direction[i];
        size += normal[i] * normal[i];
        length += (double)direction[i] * direction[i];
    }
    return along * along < 0.01 * size * length;
}

/* Aims a ray at a point from a point in front of it. */
static void aim_ray(const double point[3], const float direction[3], struct compare_ray *ray)
{
    ray->t_min = 0;
    ray->t_max = INFINITY;
    for (int i = 0; i < 3; i++) {
        ray->origin[i] = (float)(point[i] - direction[i]);
        ray->direction[i] = direction[i];
    }
}

static void aim_anywhere(struct generator *generator, struct compare_ray *ray)
{
    double point[3];
    float direction[3];
    for (int i = 0; i < 3; i++)
        point[i] = generator->lower[i] + generator->extent * random_fraction(generator);
    pick_direction(generator, direction);
    aim_ray(point, direction, ray);
}

enum { TRIES = 8 };

/* Returns false if there is no active triangle. */
static bool aim_at_triangle(struct generator *generator, struct aim *aim, struct compare_ray *ray)
{
    struct triangle_record triangle;
    float direction[3];
    double weights[3] = {0}, point[3];
    if (!pick_primitive(generator, aim) ||
        reference_triangle(generator->reference, aim->geometry, aim->primitive, &triangle) !=
            SOURCE_ACTIVE)
        return false;
    pick_direction(generator, direction);
    for (int i = 0; i < TRIES && is_edge_on(&triangle, direction); i++)
        pick_direction(generator, direction);
    aim->corner = random_below(generator, 3);
    if (aim->at == AIM_VERTEX) {
        weights[aim->corner] = 1;
    } else if (aim->at == AIM_EDGE) {
        /* Halves and quarters of an edge have few bits, too. */
        double w = random_below(generator, 4) == 0 ? 0.25 * (1 + random_below(generator, 3))
                                                   : random_fraction(generator);
        weights[aim->corner] = w;
        weights[(aim->corner + 1) % 3] = 1 - w;
    } else {
        double u = random_fraction(generator), v = random_fraction(generator);
        bool is_outside = u + v > 1;
        weights[1] = is_outside ? 1 - u : u;
        weights[2] = is_outside ? 1 - v : v;
        weights[0] = 1 - weights[1] - weights[2];
    }
    for (int i = 0; i < 3; i++)
        point[i] =
            weights[0] * triangle.a[i] + weights[1] * triangle.b[i] + weights[2] * triangle.c[i];
    aim_ray(point, direction, ray);
    return true;
}

/* Aims along an axis at a face, from an origin whose distance from the face is a float: at t = 1
 * the ray enters the box or, if it begins there, leaves the box. */
static bool aim_at_limit(struct generator *generator, const struct aabb_record *box,
                         struct compare_ray *ray)
{
    int axis = (int)random_below(generator, 3);
    float length = ldexpf(1, (int)random_below(generator, 3));
    bool is_upper = random_below(generator, 2) == 0, is_end = random_below(generator, 2) == 0;
    float face = is_upper ? box->upper[axis] : box->lower[axis];
    for (int i = 0; i < 3; i++) {
        ray->origin[i] = (float)(0.5 * ((double)box->lower[i] + box->upper[i]));
        ray->direction[i] = 0;
    }
    /* The ray ends where it enters the box, or begins where it leaves the box. */
    ray->direction[axis] = is_upper == is_end ? -length : length;
    ray->origin[axis] = face - ray->direction[axis];
    ray->t_min = is_end ? 0 : 1;
    ray->t_max = is_end ? 1 : INFINITY;
    return (double)face - ray->origin[axis] == ray->direction[axis];
}

static bool aim_at_box(struct generator *generator, struct aim *aim, struct compare_ray *ray)
{
    struct aabb_record box;
    float direction[3];
    double point[3];
    if (!pick_primitive(generator, aim) ||
        reference_aabb(generator->reference, aim->geometry, aim->primitive, &box) != SOURCE_ACTIVE)
        return false;
    if (aim->at == AIM_LIMIT)
        return aim_at_limit(generator, &box, ray);
    pick_direction(generator, direction);
    for (int i = 0; i < 3; i++)
        point[i] =
            box.lower[i] + random_fraction(generator) * ((double)box.upper[i] - box.lower[i]);
    aim_ray(point, direction, ray);
    return true;
}

static bool is_usable(const struct compare_ray *ray)
{
    bool has_direction = false;
    for (int i = 0; i < 3; i++) {
        if (!isfinite(ray->origin[i]) || !isfinite(ray->direction[i]))
            return false;
        has_direction |= ray->direction[i] != 0;
    }
    return has_direction;
}

/* Aims at edges, vertices, primitives and random points in turn. */
static void make_ray(struct generator *generator, uint32_t i, struct aim *aim,
                     struct compare_ray *ray)
{
    static const enum aim_at triangle_aims[] = {AIM_EDGE,   AIM_VERTEX,    AIM_EDGE,
                                                AIM_VERTEX, AIM_PRIMITIVE, AIM_EDGE,
                                                AIM_VERTEX, AIM_ANYWHERE};
    static const enum aim_at box_aims[] = {AIM_LIMIT, AIM_PRIMITIVE, AIM_PRIMITIVE, AIM_ANYWHERE};
    bool is_aabbs = generator->reference->is_aabbs;
    aim->at = is_aabbs ? box_aims[i % 4] : triangle_aims[i % 8];
    if (aim->at != AIM_ANYWHERE && (is_aabbs ? aim_at_box : aim_at_triangle)(generator, aim, ray) &&
        is_usable(ray))
        return;
    aim->at = AIM_ANYWHERE;
    aim_anywhere(generator, ray);
}

static void find_extent(struct generator *generator)
{
    float lower[3], upper[3];
    generator->extent = 1;
    if (!builder_bounds(generator->reference->structure, lower, upper))
        return;
    double extent = 0;
    for (int i = 0; i < 3; i++) {
        double size = (double)upper[i] - lower[i];
        generator->lower[i] = lower[i];
        extent = size > extent ? size : extent;
    }
    if (extent > 0x1p-60 && extent < 0x1p60)
        generator->extent = extent;
}

VkResult rays_create(const struct reference *reference, uint32_t count, struct rays *rays)
{
    struct generator generator = {.reference = reference};
    *rays = (struct rays){
        .rays = calloc(count, sizeof(*rays->rays)),
        .aims = calloc(count, sizeof(*rays->aims)),
        .rings = calloc(count, sizeof(*rays->rings)),
    };
    if (!rays->rays || !rays->aims || !rays->rings) {
        rays_free(rays);
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    }
    find_extent(&generator);
    for (uint32_t i = 0; i < count; i++) {
        make_ray(&generator, i, &rays->aims[rays->count], &rays->rays[rays->count]);
        rays->count += is_usable(&rays->rays[rays->count]);
    }
    return rays_find_rings(reference, rays);
}

void rays_free(struct rays *rays)
{
    free(rays->rays);
    free(rays->aims);
    free(rays->rings);
    *rays = (struct rays){0};
}
