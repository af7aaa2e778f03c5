/* SPDX-License-Identifier: Apache-2.0 */
/* Exact answers, and judging others by them. */
#include "truth.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { GROUP = 16 };

/* ---- what bounds triangles */

static void fetch_corners(const struct fixture_mesh *mesh, uint32_t triangle, float corners[9])
{
    for (uint32_t i = 0; i < 3; i++)
        memcpy(corners + 3 * (size_t)i,
               mesh->positions + 3 * (size_t)mesh->indices[3 * (size_t)triangle + i],
               3 * sizeof(float));
}

static double distance(const double a[3], const double b[3])
{
    return hypot(hypot(a[0] - b[0], a[1] - b[1]), a[2] - b[2]);
}

/* Around the mean of the centers. */
static struct truth_sphere around(const struct truth_sphere *spheres, uint32_t count)
{
    struct truth_sphere all = {.radius = 0};
    for (uint32_t i = 0; i < count; i++)
        for (int axis = 0; axis < 3; axis++)
            all.center[axis] += spheres[i].center[axis] / count;
    for (uint32_t i = 0; i < count; i++)
        all.radius = fmax(all.radius, distance(all.center, spheres[i].center) + spheres[i].radius);
    return all;
}

static struct truth_sphere around_triangle(const struct fixture_mesh *mesh, uint32_t triangle)
{
    float corners[9];
    struct truth_sphere points[3] = {{.radius = 0}, {.radius = 0}, {.radius = 0}};
    fetch_corners(mesh, triangle, corners);
    for (int i = 0; i < 9; i++)
        points[i / 3].center[i % 3] = corners[i];
    return around(points, 3);
}

void truth_open(struct truth_mesh *truth, const struct fixture_mesh *mesh)
{
    const uint32_t count = mesh->triangle_count;
    truth->mesh = mesh;
    truth->group_count = (count + GROUP - 1) / GROUP;
    truth->triangles = fixture_allocate(count * sizeof(*truth->triangles));
    truth->groups = fixture_allocate(truth->group_count * sizeof(*truth->groups));
    for (uint32_t i = 0; i < count; i++)
        truth->triangles[i] = around_triangle(mesh, i);
    for (uint32_t i = 0; i < truth->group_count; i++)
        truth->groups[i] = around(&truth->triangles[i * GROUP],
                                  count - i * GROUP < GROUP ? count - i * GROUP : GROUP);
}

void truth_close(struct truth_mesh *truth)
{
    free(truth->triangles);
    free(truth->groups);
}

/* ---- what a ray meets */

/* Whether the ray's line may pass through; the margins are far beyond what doubles round away. */
static bool may_meet(const struct truth_sphere *sphere, const struct trace_ray *ray)
{
    double d[3], to[3], square = 0, reach = 0, off = 0;
    for (int i = 0; i < 3; i++) {
        d[i] = ray->direction[i];
        to[i] = sphere->center[i] - ray->origin[i];
        square += d[i] * d[i];
        reach += fabs(to[i]);
    }
    for (int i = 0; i < 3; i++) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        const double cross = to[j] * d[k] - to[k] * d[j];
        off += cross * cross;
    }
    const double radius = 1.001 * sphere->radius + 1e-13 * reach;
    return off <= radius * radius * square;
}

/* Twice signed volumes on both sides of 0, by more than doubles round away: no need for more. */
static bool clearly_misses(const float corners[9], const struct trace_ray *ray)
{
    bool has_left = false, has_right = false;
    for (int edge = 0; edge < 3; edge++) {
        const float *a = corners + 3 * edge, *b = corners + 3 * ((edge + 1) % 3);
        double volume = 0, sum = 0;
        for (int i = 0; i < 3; i++) {
            const int j = (i + 1) % 3, k = (i + 2) % 3;
            const double aj = (double)a[j] - ray->origin[j], ak = (double)a[k] - ray->origin[k];
            const double bj = (double)b[j] - ray->origin[j], bk = (double)b[k] - ray->origin[k];
            volume += ray->direction[i] * (aj * bk - ak * bj);
            sum += fabs(ray->direction[i]) * (fabs(aj * bk) + fabs(ak * bj));
        }
        has_left = has_left || volume > 1e-13 * sum;
        has_right = has_right || volume < -1e-13 * sum;
    }
    return has_left && has_right;
}

static void meet(const struct truth_mesh *mesh, uint32_t triangle, const struct trace_ray *ray,
                 struct truth *truth)
{
    float corners[9];
    if (!may_meet(&mesh->triangles[triangle], ray))
        return;
    fetch_corners(mesh->mesh, triangle, corners);
    if (clearly_misses(corners, ray))
        return;
    const struct exact_hit hit = exact_triangle(ray, corners);
    if (hit.class == EXACT_OUTSIDE)
        return;
    if (truth->count == TRUTH_MOST) {
        fprintf(stderr, "a ray meets more than %d triangles\n", TRUTH_MOST);
        exit(1);
    }
    truth->primitives[truth->count] = triangle;
    truth->hits[truth->count++] = hit;
    truth->nearest = fmin(truth->nearest, hit.t);
}

void truth_find(const struct truth_mesh *mesh, const struct trace_ray *ray, struct truth *truth)
{
    truth->count = 0;
    truth->nearest = INFINITY;
    for (uint32_t group = 0; group < mesh->group_count; group++) {
        if (!may_meet(&mesh->groups[group], ray))
            continue;
        for (uint32_t i = group * GROUP; i < (group + 1) * GROUP; i++)
            if (i < mesh->mesh->triangle_count)
                meet(mesh, i, ray, truth);
    }
}

/* ---- judging */

static uint32_t count_of(const struct fixture_hits *hits, uint32_t primitive)
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < hits->count; i++)
        count += hits->hits[i].primitive == primitive;
    return count;
}

bool truth_allows(const struct truth *truth, const struct fixture_hits *hits, int crossings)
{
    uint32_t known = 0;
    int balance = 0;
    if (hits->count > sizeof(hits->hits) / sizeof(hits->hits[0]))
        return false;
    for (uint32_t i = 0; i < truth->count; i++) {
        const uint32_t count = count_of(hits, truth->primitives[i]);
        if (count > 1 || (count == 0 && truth->hits[i].class == EXACT_INSIDE))
            return false;
        known += count;
    }
    for (uint32_t i = 0; i < hits->count; i++)
        balance += hits->hits[i].front_face ? 1 : -1;
    return known == hits->count && abs(balance) == crossings;
}

bool truth_allows_nearest(const struct truth *truth, bool is_hit, const struct trace_hit *hit,
                          int crossings)
{
    bool is_touching = crossings == 0;
    for (uint32_t i = 0; i < truth->count; i++)
        is_touching = is_touching && truth->hits[i].class == EXACT_BOUNDARY;
    if (!is_hit)
        return is_touching;
    return fabs(hit->t - truth->nearest) <= 1e-3 * truth->nearest;
}
