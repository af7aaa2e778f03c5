/* SPDX-License-Identifier: Apache-2.0 */
/* Cases 17 to 21 and 28: AABBs. */
#include <math.h>

#include "cases.h"

static void *build_box(VkAabbPositionsKHR box)
{
    struct fixture_input input;
    fixture_input_aabbs(&input, &box, 1);
    return case_build(&input, NULL);
}

static void infinite_box(void)
{
    const VkAabbPositionsKHR boxes[] = {
        {-INFINITY, -INFINITY, -INFINITY, INFINITY, INFINITY, INFINITY},
        {-INFINITY, 0, -1, INFINITY, 1, 1},
        {2, 2, 2, 3, 3, 3},
    };
    struct fixture_input input;
    fixture_input_aabbs(&input, boxes, 3);
    void *structure = case_build(&input, NULL);
    struct fixture_hits hits;
    for (int i = 0; i < 9; i++) {
        struct trace_ray ray = fixture_ray(0, 0.5f, 0, 0, 0, 0);
        ray.direction[i % 3] = i % 2 ? -1 : 1;
        if (i >= 3)
            ray.direction[(i + 1) % 3] = -0.0f;
        if (i >= 6)
            ray.direction[(i + 2) % 3] = 1e-30f;
        case_trace_all(structure, ray, &hits);
        EXPECT(hits.count == 2);
        for (uint32_t j = 0; j < hits.count && j < 2; j++)
            EXPECT(hits.hits[j].primitive < 2 && hits.hits[j].t == 0);
    }
}

static void inverted_box(void)
{
    const VkAabbPositionsKHR boxes[] = {{1, 1, 1, 0, 0, 0}, {0, 0, 0, 1, 1, 1}};
    struct fixture_input input;
    fixture_input_aabbs(&input, boxes, 2);
    void *structure = case_build(&input, NULL);
    struct trace_ray ray = fixture_ray(0.5f, 0.5f, -1, 0, 0, 1);
    struct fixture_hits hits;
    case_trace_all(structure, ray, &hits);
    EXPECT(hits.count >= 1 && hits.hits[hits.count - 1].primitive < 2);
}

static void point_box(void)
{
    void *structure = build_box((VkAabbPositionsKHR){1, 1, 1, 1, 1, 1});
    EXPECT(case_count(structure, fixture_ray(0, 0, 0, 1, 1, 1)) <= 1);
    EXPECT(case_count(structure, fixture_ray(0, 0, 0, 1, 1, 2)) == 0);
}

static void origin_inside(void)
{
    void *structure = build_box((VkAabbPositionsKHR){0, 0, 0, 1, 1, 1});
    uint64_t random = 53;
    for (int i = 0; i < 20; i++) {
        struct trace_ray ray = fixture_ray(0, 0, 0, 0, 0, 0);
        for (int j = 0; j < 3; j++) {
            ray.origin[j] = fixture_uniform(&random, 0.1f, 0.9f);
            ray.direction[j] = fixture_uniform(&random, -1, 1);
        }
        ray.t_max = 0x1p-20f;
        EXPECT(case_count(structure, ray) == 1);
    }
}

static void in_face_plane(void)
{
    void *structure = build_box((VkAabbPositionsKHR){0, 0, 0, 1, 1, 1});
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

static void ends_in_box(void)
{
    void *structure = build_box((VkAabbPositionsKHR){1, -1, -1, 2, 1, 1});
    struct trace_ray ray = fixture_ray(0, 0, 0, 1, 0, 0);
    ray.t_max = 1;
    EXPECT(case_count(structure, ray) == 1);
    ray.t_max = 0.5f;
    EXPECT(case_count(structure, ray) != 1);
    ray.t_max = INFINITY;
    ray.t_min = 2;
    EXPECT(case_count(structure, ray) == 1);
    ray.t_min = 2.5f;
    EXPECT(case_count(structure, ray) != 1);
}

const struct numeric_case box_cases[] = {
    {17, {0, 0}, "infinite AABB", infinite_box},
    {18, {0, 0}, "minimum above maximum", inverted_box},
    {19, {0, 0}, "point AABB", point_box},
    {20, {0, 0}, "origin inside an AABB", origin_inside},
    {21, {0, 0}, "ray in a face's plane", in_face_plane},
    {28, {0, 0}, "AABB at t equal to tmin or tmax", ends_in_box},
    {0},
};
