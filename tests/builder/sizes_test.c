/* SPDX-License-Identifier: Apache-2.0 */
/* Sizes: enough, never more than 1.25 times what is used after compaction; and inputs that make
 * trees as uneven as they get. */
#include <math.h>
#include <string.h>

#include "tests/builder/fixture.h"
#include "tests/unit/unit_test.h"

/* The bytes that a header and the alignment of four parts add, at most. */
#define FIXED_BYTES 512.0

static void check_build(struct fixture_input *input)
{
    for (int quality = BUILDER_FAST; quality <= BUILDER_HIGH; quality++) {
        input->input.quality = (enum builder_quality)quality;
        void *structure = fixture_build(&input->input, NULL);
        assert_non_null(structure);
        double size = (double)builder_size(structure);
        double compacted = (double)builder_compacted_size(structure);
        assert_true(size <= 1.25 * compacted + FIXED_BYTES);
        if (input->geometry.type == VK_GEOMETRY_TYPE_TRIANGLES_KHR)
            assert_true(size <= 70.0 * input->range.primitiveCount + FIXED_BYTES);
    }
}

SCOPE_TEST(test_counts)
{
    for (uint32_t count = 1; count < 700; count += 1 + count / 9) {
        struct fixture_mesh mesh = fixture_soup(count, count);
        VkAabbPositionsKHR *boxes = fixture_allocate(count * sizeof(*boxes));
        INPUT(mesh, input, &mesh);
        check_build(&input);
        for (uint32_t i = 0; i < count; i++)
            memcpy(&boxes[i].minX, &mesh.positions[9 * i], 6 * sizeof(float));
        fixture_input_aabbs(&input, boxes, count);
        check_build(&input);
    }
}

/* One triangle after the other falls off every range: no tree is deeper, or has fuller leaves. */
SCOPE_TEST(test_uneven)
{
    enum { COUNT = 3000 };
    float *corners = fixture_allocate(COUNT * 9 * sizeof(float));
    for (int kind = 0; kind < 4; kind++) {
        for (int i = 0; i < COUNT; i++) {
            float at = kind == 0   ? ldexpf(1, i % 250 - 120)
                       : kind == 1 ? powf(1.03f, (float)i)
                       : kind == 2 ? (float)(i % 3)
                                   : (float)(i * i);
            float one[9] = {at, at, 0, at * 1.01f, 0, at, at, at * 1.02f, at};
            memcpy(corners + (size_t)9 * (size_t)i, one, sizeof(one));
        }
        INPUT(triangles, input, corners, COUNT);
        check_build(&input);
    }
}

SCOPE_TEST(test_instances)
{
    INPUT(triangles, input, fixture_triangle, 1);
    void *blas = fixture_build(&input.input, NULL);
    for (uint32_t count = 1; count < 300; count += 1 + count / 5) {
        VkAccelerationStructureInstanceKHR *instances =
            fixture_allocate(count * sizeof(*instances));
        for (uint32_t i = 0; i < count; i++) {
            instances[i] = fixture_instance(blas);
            instances[i].transform.matrix[0][3] = (float)(i * i % 1000);
        }
        fixture_input_instances(&input, instances, count);
        check_build(&input);
    }
}

SCOPE_TEST(test_smaller_counts_fit)
{
    struct builder_sizes before = {0}, sizes;
    INPUT(triangles, input, NULL, 0);
    for (uint32_t count = 0; count < 100000; count += 1 + count / 3) {
        assert_int_equal(builder_get_sizes(&input.input, &count, &sizes), BUILDER_OK);
        assert_true(sizes.structure >= before.structure);
        assert_true(sizes.build_scratch >= before.build_scratch);
        before = sizes;
    }
    uint32_t too_many = BUILDER_MAX_PRIMITIVES + 1;
    assert_int_equal(builder_get_sizes(&input.input, &too_many, &sizes),
                     BUILDER_TOO_MANY_PRIMITIVES);
}

/* Displaced triangles are as many as their usages say, and those beyond that stay whole. */
SCOPE_TEST(test_displaced)
{
    VkMicromapUsageEXT usages[2] = {{10, 5, 3}, {100, 2, 1}};
    struct builder_displacement displacement = {.usage_count = 2, .usages = usages};
    struct builder_sizes before = {0}, sizes;
    INPUT(triangles, input, NULL, 0);
    input.geometry.triangles.displacement = &displacement;
    for (uint32_t count = 0; count < 1000; count += 10) {
        double parts = 10 * 1024 + 100 * 16 + (count > 110 ? count - 110 : 0);
        assert_int_equal(builder_get_sizes(&input.input, &count, &sizes), BUILDER_OK);
        assert_true((double)sizes.structure <= 77 * parts + FIXED_BYTES);
        assert_true((double)sizes.structure >= 75 * parts);
        assert_true(sizes.structure >= before.structure);
        assert_true(sizes.build_scratch >= before.build_scratch);
        assert_true(sizes.update_scratch == sizes.build_scratch); /* it may be a build */
        before = sizes;
    }
    uint32_t none = 0, too_many = UINT32_MAX;
    assert_int_equal(builder_get_sizes(&input.input, &too_many, &sizes),
                     BUILDER_TOO_MANY_PRIMITIVES);
    usages[0].count = BUILDER_MAX_PRIMITIVES / 1024 + 1;
    assert_int_equal(builder_get_sizes(&input.input, &none, &sizes), BUILDER_TOO_MANY_PRIMITIVES);
    usages[0].subdivisionLevel = 6;
    assert_int_equal(builder_get_sizes(&input.input, &none, &sizes), BUILDER_UNKNOWN_FORMAT);
}

static uint64_t aligned(uint64_t size)
{
    return (size + BUILDER_ALIGNMENT - 1) / BUILDER_ALIGNMENT * BUILDER_ALIGNMENT;
}

/* What extensions add isn't there where none is used: a header, 8 bytes a geometry, 48 a triangle,
 * 224 a node; and rays look nothing up. */
SCOPE_TEST(test_plain)
{
    struct fixture_mesh mesh = fixture_terrain(30);
    INPUT(mesh, input, &mesh);
    void *structure = fixture_build(&input.input, NULL);
    uint64_t triangles = mesh.triangle_count, nodes = triangles * 9 / 100 + 1;
    assert_int_equal(builder_size(structure),
                     aligned(96) + aligned(8) + aligned(48 * triangles) + aligned(224 * nodes));
    struct trace_counters counters = {0};
    struct trace_scene scene = {
        .structure = structure, .accuracy = TRACE_EXACT, .counters = &counters};
    struct trace_ray ray = fixture_ray(60, 60, 100, 0, 0, -1); /* from above */
    struct trace_hit hit;
    ray.time = 0.5f;
    assert_true(trace_closest(&scene, &ray, &hit));
    assert_true(counters.nodes > 0 && counters.micromaps == 0 && counters.instances == 0);
}

SCOPE_TEST(test_too_small)
{
    struct builder_sizes sizes;
    uint32_t count = 1;
    INPUT(triangles, input, fixture_triangle, 1);
    builder_get_sizes(&input.input, &count, &sizes);
    void *structure = fixture_allocate(sizes.structure),
         *scratch = fixture_allocate(sizes.build_scratch);
    for (int lacks = 0; lacks < 3; lacks++) /* of the structure, of scratch, nothing */
        assert_int_equal(builder_build(&input.input, structure, sizes.structure - (lacks == 0),
                                       scratch, sizes.build_scratch - (lacks == 1), NULL),
                         lacks < 2 ? BUILDER_TOO_SMALL : BUILDER_OK);
    input.geometry.triangles.vertex_format = VK_FORMAT_R64G64B64_SFLOAT;
    assert_int_equal(builder_get_sizes(&input.input, &count, &sizes), BUILDER_UNKNOWN_FORMAT);
}
