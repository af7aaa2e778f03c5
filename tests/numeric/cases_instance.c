/* SPDX-License-Identifier: Apache-2.0 */
/* Cases 32 to 34, 42 and 43: instances and their matrices. */
#include <math.h>

#include "cases.h"

static VkTransformMatrixKHR scaling(float x, float y, float z)
{
    return (VkTransformMatrixKHR){{{x, 0, 0, 0}, {0, y, 0, 0}, {0, 0, z, 0}}};
}

CASE(32, 0, 0, "singular matrix", "singular transform")
{
    uint64_t random = 59;
    EXPECT(builder_determinant_sign(&(VkTransformMatrixKHR){0}) == 0);
    for (int i = 0; i < 60; i++) {
        VkTransformMatrixKHR m = {0};
        float scale = (float[]){1, 1e-12f, 1e-20f, 1e12f, 1e-40f, 1e37f}[i % 6];
        for (int row = 0; row < 2; row++)
            for (int column = 0; column < 3; column++)
                m.matrix[row][column] = fixture_uniform(&random, -1, 1) * scale;
        for (int column = 0; column < 3; column++) /* of rank 2, exactly where nothing rounds */
            m.matrix[2][column] =
                i % 2 ? 2 * m.matrix[0][column] : m.matrix[0][column] - m.matrix[1][column];
        EXPECT(builder_determinant_sign(&m) == exact_determinant_sign(&m));
        EXPECT(i % 2 == 0 || builder_determinant_sign(&m) == 0);
        m.matrix[2][2] = nextafterf(m.matrix[2][2], INFINITY);
        EXPECT(builder_determinant_sign(&m) == exact_determinant_sign(&m));
        EXPECT(i % 2 == 0 || builder_determinant_sign(&m) != 0);
    }
    void *blas = case_triangles(fixture_triangle, 1);
    VkAccelerationStructureInstanceKHR instances[2] = {fixture_instance(blas),
                                                       fixture_instance(blas)};
    instances[0].transform = scaling(1, 1, 0);
    instances[1].transform = scaling(1e-12f, 1e-12f, 1e-12f);
    void *tlas = case_instances(instances, 2);
    EXPECT(report.singular == 1 && report.first_singular.primitive == 0 && report.active == 2);
    const struct fixture_hits hits =
        case_hits(tlas, fixture_ray(0.25e-12f, 0.25e-12f, 1, 0, 0, -1));
    EXPECT(hits.count == 1 && hits.hits[0].instance == 1 && hits.hits[0].t == 1);
}

CASE(33, 0, 0, "scales of 1e-20 and 1e15", "ill-scaled transform")
{
    void *blas = case_triangles(fixture_triangle, 1);
    uint64_t random = 61;
    for (int i = 0; i < 4; i++) {
        float scale = (float[]){1e-20f, 1e15f, 1e-30f, 0x1p60f}[i];
        VkAccelerationStructureInstanceKHR instance = fixture_instance(blas);
        instance.transform = scaling(scale, scale, scale);
        void *tlas = case_instances(&instance, 1);
        for (int j = 0; j < 20; j++) {
            float corners[9], origin[3];
            for (int k = 0; k < 9; k++)
                corners[k] = fixture_triangle[k] * scale;
            case_uniform(&random, scale, 2 * scale, origin);
            struct trace_ray ray = case_ray_into(corners, origin, &random);
            struct exact_hit truth = exact_triangle(&ray, corners);
            const struct trace_hit hit = case_closest(tlas, ray);
            EXPECT((hit.t >= 0) == (truth.class == EXACT_INSIDE));
            EXPECT(hit.t < 0 || fabs(hit.t - truth.t) <= 1e-5 * truth.t);
        }
    }
}

static bool sees_front(const void *structure, uint32_t flags)
{
    struct trace_ray ray = case_ray_down(0.25f, 0.25f);
    struct trace_hit hit;
    ray.flags = flags;
    if (case_trace(structure, ray, &hit))
        return hit.front_face;
    ray.origin[0] = -0.25f;
    return case_trace(structure, ray, &hit) && hit.front_face;
}

/* Counterclockwise in right-handed coordinates, seen from +Z: the front. */
CASE(34, 0, 0, "mirrored instance, mirrored geometry", "mirrored transform")
{
    const VkTransformMatrixKHR mirror = scaling(-1, 1, 1);
    void *blas = case_triangles(fixture_triangle, 1);
    EXPECT(sees_front(blas, 0));
    INPUT(triangles, input, fixture_triangle, 1);
    fixture_input_transform(&input, &mirror);
    void *mirrored_blas = case_build(&input);
    EXPECT(!sees_front(mirrored_blas, 0));
    EXPECT(!sees_front(mirrored_blas, TRACE_CULL_BACK_FACING));
    VkAccelerationStructureInstanceKHR instance = fixture_instance(blas);
    for (int i = 0; i < 4; i++) {
        bool is_flipped = i % 2;
        instance.transform = i < 2 ? mirror : scaling(1, 1, 1);
        instance.flags = is_flipped ? VK_GEOMETRY_INSTANCE_TRIANGLE_FLIP_FACING_BIT_KHR : 0;
        void *tlas = case_instances(&instance, 1);
        EXPECT(sees_front(tlas, 0) == !is_flipped);
        EXPECT(sees_front(tlas, TRACE_CULL_BACK_FACING) == !is_flipped);
        EXPECT(!sees_front(tlas, TRACE_CULL_FRONT_FACING));
        instance.flags |= VK_GEOMETRY_INSTANCE_TRIANGLE_FACING_CULL_DISABLE_BIT_KHR;
        tlas = case_instances(&instance, 1);
        EXPECT(sees_front(tlas, TRACE_CULL_FRONT_FACING) == !is_flipped);
        EXPECT(!sees_front(tlas, TRACE_SKIP_TRIANGLES));
    }
}

CASE(42, 0, 0, "empty BLAS and null instance", "instance without a structure")
{
    void *blas = case_triangles(fixture_triangle, 1);
    void *empty = case_triangles(NULL, 0);
    VkAccelerationStructureInstanceKHR instances[4] = {
        fixture_instance(NULL), fixture_instance(empty), fixture_instance(blas),
        fixture_instance(empty)};
    float lower[3], upper[3];
    instances[1].transform.matrix[0][3] = 100;
    instances[2].instanceCustomIndex = 0xabcdef;
    instances[2].instanceShaderBindingTableRecordOffset = 0x123456;
    void *tlas = case_instances(instances, 4);
    EXPECT(report.active == 3 && report.inactive == 1);
    EXPECT(builder_bounds(tlas, lower, upper) && upper[0] >= 100 && upper[0] < 100.01f);
    const struct trace_hit hit = case_closest(tlas, case_ray_down(0.25f, 0.25f));
    EXPECT(hit.instance == 2);
    EXPECT(hit.custom_index == 0xabcdef && hit.sbt_offset == 0x123456);
}

CASE(43, 0, 0, "mask 0", "mask 0")
{
    void *blas = case_triangles(fixture_triangle, 1);
    VkAccelerationStructureInstanceKHR instances[2] = {fixture_instance(blas),
                                                       fixture_instance(blas)};
    const VkAccelerationStructureInstanceKHR *pointers[2] = {&instances[1], &instances[0]};
    instances[0].mask = 0;
    instances[1].mask = 0x80;
    void *tlas = case_instances(instances, 2);
    INPUT(instances, input, (const void *)pointers, 2);
    input.geometry.instances.array_of_pointers = true;
    input.geometry.instances.size = sizeof(pointers);
    void *by_pointers = case_build(&input);
    struct trace_ray ray = case_ray_down(0.25f, 0.25f);
    struct fixture_hits hits = case_hits(tlas, ray);
    EXPECT(hits.count == 1 && hits.hits[0].instance == 1);
    hits = case_hits(by_pointers, ray);
    EXPECT(hits.count == 1 && hits.hits[0].instance == 0);
    for (uint32_t i = 0; i < 3; i++) {
        ray.cull_mask = (uint32_t[]){0, 0x7f, 0xffffff00}[i];
        EXPECT(case_count(tlas, ray) == 0);
    }
}
