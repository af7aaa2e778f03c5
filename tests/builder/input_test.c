/* SPDX-License-Identifier: Apache-2.0 */
/* Vertex formats, updates, and edges of displaced triangles. */
#include <math.h>
#include <string.h>

#include "src/bvh/input/displacement.h"
#include "src/bvh/input/formats.h"
#include "tests/builder/fixture.h"
#include "tests/unit/unit_test.h"

/* One vertex of each format, and what it means. */
static const struct {
    VkFormat format;
    uint8_t bytes[16];
    float position[3];
} vertices[] = {
    {VK_FORMAT_R32G32_SFLOAT, {0, 0, 0x80, 0x3f, 0, 0, 0, 0xc0}, {1, -2, 0}},
    {VK_FORMAT_R32G32B32_SFLOAT, {0, 0, 0x80, 0x3f, 0, 0, 0, 0xc0, 0, 0, 0, 0x3f}, {1, -2, 0.5f}},
    {VK_FORMAT_R32G32B32A32_SFLOAT,
     {0, 0, 0x80, 0x3f, 0, 0, 0, 0xc0, 0, 0, 0, 0x3f, 9, 9, 9, 9},
     {1, -2, 0.5f}},
    {VK_FORMAT_R16G16_SFLOAT, {0, 0x3c, 0, 0xc0}, {1, -2, 0}},
    {VK_FORMAT_R16G16B16_SFLOAT, {0, 0x3c, 0, 0xc0, 0, 0x38}, {1, -2, 0.5f}},
    {VK_FORMAT_R16G16B16A16_SFLOAT, {0, 0x3c, 0, 0xc0, 0, 0x38, 9, 9}, {1, -2, 0.5f}},
    {VK_FORMAT_R16G16_SNORM, {0xff, 0x7f, 0x01, 0x80}, {1, -1, 0}},
    {VK_FORMAT_R16G16B16_SNORM, {0xff, 0x7f, 0, 0x80, 0, 0}, {1, -1, 0}},
    {VK_FORMAT_R16G16B16A16_SNORM, {0xff, 0x7f, 0, 0x80, 0, 0, 9, 9}, {1, -1, 0}},
    {VK_FORMAT_R16G16_UNORM, {0xff, 0xff, 0, 0}, {1, 0, 0}},
    {VK_FORMAT_R16G16B16_UNORM, {0xff, 0xff, 0, 0, 0x33, 0x33}, {1, 0, 0.2f}},
    {VK_FORMAT_R16G16B16A16_UNORM, {0xff, 0xff, 0, 0, 0x33, 0x33, 9, 9}, {1, 0, 0.2f}},
    {VK_FORMAT_R8G8_SNORM, {0x7f, 0x80}, {1, -1, 0}},
    {VK_FORMAT_R8G8B8_SNORM, {0x7f, 0x80, 0}, {1, -1, 0}},
    {VK_FORMAT_R8G8B8A8_SNORM, {0x7f, 0x81, 0, 9}, {1, -1, 0}},
    {VK_FORMAT_R8G8_UNORM, {0xff, 0x33}, {1, 0.2f, 0}},
    {VK_FORMAT_R8G8B8_UNORM, {0xff, 0x33, 0}, {1, 0.2f, 0}},
    {VK_FORMAT_R8G8B8A8_UNORM, {0xff, 0x33, 0, 9}, {1, 0.2f, 0}},
    {VK_FORMAT_A2B10G10R10_UNORM_PACK32, {0xff, 0x03, 0, 0xc0}, {1, 0, 0}},
    {VK_FORMAT_A2B10G10R10_SNORM_PACK32, {0xff, 0x01, 0x08, 0x20}, {1, -1, -1}},
};

SCOPE_TEST(test_formats)
{
    for (size_t i = 0; i < sizeof(vertices) / sizeof(vertices[0]); i++) {
        const struct vertex_format *format = vertex_format_find(vertices[i].format);
        float position[4] = {[3] = 42};
        assert_non_null(format);
        format->read(vertices[i].bytes, position);
        assert_true(position[3] == 42);
        for (int axis = 0; axis < 3; axis++)
            assert_true(position[axis] == vertices[i].position[axis]);
    }
    assert_null(vertex_format_find(VK_FORMAT_UNDEFINED));
}

/* Against the definition of the format. */
SCOPE_TEST(test_all_halves)
{
    for (uint32_t bits = 0; bits < 0x10000; bits++) {
        int exponent = (int)(bits >> 10 & 0x1f);
        float fraction = (float)(bits & 0x3ff), value = float_from_half((uint16_t)bits);
        if (exponent == 31) {
            assert_true(fraction == 0 ? isinf(value) : isnan(value));
        } else {
            float expected =
                exponent == 0 ? ldexpf(fraction, -24) : ldexpf(1024 + fraction, exponent - 25);
            assert_true(fabsf(value) == expected);
        }
        assert_int_equal(signbit(value) != 0, bits >> 15);
    }
}

/* The builder reads 32-bit indices in one go. It finds each NaN, and no zero keeps its sign:
 * otherwise bounds would depend on the order in which they are merged. */
SCOPE_TEST(test_special_coordinates)
{
    static const uint32_t large[3] = {0, 1, 2};
    static const uint16_t medium[3] = {0, 1, 2};
    for (int type = 0; type < 2; type++) {
        float corners[9] = {0};
        INPUT(triangles, input, corners, 1);
        input.geometry.triangles.index_type = type ? VK_INDEX_TYPE_UINT16 : VK_INDEX_TYPE_UINT32;
        input.geometry.triangles.indices = type ? (const void *)medium : large;
        input.geometry.triangles.indices_size = type ? sizeof(medium) : sizeof(large);
        void *expected = fixture_build(&input.input, NULL);
        for (int i = 0; i < 9; i++) {
            struct builder_report report;
            corners[i] = -0.0f;
            void *structure = fixture_build(&input.input, NULL);
            assert_memory_equal(structure, expected, builder_size(expected));
            corners[i] = NAN;
            fixture_build(&input.input, &report);
            assert_int_equal(report.inactive, 1);
            assert_int_equal(report.undefined, i % 3 != 0);
            corners[i] = 0;
        }
    }
}

/* What is inactive in the source stays so in the update. */
SCOPE_TEST(test_update_without_active_primitives)
{
    const VkAccelerationStructureInstanceKHR nowhere[2] = {{.mask = 0xff}, {.mask = 0xff}};
    const float corners[9] = {NAN, 0, 0, 1, 0, 0, 0, 1, 0};
    struct fixture_input inputs[2];
    fixture_input_instances(&inputs[0], nowhere, 2);
    fixture_input_triangles(&inputs[1], corners, 1);
    for (int i = 0; i < 2; i++) {
        struct builder_input *input = &inputs[i].input;
        input->flags = VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_UPDATE_BIT_KHR;
        void *source = fixture_build(input, NULL);
        assert_non_null(source);
        struct builder_sizes sizes;
        assert_int_equal(builder_get_sizes(input, NULL, &sizes), BUILDER_OK);
        assert_int_equal(fixture_refit(input, source, source, NULL), BUILDER_OK);
    }
}

/* An update reports a primitive that has become inactive, and leaves it where it was. */
SCOPE_TEST(test_update_to_an_inactive_primitive)
{
    float corners[18] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 5, 0, 0, 6, 0, 0, 5, 1, 0};
    struct builder_report report;
    struct trace_hit hit;
    INPUT(triangles, input, corners, 2);
    input.input.flags = VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_UPDATE_BIT_KHR;
    void *structure = fixture_build(&input.input, NULL);
    corners[2] = corners[5] = corners[8] = 1;
    corners[9] = NAN;
    assert_int_equal(fixture_refit(&input.input, structure, structure, &report), BUILDER_OK);
    assert_int_equal(report.active, 1);
    assert_int_equal(report.inactive, 1);
    for (uint32_t i = 0; i < 2; i++) {
        struct trace_ray ray = fixture_ray(5 * (float)i + 0.25f, 0.25f, 3, 0, 0, -1);
        assert_true(fixture_trace(structure, TRACE_EXACT, &ray, &hit));
        assert_int_equal(hit.primitive, i);
        assert_true(hit.t == (i ? 3 : 2));
    }
}

/* Level 2 with its edges decimated: vertices 1 and 3 of each go to its ends. Of level 1 the middle
 * goes to the edge's first vertex. */
TEST(test_decimated_edges)
{
    for (uint32_t edges = 0; edges < 8; edges++) {
        uint32_t seen[5][5] = {{0}}, left = 0;
        for (uint32_t i = 0; i < 16; i++) {
            struct displacement_corner c[3];
            displacement_microtriangle(2, i, edges, c);
            for (int j = 0; j < 3; j++)
                seen[c[j].u][c[j].v]++;
        }
        for (uint32_t i = 0; i < 25; i++)
            left += seen[i / 5][i % 5] > 0;
        assert_int_equal(left, 15 - 2 * (uint32_t)__builtin_popcount(edges));
        assert_true((seen[1][0] + seen[3][0] == 0) == (edges & 1));
        assert_true((seen[3][1] + seen[1][3] == 0) == (edges >> 1 & 1));
        assert_true((seen[0][1] + seen[0][3] == 0) == (edges >> 2 & 1));
        assert_true(seen[0][0] == (edges & 1 ? edges & 4 ? 7 : 4 : edges & 4 ? 4 : 1));
    }
    struct displacement_corner c[3];
    displacement_microtriangle(1, 1, 7, c); /* the middle becomes the whole */
    assert_true(c[0].u == 2 && c[0].v == 0 && c[1].u == 0 && c[1].v == 2 && c[2].u == 0 &&
                c[2].v == 0);
    displacement_microtriangle(0, 0, 7, c);
    assert_true(c[0].u == 0 && c[1].u == 1 && c[2].v == 1);
}
