/* SPDX-License-Identifier: Apache-2.0 */
/* Making rays. Where the coordinates are short numbers, some of the rays meet edges and vertices
 * exactly, for their directions are short, too. */
#include "src/compare/rays.h"

#include <math.h>
#include <stdlib.h>

struct maker {
    const struct reference *reference;
    uint64_t state;          /* of the generator */
    double lower[3], extent; /* of what there is */
};

/* splitmix64 (Steele, Lea, Flood 2014) */
static uint64_t next_number(struct maker *maker)
{
    uint64_t z = maker->state += 0x9e3779b97f4a7c15u;
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
    z = (z ^ z >> 27) * 0x94d049bb133111ebu;
    return z ^ z >> 31;
}

static uint32_t below(struct maker *maker, uint32_t limit)
{
    return (uint32_t)((next_number(maker) >> 32) * limit >> 32);
}

/* From 0 to 1. */
static double fraction(struct maker *maker)
{
    return (double)(next_number(maker) >> 11) * 0x1p-53;
}

/* Any primitive; false where there is none. */
static bool pick(struct maker *maker, struct aim *aim)
{
    const struct reference *reference = maker->reference;
    if (reference->primitive_count == 0)
        return false;
    uint64_t left = next_number(maker) % reference->primitive_count;
    for (aim->geometry = 0; left >= reference->sources[aim->geometry].count; aim->geometry++)
        left -= reference->sources[aim->geometry].count;
    aim->primitive = (uint32_t)left;
    return true;
}

/* In eighths of a power of two about the extent, or any. */
static void pick_direction(struct maker *maker, float direction[3])
{
    bool is_short = below(maker, 2) == 0;
    int exponent = 0;
    frexp(maker->extent, &exponent);
    double length;
    do {
        length = 0;
        for (int i = 0; i < 3; i++) {
            double part = is_short ? ((double)below(maker, 17) - 8) / 8 : 2 * fraction(maker) - 1;
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

/* To a point, from one in front of it. */
static void aim_ray(const double point[3], const float direction[3], struct compare_ray *ray)
{
    ray->t_min = 0;
    ray->t_max = INFINITY;
    for (int i = 0; i < 3; i++) {
        ray->origin[i] = (float)(point[i] - direction[i]);
        ray->direction[i] = direction[i];
    }
}

static void aim_anywhere(struct maker *maker, struct compare_ray *ray)
{
    double point[3];
    float direction[3];
    for (int i = 0; i < 3; i++)
        point[i] = maker->lower[i] + maker->extent * fraction(maker);
    pick_direction(maker, direction);
    aim_ray(point, direction, ray);
}

enum { TRIES = 8 };

/* False where there is no such triangle. */
static bool aim_at_triangle(struct maker *maker, struct aim *aim, struct compare_ray *ray)
{
    struct triangle_record triangle;
    float direction[3];
    double weights[3] = {0}, point[3];
    if (!pick(maker, aim) || reference_triangle(maker->reference, aim->geometry, aim->primitive,
                                                &triangle) != SOURCE_ACTIVE)
        return false;
    pick_direction(maker, direction);
    for (int i = 0; i < TRIES && is_edge_on(&triangle, direction); i++)
        pick_direction(maker, direction);
    aim->corner = below(maker, 3);
    if (aim->at == AIM_VERTEX) {
        weights[aim->corner] = 1;
    } else if (aim->at == AIM_EDGE) {
        /* Halves and quarters of it are short, too. */
        double w = below(maker, 4) == 0 ? 0.25 * (1 + below(maker, 3)) : fraction(maker);
        weights[aim->corner] = w;
        weights[(aim->corner + 1) % 3] = 1 - w;
    } else {
        double u = fraction(maker), v = fraction(maker);
        bool is_over = u + v > 1;
        weights[1] = is_over ? 1 - u : u;
        weights[2] = is_over ? 1 - v : v;
        weights[0] = 1 - weights[1] - weights[2];
    }
    for (int i = 0; i < 3; i++)
        point[i] =
            weights[0] * triangle.a[i] + weights[1] * triangle.b[i] + weights[2] * triangle.c[i];
    aim_ray(point, direction, ray);
    return true;
}

/* Along an axis to a face, from where the distance is a float: at 1 the ray enters (or, going on
 * from there, has left) the box. */
static bool aim_at_limit(struct maker *maker, const struct aabb_record *box,
                         struct compare_ray *ray)
{
    int axis = (int)below(maker, 3);
    float length = ldexpf(1, (int)below(maker, 3));
    bool is_upper = below(maker, 2) == 0, is_end = below(maker, 2) == 0;
    float face = is_upper ? box->upper[axis] : box->lower[axis];
    for (int i = 0; i < 3; i++) {
        ray->origin[i] = (float)(0.5 * ((double)box->lower[i] + box->upper[i]));
        ray->direction[i] = 0;
    }
    /* It ends where it enters, or begins where it leaves. */
    ray->direction[axis] = is_upper == is_end ? -length : length;
    ray->origin[axis] = face - ray->direction[axis];
    ray->t_min = is_end ? 0 : 1;
    ray->t_max = is_end ? 1 : INFINITY;
    return (double)face - ray->origin[axis] == ray->direction[axis];
}

static bool aim_at_box(struct maker *maker, struct aim *aim, struct compare_ray *ray)
{
    struct aabb_record box;
    float direction[3];
    double point[3];
    if (!pick(maker, aim) ||
        reference_aabb(maker->reference, aim->geometry, aim->primitive, &box) != SOURCE_ACTIVE)
        return false;
    if (aim->at == AIM_LIMIT)
        return aim_at_limit(maker, &box, ray);
    pick_direction(maker, direction);
    for (int i = 0; i < 3; i++)
        point[i] = box.lower[i] + fraction(maker) * ((double)box.upper[i] - box.lower[i]);
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

/* Edges, vertices, primitives and the rest in turn. */
static void make_ray(struct maker *maker, uint32_t i, struct aim *aim, struct compare_ray *ray)
{
    static const enum aim_at of_triangles[] = {AIM_EDGE,      AIM_VERTEX, AIM_EDGE,   AIM_VERTEX,
                                               AIM_PRIMITIVE, AIM_EDGE,   AIM_VERTEX, AIM_ANYWHERE};
    static const enum aim_at of_boxes[] = {AIM_LIMIT, AIM_PRIMITIVE, AIM_PRIMITIVE, AIM_ANYWHERE};
    bool is_aabbs = maker->reference->is_aabbs;
    aim->at = is_aabbs ? of_boxes[i % 4] : of_triangles[i % 8];
    if (aim->at != AIM_ANYWHERE && (is_aabbs ? aim_at_box : aim_at_triangle)(maker, aim, ray) &&
        is_usable(ray))
        return;
    aim->at = AIM_ANYWHERE;
    aim_anywhere(maker, ray);
}

static void find_extent(struct maker *maker)
{
    float lower[3], upper[3];
    maker->extent = 1;
    if (!builder_bounds(maker->reference->structure, lower, upper))
        return;
    double extent = 0;
    for (int i = 0; i < 3; i++) {
        double size = (double)upper[i] - lower[i];
        maker->lower[i] = lower[i];
        extent = size > extent ? size : extent;
    }
    if (extent > 0x1p-60 && extent < 0x1p60)
        maker->extent = extent;
}

VkResult rays_create(const struct reference *reference, uint32_t count, struct rays *rays)
{
    struct maker maker = {.reference = reference};
    *rays = (struct rays){
        .rays = calloc(count, sizeof(*rays->rays)),
        .aims = calloc(count, sizeof(*rays->aims)),
        .rings = calloc(count, sizeof(*rays->rings)),
    };
    if (!rays->rays || !rays->aims || !rays->rings) {
        rays_free(rays);
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    }
    find_extent(&maker);
    for (uint32_t i = 0; i < count; i++) {
        make_ray(&maker, i, &rays->aims[rays->count], &rays->rays[rays->count]);
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
