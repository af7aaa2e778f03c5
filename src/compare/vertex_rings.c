/* SPDX-License-Identifier: Apache-2.0 */
/* Rays that pass near a shared edge or the vertex of a closed ring of triangles. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "src/compare/judge.h"
#include "src/compare/rays.h"

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

/* ---- Finds the triangles at the edges and vertices that rays are aimed at: one pass over all
 * triangles looks up each vertex among the targets. "Watertightness" of the specification defines
 * where rays must neither miss nor hit twice. */

/* A vertex that a ray is aimed at, or the first vertex of an edge. */
struct target {
    float at[3], end[3];          /* `end`: second vertex of an edge */
    uint32_t geometry, ray, next; /* `next`: next target in the slot, as index + 1 */
    /* The neighbouring corners of each triangle, as bits. */
    uint32_t before[RING_MAX][3], after[RING_MAX][3];
    bool is_edge, is_broken;
};

struct targets {
    struct target *targets;
    uint32_t count, mask;
    uint32_t *slots; /* first target, as index + 1 */
};

static uint32_t hash(const float at[3], uint32_t geometry)
{
    uint32_t bits[3], h = geometry * 0x9e3779b9u;
    memcpy(bits, at, sizeof(bits));
    for (int i = 0; i < 3; i++) {
        h = (h ^ bits[i]) * 0x85ebca6bu;
        h ^= h >> 15;
    }
    return h;
}

static const float *corner_of(const struct triangle_record *triangle, uint32_t corner)
{
    return corner % 3 == 0 ? triangle->a : corner % 3 == 1 ? triangle->b : triangle->c;
}

static void add_target(const struct reference *reference, const struct rays *rays, uint32_t ray,
                       struct targets *targets)
{
    const struct aim *aim = &rays->aims[ray];
    struct triangle_record triangle;
    if ((aim->at != AIM_EDGE && aim->at != AIM_VERTEX) ||
        reference_triangle(reference, aim->geometry, aim->primitive, &triangle) != SOURCE_ACTIVE)
        return;
    struct target *target = &targets->targets[targets->count++];
    memcpy(target->at, corner_of(&triangle, aim->corner), sizeof(target->at));
    memcpy(target->end, corner_of(&triangle, aim->corner + 1), sizeof(target->end));
    target->is_edge = aim->at == AIM_EDGE;
    target->geometry = aim->geometry;
    target->ray = ray;
    uint32_t *slot = &targets->slots[hash(target->at, aim->geometry) & targets->mask];
    target->next = *slot;
    *slot = targets->count;
}

static VkResult make_targets(const struct reference *reference, const struct rays *rays,
                             struct targets *targets)
{
    uint32_t size = 1;
    while (size < rays->count)
        size *= 2;
    *targets = (struct targets){
        .targets = calloc(rays->count + 1ull, sizeof(*targets->targets)),
        .mask = size - 1,
        .slots = calloc(size, sizeof(*targets->slots)),
    };
    if (!targets->targets || !targets->slots)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    for (uint32_t i = 0; i < rays->count; i++)
        add_target(reference, rays, i, targets);
    return VK_SUCCESS;
}

/* Adds a triangle that has a corner at the target's vertex. */
static void add_to_ring(struct target *target, const struct triangle_record *triangle,
                        uint32_t primitive, uint32_t corner, struct ring *ring)
{
    const float *after = corner_of(triangle, corner + 1), *before = corner_of(triangle, corner + 2);
    if (target->is_edge && !same_position(after, target->end) &&
        !same_position(before, target->end))
        return;
    /* A triangle without area, which has a vertex twice, is not part of any ring. */
    if (ring->count == RING_MAX || same_position(after, target->at) ||
        same_position(before, target->at) || same_position(before, after)) {
        target->is_broken = true;
        return;
    }
    memcpy(target->before[ring->count], before, sizeof(target->before[0]));
    memcpy(target->after[ring->count], after, sizeof(target->after[0]));
    ring->primitives[ring->count++] = primitive;
}

static void find_targets(const struct targets *targets, const struct triangle_record *triangle,
                         uint32_t geometry, uint32_t primitive, struct ring *rings)
{
    for (uint32_t corner = 0; corner < 3; corner++) {
        const float *at = corner_of(triangle, corner);
        uint32_t i = targets->slots[hash(at, geometry) & targets->mask];
        for (; i; i = targets->targets[i - 1].next) {
            struct target *target = &targets->targets[i - 1];
            if (target->geometry == geometry && same_position(target->at, at))
                add_to_ring(target, triangle, primitive, corner, &rings[target->ray]);
        }
    }
}

static bool same_bits(const uint32_t a[3], const uint32_t b[3])
{
    return memcmp(a, b, 3 * sizeof(*a)) == 0;
}

/* Returns whether two triangles share the edge in opposite directions. */
static bool is_shared_edge(const struct target *target, const struct ring *ring)
{
    uint32_t end[3];
    memcpy(end, target->end, sizeof(end));
    return ring->count == 2 &&
           ((same_bits(target->after[0], end) && same_bits(target->before[1], end)) ||
            (same_bits(target->before[0], end) && same_bits(target->after[1], end)));
}

/* Returns whether the triangles form one closed ring: each triangle's last corner continues in
 * exactly one triangle. */
static bool is_closed_ring(const struct target *target, const struct ring *ring)
{
    uint32_t now = 0;
    if (ring->count < 3)
        return false;
    for (uint32_t step = 1; step <= ring->count; step++) {
        uint32_t next = 0, found = 0;
        for (uint32_t i = 0; i < ring->count; i++)
            if (same_bits(target->after[i], target->before[now])) {
                next = i;
                found++;
            }
        if (found != 1 || (next == 0) != (step == ring->count))
            return false;
        now = next;
    }
    return true;
}

VkResult rays_find_rings(const struct reference *reference, struct rays *rays)
{
    struct targets targets = {0};
    if (reference->is_aabbs)
        return VK_SUCCESS;
    VkResult result = make_targets(reference, rays, &targets);
    for (uint32_t g = 0; g < reference->geometry_count && result == VK_SUCCESS; g++)
        for (uint32_t i = 0; i < reference->sources[g].count && targets.count; i++) {
            struct triangle_record triangle;
            if (reference_triangle(reference, g, i, &triangle) == SOURCE_ACTIVE)
                find_targets(&targets, &triangle, g, i, rays->rings);
        }
    for (uint32_t i = 0; i < targets.count; i++) {
        const struct target *target = &targets.targets[i];
        struct ring *ring = &rays->rings[target->ray];
        ring->geometry = target->geometry;
        if (target->is_broken || !(target->is_edge ? is_shared_edge : is_closed_ring)(target, ring))
            ring->count = 0;
    }
    free(targets.targets);
    free(targets.slots);
    return result;
}
