/* SPDX-License-Identifier: Apache-2.0 */
/* Making rays. */
#include "ray_sets.h"

#include <math.h>
#include <stddef.h>

/* Coordinates down there have 13 bits or fewer left. */
#define SUBNORMAL 0x1p-136f

static struct trace_ray ray_between(const double from[3], const double to[3])
{
    struct trace_ray ray = fixture_ray(0, 0, 0, 0, 0, 0);
    for (int i = 0; i < 3; i++) {
        ray.origin[i] = (float)from[i];
        ray.direction[i] = (float)(to[i] - ray.origin[i]);
    }
    return ray;
}

/* On a sphere of that radius. */
static void on_sphere(uint64_t *random, double radius, double at[3])
{
    double square;
    do {
        square = 0;
        for (int i = 0; i < 3; i++) {
            at[i] = fixture_uniform(random, -1, 1);
            square += at[i] * at[i];
        }
    } while (square > 1 || square < 0.01);
    for (int i = 0; i < 3; i++)
        at[i] *= radius / sqrt(square);
}

/* A vertex, or a point of an edge as far as floats have it. */
static void on_edge(const struct fixture_mesh *sphere, uint64_t *random, bool is_vertex,
                    double at[3])
{
    const uint32_t triangle = (uint32_t)(fixture_random(random) % sphere->triangle_count);
    const uint32_t corner = (uint32_t)(fixture_random(random) % 3);
    const uint32_t *indices = &sphere->indices[3 * (size_t)triangle];
    const float *a = &sphere->positions[3 * (size_t)indices[corner]];
    const float *b = &sphere->positions[3 * (size_t)indices[(corner + 1) % 3]];
    const double along = is_vertex ? 0 : fixture_uniform(random, 0, 1);
    for (int i = 0; i < 3; i++)
        at[i] = a[i] + along * ((double)b[i] - a[i]);
}

static struct trace_ray from_within(const struct fixture_mesh *sphere, uint64_t *random,
                                    bool at_vertex)
{
    double from[3], to[3];
    for (int i = 0; i < 3; i++)
        from[i] = fixture_uniform(random, -0.4f, 0.4f);
    on_edge(sphere, random, at_vertex, to);
    return ray_between(from, to);
}

/* From outside, at anything. */
static struct trace_ray from_outside(uint64_t *random, double scale, double distance)
{
    double from[3], to[3];
    on_sphere(random, scale * distance, from);
    for (int i = 0; i < 3; i++)
        to[i] = scale * fixture_uniform(random, -1, 1);
    return ray_between(from, to);
}

static struct trace_ray random_ray(const struct fixture_mesh *sphere, uint64_t *random)
{
    (void)sphere;
    return from_outside(random, 1, 2);
}

static struct trace_ray ray_at_edge(const struct fixture_mesh *sphere, uint64_t *random)
{
    return from_within(sphere, random, false);
}

static struct trace_ray ray_at_vertex(const struct fixture_mesh *sphere, uint64_t *random)
{
    return from_within(sphere, random, true);
}

/* Tangent to the sphere where it has an edge or a vertex. */
static struct trace_ray grazing_ray(const struct fixture_mesh *sphere, uint64_t *random)
{
    double from[3], to[3], aside[3], tangent[3];
    on_edge(sphere, random, fixture_random(random) % 2 == 0, to);
    on_sphere(random, 1, aside);
    for (int i = 0; i < 3; i++) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        tangent[i] = to[j] * aside[k] - to[k] * aside[j];
    }
    const double length = hypot(hypot(tangent[0], tangent[1]), tangent[2]);
    for (int i = 0; i < 3; i++)
        from[i] = to[i] + 2 * tangent[i] / (length > 0 ? length : 1);
    return ray_between(from, to);
}

static struct trace_ray far_ray(const struct fixture_mesh *sphere, uint64_t *random)
{
    (void)sphere;
    return from_outside(random, 1, pow(10, fixture_uniform(random, 3, 6)));
}

static struct trace_ray subnormal_ray(const struct fixture_mesh *sphere, uint64_t *random)
{
    (void)sphere;
    return from_outside(random, SUBNORMAL, 2);
}

const struct ray_set ray_sets[RAY_SETS] = {
    {"random", 0, 1, random_ray},      {"edges", 1, 1, ray_at_edge},
    {"vertices", 1, 1, ray_at_vertex}, {"grazing", 0, 1, grazing_ray},
    {"far origin", 0, 1, far_ray},     {"subnormal", 0, SUBNORMAL, subnormal_ray},
};

struct fixture_mesh ray_set_sphere(const struct ray_set *set, uint32_t side)
{
    static const float center[3] = {0, 0, 0};
    struct fixture_mesh sphere = fixture_sphere(side, 1, center);
    for (uint32_t i = 0; i < 3 * sphere.vertex_count; i++)
        sphere.positions[i] *= set->scale;
    return sphere;
}
