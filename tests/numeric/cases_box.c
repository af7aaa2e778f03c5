/* SPDX-License-Identifier: Apache-2.0 */
/* Cases 17 to 21 and 28: AABBs. */
#include <math.h>

#include "cases.h"

static void *build_boxes(const VkAabbPositionsKHR *boxes, uint32_t count)
{
    INPUT(aabbs, input, boxes, count);
    return case_build(&input);
}

CASE(17, 0, 0, "infinite AABB")
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

CASE(18, 0, 0, "minimum above maximum")
{
    const VkAabbPositionsKHR boxes[] = {{1, 1, 1, 0, 0, 0}, {0, 0, 0, 1, 1, 1}};
    void *structure = build_boxes(boxes, 2);
    const struct fixture_hits hits = case_hits(structure, fixture_ray(0.5f, 0.5f, -1, 0, 0, 1));
    EXPECT(hits.count >= 1 && hits.hits[hits.count - 1].primitive < 2);
}

CASE(19, 0, 0, "point AABB")
{
    void *structure = build_boxes(&(VkAabbPositionsKHR){1, 1, 1, 1, 1, 1}, 1);
    EXPECT(case_count(structure, fixture_ray(0, 0, 0, 1, 1, 1)) <= 1);
    EXPECT(case_count(structure, fixture_ray(0, 0, 0, 1, 1, 2)) == 0);
}

CASE(20, 0, 0, "origin inside an AABB")
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

CASE(21, 0, 0, "ray in a face's plane")
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

CASE(28, 0, 0, "AABB at t equal to tmin or tmax")
{
    void *structure = build_boxes(&(VkAabbPositionsKHR){1, -1, -1, 2, 1, 1}, 1);
    const struct trace_ray ray = fixture_ray(0, 0, 0, 1, 0, 0);
    EXPECT(case_count(structure, case_between(ray, 0, 1)) == 1);
    EXPECT(case_count(structure, case_between(ray, 0, 0.5f)) != 1);
    EXPECT(case_count(structure, case_between(ray, 2, INFINITY)) == 1);
    EXPECT(case_count(structure, case_between(ray, 2.5f, INFINITY)) != 1);
}
