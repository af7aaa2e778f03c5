/* SPDX-License-Identifier: Apache-2.0 */
/* How far into arrays the builder looks: to the last element, and no further. */
#include <string.h>

#include "src/bvh/input/input.h"
#include "src/bvh/input/source.h"
#include "src/bvh/structure.h"
#include "tests/builder/fixture.h"
#include "tests/unit/unit_test.h"

/* The vertices that spheres name: one more than the largest index, whatever follows the last. */
TEST(test_vertices_of_spheres)
{
    static const uint32_t words[5] = {3, 9, 2, 40, 70};
    static const uint16_t halves[6] = {3, 9, 2, 40, 70, 99};
    static const struct {
        VkIndexType type;
        bool is_swept, is_successive;
        uint32_t offset, primitives;
        uint64_t stride, size, expected;
    } cases[] = {
        {VK_INDEX_TYPE_UINT32, false, false, 0, 3, 4, 20, 10},
        {VK_INDEX_TYPE_UINT32, false, false, 4, 3, 4, 16, 41},
        {VK_INDEX_TYPE_UINT32, false, false, 0, 2, 8, 20, 4},
        {VK_INDEX_TYPE_UINT32, false, false, 0, 5, 4, 20, 71},
        {VK_INDEX_TYPE_UINT32, false, false, 0, 5, 4, 19, 0}, /* one byte too few */
        {VK_INDEX_TYPE_UINT32, false, false, 0, 0, 4, 20, 0},
        {VK_INDEX_TYPE_UINT16, true, false, 0, 1, 2, 12, 10}, /* pairs */
        {VK_INDEX_TYPE_UINT16, true, false, 2, 2, 2, 12, 71},
        {VK_INDEX_TYPE_UINT16, true, true, 0, 1, 2, 12, 5}, /* each and its successor */
        {VK_INDEX_TYPE_UINT16, true, true, 0, 4, 2, 12, 42},
        {VK_INDEX_TYPE_NONE_KHR, false, false, 0, 7, 0, 0, 7},
    };
    for (size_t i = 0; i < sizeof(cases) / sizeof(cases[0]); i++) {
        const struct builder_spheres spheres = {
            .index_type = cases[i].type,
            .indices = cases[i].type == VK_INDEX_TYPE_UINT32 ? (const void *)words : halves,
            .indices_size = cases[i].size,
            .index_stride = cases[i].stride,
            .indexing_mode = cases[i].is_successive ? VK_RAY_TRACING_LSS_INDEXING_MODE_SUCCESSIVE_NV
                                                    : VK_RAY_TRACING_LSS_INDEXING_MODE_LIST_NV};
        const VkAccelerationStructureBuildRangeInfoKHR range = {
            .primitiveCount = cases[i].primitives, .primitiveOffset = cases[i].offset};
        const uint64_t count = sphere_vertex_count(&spheres, cases[i].is_swept, &range);
        if (count != cases[i].expected)
            fail_msg("case %zu: %llu", i, (unsigned long long)count);
    }
}

TEST(test_types_of_indices)
{
    assert_true(source_index_is_known(VK_INDEX_TYPE_NONE_KHR));
    assert_true(source_index_is_known(VK_INDEX_TYPE_UINT8_KHR));
    assert_false(source_index_is_known(VK_INDEX_TYPE_MAX_ENUM));
}

/* Each corner may name the last vertex, and not the one after it, whatever the size of indices. */
SCOPE_TEST(test_indices_of_triangles)
{
    enum { VERTICES = 5 };
    static const VkIndexType types[] = {VK_INDEX_TYPE_UINT8_KHR, VK_INDEX_TYPE_UINT16,
                                        VK_INDEX_TYPE_UINT32};
    static const float vertices[3 * (VERTICES + 1)] = {0, 0, 0, 1, 0, 0, 0, 1, 0,
                                                       0, 0, 1, 1, 1, 0, 9, 9, 9};
    for (int type = 0; type < 3; type++)
        for (uint32_t corner = 0; corner < 3; corner++)
            for (uint32_t beyond = 0; beyond < 2; beyond++) {
                uint8_t indices[12] = {0};
                const uint32_t width = 1u << type;
                for (uint32_t i = 0; i < 3; i++)
                    indices[i * width] = (uint8_t)(i == corner ? VERTICES - 1 + beyond : i);
                struct fixture_input input;
                struct builder_report report;
                fixture_input_triangles(&input, vertices, 1);
                struct builder_triangles *triangles = &input.geometry.triangles;
                triangles->vertices_size = VERTICES * 3 * sizeof(float);
                triangles->max_vertex = VERTICES;
                triangles->index_type = types[type];
                triangles->indices = indices;
                triangles->indices_size = 3 * width;
                fixture_build(&input.input, &report);
                assert_int_equal(report.out_of_range, beyond);
                triangles->vertices_size = BUILDER_ANY_SIZE;
                triangles->max_vertex = VERTICES - 1;
                fixture_build(&input.input, &report);
                assert_int_equal(report.out_of_range, beyond);
            }
}

TEST(test_dense_blocks_with_more_triangles_than_needed)
{
    enum { BLOCK = 128 };
    uint8_t block[BLOCK] = {0};
    struct dense_triangle triangles[2], before;
    fixture_put_bits(block, 0, 8, 6);
    fixture_put_bits(block, 16, 6, 2 - 1);
    memset(triangles, 0x55, sizeof(triangles));
    before = triangles[1];
    dense_decode(&(struct builder_dense){block, BLOCK, 0x1fffffff, NULL}, 1, triangles);
    assert_int_equal(memcmp(&triangles[1], &before, sizeof(before)), 0);
}

/* A block of one triangle whose geometry is an index into a palette of 3 payloads: 2 bits, so that
 * index 3 can be written. */
TEST(test_payloads_of_dense_blocks)
{
    enum { BLOCK = 128, PALETTE = 160 + 40, PAYLOADS = 3, PAYLOAD_BITS = 25 };
    for (uint32_t index = 0; index <= PAYLOADS; index++) {
        uint8_t block[BLOCK] = {0};
        const struct {
            uint32_t at, count, value;
        } fields[] = {
            {0, 8, 6},
            {10, 6, 3 - 1},                /* vertices */
            {22, 10, (PAYLOADS - 1) << 5}, /* no prefix */
            {32, 8, 127},                  /* exponent */
            {64, 4, 4 - 1},                /* 4 bits for each coordinate */
            {68, 4, 4 - 1},
            {96, 4, 4 - 1},
            {103, 1, 1}, /* has a palette */
            {PALETTE, 2, index},
            {PALETTE + 2, PAYLOAD_BITS, 10 << 1},
            {PALETTE + 2 + PAYLOAD_BITS, PAYLOAD_BITS, 11 << 1},
            {PALETTE + 2 + 2 * PAYLOAD_BITS, PAYLOAD_BITS, 12 << 1 | 1},
        };
        for (size_t j = 0; j < sizeof(fields) / sizeof(fields[0]); j++)
            fixture_put_bits(block, fields[j].at, fields[j].count, fields[j].value);
        const struct builder_dense dense = {block, BLOCK, 0x1fffffff, NULL};
        struct dense_triangle triangle;
        dense_decode(&dense, 1, &triangle);
        assert_int_equal(triangle.found, index < PAYLOADS ? SOURCE_ACTIVE : SOURCE_OUT_OF_RANGE);
        if (index < PAYLOADS) {
            assert_int_equal(triangle.geometry, 10 + index);
            assert_int_equal(triangle.is_opaque, index == PAYLOADS - 1);
        }
    }
}

/* Where the arrays of triangles end: bytes of the transforms and of the indices, the first byte
 * that is read of each, and whether the build finds everything. */
SCOPE_TEST(test_ends_of_arrays_of_triangles)
{
    enum { ONE = sizeof(VkTransformMatrixKHR), INDICES = 3 * sizeof(uint16_t) };
    static const VkTransformMatrixKHR transforms[2] = {
        {{{1, 0, 0, 9}, {0, 1, 0, 0}, {0, 0, 1, 0}}}, {{{1, 0, 0, 5}, {0, 1, 0, 0}, {0, 0, 1, 0}}}};
    static const uint16_t indices[3] = {0, 1, 2};
    static const struct {
        uint32_t transforms_size, transform_offset, indices_size, first, count;
        bool is_found;
    } cases[] = {
        {2 * ONE, ONE, INDICES, 0, 1, true},     {2 * ONE, ONE + 4, INDICES, 0, 1, false},
        {ONE - 1, 0, INDICES, 0, 1, false},      {ONE, 0, INDICES - 1, 0, 1, false},
        {ONE, 0, INDICES, 2, 1, false},          {ONE, 0, INDICES, INDICES + 2, 1, false},
        {ONE, 0, INDICES, INDICES + 2, 0, true},
    };
    for (size_t i = 0; i < sizeof(cases) / sizeof(cases[0]); i++) {
        struct builder_report report;
        INPUT(triangles, input, fixture_triangle, cases[i].count);
        struct builder_triangles *triangles = &input.geometry.triangles;
        triangles->transforms = transforms;
        triangles->transforms_size = cases[i].transforms_size;
        triangles->index_type = VK_INDEX_TYPE_UINT16;
        triangles->indices = indices;
        triangles->indices_size = cases[i].indices_size;
        input.range.transformOffset = cases[i].transform_offset;
        input.range.primitiveOffset = cases[i].first;
        const void *structure = fixture_build(&input.input, &report);
        if ((structure != NULL) != cases[i].is_found)
            fail_msg("case %zu", i);
        float lower[3], upper[3];
        if (structure && builder_bounds(structure, lower, upper))
            assert_true(lower[0] == (cases[i].transform_offset ? 5 : 9));
    }
}

/* Indices of each size lead to the last sphere, and none beyond it. */
SCOPE_TEST(test_indices_of_spheres)
{
    static const VkIndexType types[] = {VK_INDEX_TYPE_UINT8_KHR, VK_INDEX_TYPE_UINT16,
                                        VK_INDEX_TYPE_UINT32};
    static const float centers[9] = {0, 0, 0, 10, 0, 0, 20, 0, 0}, radii[3] = {1, 1, 1};
    for (uint32_t type = 0; type < 3; type++)
        for (uint8_t index = 2; index < 4; index++) {
            const uint8_t indices[4] = {index};
            struct builder_report report;
            float lower[3] = {0}, upper[3];
            INPUT(spheres, input, VK_GEOMETRY_TYPE_SPHERES_NV, 1, centers, radii, 3);
            struct builder_spheres *spheres = &input.geometry.spheres;
            spheres->index_type = types[type];
            spheres->indices = indices;
            spheres->indices_size = spheres->index_stride = 1u << type;
            const void *structure = fixture_build(&input.input, &report);
            assert_int_equal(report.out_of_range, index == 3);
            if (structure && builder_bounds(structure, lower, upper))
                assert_true(lower[0] > 18 && upper[0] > 20);
            else
                assert_int_equal(index, 3);
        }
}

/* What traversal relies on: bytes that a program has deserialized may be anything. */
SCOPE_TEST(test_well_formed_structures)
{
    enum { COUNT = 3 };
    float corners[9 * COUNT];
    for (int i = 0; i < COUNT; i++)
        memcpy(corners + 9 * i, fixture_triangle, sizeof(fixture_triangle));
    INPUT(triangles, input, corners, COUNT);
    struct structure_header *header = fixture_build(&input.input, NULL);
    const uint64_t size = header->size;
    struct triangle_record *record = structure_records(header);
    struct wide_node *node = structure_nodes(header);
    uint32_t *leaf = node->child;
    while (*leaf == CHILD_EMPTY)
        leaf++;
    const struct {
        uint32_t *at, value;
        bool is_well_formed;
    } edits[] = {
        {&record->primitive, COUNT - 1, true},
        {&record->primitive, COUNT, false},
        {&record->geometry, 1, false},
        {&header->magic, 0, false},
        {&header->version, header->version + 1, false},
        {&header->record_count, COUNT - 1, false},
        {&header->record_count, header->record_capacity + 1, false},
        {&header->record_count, 0, false},
        {&header->node_count, header->node_capacity + 1, false},
        {&header->node_count, 0, false},
        {&header->geometry_count, 100, false},
        {leaf, CHILD_EMPTY, false},
        {leaf, 0, false},                  /* a circle */
        {leaf, header->node_count, false}, /* no such node */
        {leaf, leaf_child(1, COUNT), false},
        {leaf, leaf_child(0, 1), false},
    };
    assert_int_equal(header->node_count, 1);
    assert_true(structure_is_well_formed(header, size));
    assert_true(structure_is_well_formed(header, size + 1));
    assert_false(structure_is_well_formed(header, size - 1));
    assert_false(structure_is_well_formed(header, sizeof(*header) - 1));
    for (size_t i = 0; i < sizeof(edits) / sizeof(edits[0]); i++) {
        const uint32_t before = *edits[i].at;
        *edits[i].at = edits[i].value;
        if (structure_is_well_formed(header, size) != edits[i].is_well_formed)
            fail_msg("edit %zu", i);
        *edits[i].at = before;
    }
    assert_true(structure_is_well_formed(header, size));
    structure_lay_out(header, header->kind, 1, header->record_capacity, 0, false);
    header->record_count = COUNT;
    header->node_count = 1;
    assert_false(structure_is_well_formed(header, size)); /* no room for the node */
}
