/* SPDX-License-Identifier: Apache-2.0 */
/* Cases 5 to 15: degenerate, coincident, tiny and huge triangles; 17 to 21 and 28: AABBs. */
#include <math.h>
#include <string.h>

#include "cases.h"

#define SCATTERED 40

/* Triangles of size `size` around points of a cube of size `spread`. */
static void scatter(float *corners, uint32_t count, float spread, float size, uint64_t seed)
{
    for (uint32_t i = 0; i < count; i++)
        for (int axis = 0; axis < 3; axis++) {
            float center = fixture_uniform(&seed, -spread, spread);
            for (int corner = 0; corner < 3; corner++)
                corners[9 * i + 3 * (uint32_t)corner + (uint32_t)axis] =
                    center + fixture_uniform(&seed, -size, size);
        }
}

/* The same triangle, again and again. */
static void *build_copies(uint32_t count)
{
    float *corners = fixture_allocate(count * sizeof(fixture_triangle));
    for (size_t i = 0; i < count; i++)
        memcpy(corners + 9 * i, fixture_triangle, sizeof(fixture_triangle));
    return case_triangles(corners, count);
}

/* A degenerate triangle beside one that is none: only the second is hit, by its own number. */
static void check_degenerate(const float corners[9])
{
    float both[18];
    uint64_t random = 5;
    memcpy(both, corners, 9 * sizeof(float));
    memcpy(both + 9, fixture_triangle, sizeof(fixture_triangle));
    void *structure = case_triangles(both, 2);
    for (int i = 0; i < 30; i++) {
        float origin[3] = {fixture_uniform(&random, -1, 2), fixture_uniform(&random, -1, 2), 3};
        struct trace_ray ray = case_ray_into(i % 2 ? both : both + 9, origin, &random);
        const struct fixture_hits hits = case_hits(structure, ray);
        for (uint32_t j = 0; j < hits.count; j++)
            EXPECT(hits.hits[j].primitive == 1);
        EXPECT(i % 2 == 1 || hits.count == 1);
    }
}

CASE(5, 0, 0, "repeated index", "two corners at one position")
{
    const uint32_t indices[9] = {0, 1, 1, 0, 1, 2, 2, 2, 2};
    struct fixture_mesh mesh = {(float *)fixture_triangle, (uint32_t *)indices, 3, 3};
    void *structure = case_mesh(&mesh);
    const struct fixture_hits hits = case_hits(structure, case_ray_down(0.3f, 0.3f));
    EXPECT(hits.count == 1 && hits.hits[0].primitive == 1);
}

CASE(6, 0, 0, "repeated positions", "two corners at one position")
{
    check_degenerate((float[9]){0, 0, 1, 1, 1, 1, 1, 1, 1});
    check_degenerate((float[9]){0.2f, 0.2f, 1, 0.2f, 0.2f, 1, 0.2f, 0.2f, 1});
}

CASE(7, 0, 40, "oblique collinear vertices", "corners on one line")
{
    check_degenerate((float[9]){0.125f, 0.25f, 1, 0.375f, 0.75f, 1.5f, 0.25f, 0.5f, 1.25f});
    check_degenerate((float[9]){0, 0, 1, 0.25f, 0.5f, 1.75f, 0.125f, 0.25f, 1.375f});
}

CASE(8, 180, 150, "sliver", "sliver")
{
    float corners[9] = {0, 0, 0, 1e6f, 1e6f, 3e5f, 5e5f, nextafterf(5e5f, INFINITY), 1.5e5f};
    case_check_rays(corners, 1, 10, 40);
    float thin[9] = {0, 0, 0, 1, 0, 0, 0.5f, 1e-12f, 0};
    case_check_rays(thin, 1, 1, 40);
}

CASE(9, 0, 0, "100,000 coincident centroids", "one center")
{
    enum { COUNT = 100000 };
    if (setting.accuracy != TRACE_EXACT) /* one structure is enough for all accuracies */
        return;
    void *structure = build_copies(COUNT);
    struct builder_statistics statistics;
    builder_measure(structure, &statistics);
    EXPECT(statistics.depth <= 20);
    for (int accuracy = TRACE_FAST; accuracy <= TRACE_EXACT; accuracy++) {
        setting.accuracy = (enum trace_accuracy)accuracy;
        EXPECT(case_count(structure, case_ray_down(0.3f, 0.3f)) == COUNT);
    }
}

CASE(10, 0, 0, "exact duplicates", "coincident triangles")
{
    void *structure = build_copies(3);
    const struct trace_hit hit = case_closest(structure, fixture_ray(0.25f, 0.25f, 2, 0, 0, -1));
    EXPECT(hit.t == 2 && hit.primitive < 3);
}

CASE(11, 0, 0, "axis without extent", "axis without extent")
{
    for (int flat = 0; flat < 3; flat++) {
        float corners[9 * SCATTERED];
        scatter(corners, SCATTERED, 2, 1, 7);
        for (int i = 0; i < 3 * SCATTERED; i++)
            corners[3 * i + flat] = 0.5f;
        case_check_rays(corners, SCATTERED, 3, 20);
    }
}

CASE(12, 0, 0, "outlier at 1e30", "outlier")
{
    float corners[9 * SCATTERED];
    scatter(corners, SCATTERED, 2, 0.5f, 11);
    for (int i = 0; i < 9; i++)
        corners[i] = 1e30f * (i == 4 || i == 8 ? 1.5f : 1);
    case_check_rays(corners + 9, SCATTERED - 1, 3, 10);
    void *structure = case_triangles(corners, SCATTERED);
    uint64_t random = 3;
    for (int i = 0; i < 30; i++) {
        const float origin[3] = {5, 4, 3};
        struct trace_ray ray = case_ray_into(corners + 9 * (1 + i), origin, &random);
        case_check_ray(structure, corners, SCATTERED, ray);
    }
}

CASE(13, 60, 30, "subnormal coordinates", "products of coordinates underflow")
{
    float corners[9 * SCATTERED];
    scatter(corners, SCATTERED, 1e-39f, 1e-39f, 13);
    case_check_rays(corners, SCATTERED, 2e-39f, 30);
    scatter(corners, SCATTERED, 0x10p-149f, 0x8p-149f, 17);
    case_check_rays(corners, SCATTERED, 0x10p-149f, 30);
}

CASE(14, 60, 0, "coordinates of 1e30", "products of coordinates overflow")
{
    float corners[9 * SCATTERED];
    scatter(corners, SCATTERED, 1e30f, 5e29f, 19);
    case_check_rays(corners, SCATTERED, 2e30f, 30);
}

CASE(15, 0, 0, "1e-6 beside 1e6", "small beside large")
{
    float corners[9 * SCATTERED];
    scatter(corners, SCATTERED / 2, 1e6f, 1e5f, 23);
    scatter(corners + 9 * SCATTERED / 2, SCATTERED / 2, 1e-6f, 1e-6f, 29);
    void *structure = case_triangles(corners, SCATTERED);
    uint64_t random = 31;
    for (int i = 0; i < 30; i++) {
        float origin[3];
        case_uniform(&random, -1e-5f, 1e-5f, origin);
        struct trace_ray ray = case_ray_into(corners + 9 * (10 + i), origin, &random);
        case_check_ray(structure, corners, SCATTERED, ray);
    }
}

/* ---- AABBs */

static void *build_boxes(const VkAabbPositionsKHR *boxes, uint32_t count)
{
    INPUT(aabbs, input, boxes, count);
    return case_build(&input);
}

CASE(17, 0, 0, "infinite AABB", "infinite box")
{
    const VkAabbPositionsKHR boxes[] = {
        {-INFINITY, -INFINITY, -INFINITY, INFINITY, INFINITY, INFINITY},
        {-INFINITY, 0, -1, INFINITY, 1, 1},
        {2, 2, 2, 3, 3, 3},
    };
    void *structure = build_boxes(boxes, 3);
    for (int i = 0; i < 9; i++) {
        struct trace_ray ray = fixture_ray(0, 0.5f, 0, 0, 0, 0);
        ray.direction[i % 3] = i % 2 ? -1 : 1;
        if (i >= 3)
            ray.direction[(i + 1) % 3] = -0.0f;
        if (i >= 6)
            ray.direction[(i + 2) % 3] = 1e-30f;
        const struct fixture_hits hits = case_hits(structure, ray);
        EXPECT(hits.count == 2);
        for (uint32_t j = 0; j < hits.count && j < 2; j++)
            EXPECT(hits.hits[j].primitive < 2 && hits.hits[j].t == 0);
    }
}

CASE(18, 0, 0, "minimum above maximum", "minimum above maximum")
{
    const VkAabbPositionsKHR boxes[] = {{1, 1, 1, 0, 0, 0}, {0, 0, 0, 1, 1, 1}};
    void *structure = build_boxes(boxes, 2);
    const struct fixture_hits hits = case_hits(structure, fixture_ray(0.5f, 0.5f, -1, 0, 0, 1));
    EXPECT(hits.count >= 1 && hits.hits[hits.count - 1].primitive < 2);
}

CASE(19, 0, 0, "point AABB", "box without extent")
{
    void *structure = build_boxes(&(VkAabbPositionsKHR){1, 1, 1, 1, 1, 1}, 1);
    EXPECT(case_count(structure, fixture_ray(0, 0, 0, 1, 1, 1)) <= 1);
    EXPECT(case_count(structure, fixture_ray(0, 0, 0, 1, 1, 2)) == 0);
}

CASE(20, 0, 0, "origin inside an AABB", "boxes")
{
    void *structure = build_boxes(&(VkAabbPositionsKHR){0, 0, 0, 1, 1, 1}, 1);
    uint64_t random = 53;
    for (int i = 0; i < 20; i++) {
        struct trace_ray ray = fixture_ray(0, 0, 0, 0, 0, 0);
        case_uniform(&random, 0.1f, 0.9f, ray.origin);
        case_uniform(&random, -1, 1, ray.direction);
        ray.t_max = 0x1p-20f;
        EXPECT(case_count(structure, ray) == 1);
    }
}

CASE(21, 0, 0, "ray in a face's plane", "boxes")
{
    void *structure = build_boxes(&(VkAabbPositionsKHR){0, 0, 0, 1, 1, 1}, 1);
    for (int face = 0; face < 6; face++)
        for (int way = 0; way < 4; way++) {
            int axis = face / 2, along = (axis + 1 + way % 2) % 3;
            struct trace_ray ray = fixture_ray(0.5f, 0.5f, 0.5f, 0, 0, 0);
            ray.origin[axis] = (float)(face % 2);
            ray.origin[along] = way < 2 ? -1 : 2;
            ray.direction[axis] = way == 0 ? 0.0f : -0.0f;
            ray.direction[along] = way < 2 ? 1 : -1;
            EXPECT(case_count(structure, ray) == 1);
        }
}

CASE(28, 0, 0, "AABB at t equal to tmin or tmax", "boxes")
{
    void *structure = build_boxes(&(VkAabbPositionsKHR){1, -1, -1, 2, 1, 1}, 1);
    const struct trace_ray ray = fixture_ray(0, 0, 0, 1, 0, 0);
    EXPECT(case_count(structure, case_between(ray, 0, 1)) == 1);
    EXPECT(case_count(structure, case_between(ray, 0, 0.5f)) != 1);
    EXPECT(case_count(structure, case_between(ray, 2, INFINITY)) == 1);
    EXPECT(case_count(structure, case_between(ray, 2.5f, INFINITY)) != 1);
}
