/* SPDX-License-Identifier: Apache-2.0 */
/* How much of an input is moved to be compared, where to, and what is refused; and where rays lie
 * to boxes, in numbers that are exact. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "src/compare/input.h"
#include "src/compare/rays.h"
#include "subject.h"
#include "tests/fixture/scarce_memory.h"
#include "tests/unit/unit_test.h"

enum { VERTICES = 40, PADDING = 4096 };

static struct subject subject;

static uint64_t room_of(uint64_t in_alignment, uint64_t offset, uint64_t size)
{
    const uint64_t bytes = in_alignment + 2 * (offset + size) + PADDING;
    return (bytes + COMPARE_ALIGNMENT - 1) / COMPARE_ALIGNMENT * COMPARE_ALIGNMENT;
}

/* ---- sizes; nothing is read at the addresses */

static uint64_t readable_size;

static uint64_t find_readable(void *context, uint64_t address, uint64_t size, const void **bytes)
{
    *bytes = NULL;
    return size < readable_size ? size : readable_size;
}

static void begin(uint64_t readable_bytes)
{
    subject_begin(&subject);
    subject.memory.find = find_readable;
    readable_size = readable_bytes;
}

TEST(test_sizes_of_triangles)
{
    static const struct {
        uint32_t max_vertex, count, offset, first_vertex;
        VkIndexType index_type;
        bool has_transform;
        uint64_t vertices_offset, vertices, indices;
    } cases[] = {
        {8, 3, 0, 0, VK_INDEX_TYPE_NONE_KHR, false, 0, 108, 0},
        {80, 3, 0, 0, VK_INDEX_TYPE_NONE_KHR, false, 0, 108, 0}, /* no more than are read */
        {5, 3, 0, 0, VK_INDEX_TYPE_NONE_KHR, false, 0, 72, 0},   /* no more than there are */
        {8, 1, 24, 2, VK_INDEX_TYPE_NONE_KHR, false, 48, 36, 0},
        {8, 3, 24, 2, VK_INDEX_TYPE_UINT32, false, 24, 84, 36},
        {8, 3, 24, 20, VK_INDEX_TYPE_UINT16, false, 240, 12, 18}, /* the first is beyond the last */
        {8, 3, 0, 0, VK_INDEX_TYPE_UINT8_KHR, true, 0, 108, 9},
        {8, 0, 0, 0, VK_INDEX_TYPE_UINT32, true, 0, 0, 0},
    };
    for (size_t i = 0; i < sizeof(cases) / sizeof(cases[0]); i++) {
        begin(UINT64_MAX);
        subject_triangles(&subject, NULL, cases[i].max_vertex + 1, NULL, cases[i].count);
        VkAccelerationStructureGeometryTrianglesDataKHR *triangles =
            &subject.geometries[0].geometry.triangles;
        triangles->indexType = cases[i].index_type;
        triangles->transformData.deviceAddress = cases[i].has_transform ? 0x10030 : 0;
        triangles->vertexData.deviceAddress = 0x20010;
        subject.ranges[0].primitiveOffset = cases[i].offset;
        subject.ranges[0].firstVertex = cases[i].first_vertex;
        uint64_t expected = COMPARE_ALIGNMENT;
        if (cases[i].vertices)
            expected += room_of(0x10, cases[i].vertices_offset, cases[i].vertices);
        if (cases[i].indices)
            expected += room_of(0, cases[i].offset, cases[i].indices);
        if (cases[i].has_transform && cases[i].count)
            expected += room_of(0x30, 0, sizeof(VkTransformMatrixKHR));
        assert_int_equal(compare_input_size(&subject.input), expected);
    }
}

static uint64_t size_of_boxes(uint32_t count, uint64_t stride, uint32_t offset)
{
    subject_boxes(&subject, NULL, count);
    subject.geometries[0].geometry.aabbs.stride = stride;
    subject.ranges[0].primitiveOffset = offset;
    const uint64_t size = compare_input_size(&subject.input);
    subject.parameters.info.geometryCount = 0;
    return size;
}

TEST(test_limits)
{
    const uint32_t most = (uint32_t)((COMPARE_INPUT_MAX - COMPARE_ALIGNMENT - PADDING) / 2);
    begin(UINT64_MAX);
    assert_int_equal(size_of_boxes(1, 24, 0), COMPARE_ALIGNMENT + room_of(0, 0, 24));
    assert_int_equal(size_of_boxes(3, 32, 16), COMPARE_ALIGNMENT + room_of(0, 16, 88));
    assert_int_equal(size_of_boxes(1, 24, most - 24), COMPARE_INPUT_MAX);
    assert_true(size_of_boxes(1, 24, most - 23) == UINT64_MAX);
    assert_true(size_of_boxes(2, UINT64_MAX, 0) == UINT64_MAX);
    assert_true(size_of_boxes(3, UINT64_MAX / 2 + 13, 0) == UINT64_MAX); /* wraps to 26 */
    assert_true(size_of_boxes(2, COMPARE_INPUT_MAX, 0) == UINT64_MAX);
    assert_true(size_of_boxes(1, 24, UINT32_MAX) == UINT64_MAX);
    readable_size = 24;
    assert_int_equal(size_of_boxes(1, 24, 0), COMPARE_ALIGNMENT + room_of(0, 0, 24));
    readable_size = 23;
    assert_true(size_of_boxes(1, 24, 0) == UINT64_MAX);
}

/* ---- copies */

TEST(test_copies)
{
    static float vertices[3 * VERTICES];
    static uint32_t indices[VERTICES];
    static const VkTransformMatrixKHR transforms[2] = {{{{1}}}, {{{2, 3}}}};
    static const VkAabbPositionsKHR boxes[2] = {{1, 2, 3, 4, 5, 6}, {7, 8, 9, 10, 11, 12}};
    for (uint32_t i = 0; i < 3 * VERTICES; i++)
        vertices[i] = (float)i;
    for (uint32_t i = 0; i < VERTICES; i++)
        indices[i] = i / 2;
    subject_begin(&subject);
    subject_triangles(&subject, vertices, VERTICES, indices, 5);
    subject.geometries[0].geometry.triangles.transformData.hostAddress = transforms;
    subject.ranges[0] = (VkAccelerationStructureBuildRangeInfoKHR){5, 8, 4, sizeof(transforms[0])};
    subject_triangles(&subject, vertices, VERTICES, NULL, 0);
    struct input_copy *copied = input_copy_create(&subject.input);
    assert_non_null(copied);
    assert_int_equal(copied->size, compare_input_size(&subject.input));
    assert_int_equal((uintptr_t)copied->bytes % COMPARE_ALIGNMENT, 0);
    const VkAccelerationStructureGeometryTrianglesDataKHR *moved =
        &copied->parameters.geometries[0].geometry.triangles;
    assert_int_equal(moved->vertexData.deviceAddress % COMPARE_ALIGNMENT,
                     (uintptr_t)vertices % COMPARE_ALIGNMENT);
    const unsigned char *to = moved->vertexData.hostAddress;
    assert_memory_equal(to + 4 * 12, vertices + 12, (VERTICES - 4) * 12);
    for (int i = 0; i < 4 * 12; i++)
        assert_int_equal(to[i], 0); /* nothing reads there */
    to = moved->indexData.hostAddress;
    assert_memory_equal(to + 8, indices + 2, 15 * sizeof(indices[0]));
    to = moved->transformData.hostAddress;
    assert_memory_equal(to + sizeof(transforms[0]), &transforms[1], sizeof(transforms[1]));
    assert_ptr_equal(copied->parameters.geometries[1].geometry.triangles.vertexData.hostAddress,
                     copied->bytes);

    const void *bytes;
    const uint64_t begin = (uintptr_t)copied->bytes;
    const struct input_memory *memory = &copied->memory;
    assert_int_equal(memory->find(memory->context, begin, 16, &bytes), 16);
    assert_ptr_equal(bytes, copied->bytes);
    assert_int_equal(memory->find(memory->context, begin + copied->size - 4, 16, &bytes), 4);
    assert_int_equal(memory->find(memory->context, begin + copied->size, 16, &bytes), 0);
    assert_null(bytes);
    assert_int_equal(memory->find(memory->context, begin - 1, 16, &bytes), 0);
    input_copy_free(copied);

    subject_begin(&subject);
    subject_boxes(&subject, boxes, 2);
    assert_non_null(copied = input_copy_create(&subject.input));
    assert_memory_equal(copied->parameters.geometries[0].geometry.aabbs.data.hostAddress, boxes,
                        sizeof(boxes));
    input_copy_free(copied);
    subject.memory.find = find_readable;
    readable_size = 0;
    const int before = allocations_now();
    assert_null(input_copy_create(&subject.input));
    input_copy_free(NULL);
    assert_int_equal(allocations_now(), before);
}

/* ---- rays and boxes */

/* A box from 1 to 3. */
TEST(test_boxes)
{
    const float most = INFINITY;
    static const struct aabb_record box = {.lower = {1, 1, 1}, .upper = {3, 3, 3}},
                                    flat = {.lower = {1, 1, 1}, .upper = {3, 1, 3}};
    const struct {
        struct compare_ray ray;
        bool meets, meets_if_moved;
    } cases[] = {
        {{{0, 2, 2}, 0, {1, 0, 0}, most}, true, true},
        {{{4, 2, 2}, 0, {-1, 0, 0}, most}, true, true},
        {{{4, 2, 2}, 0, {1, 0, 0}, most}, false, false},
        {{{2, 2, 2}, 0, {1, 0, 0}, most}, true, true}, /* begins within */
        {{{0, 2, 2}, 0, {1, 0, 0}, 1}, true, false},   /* ends at the face, exactly */
        {{{0, 2, 2}, 3, {1, 0, 0}, most}, true, false},
        {{{0, 2, 2}, 0, {1, 0, 0}, 0.5f}, false, false},
        {{{0, 2, 2}, 3.5f, {1, 0, 0}, most}, false, false},
        {{{0, 2, 2}, 0, {2, 0, 0}, 0.5f}, true, false},
        {{{0, 2, 2}, 0, {-0.5f, 0, 0}, 2}, false, false},
        {{{4, 2, 2}, 0, {-0.5f, 0, 0}, 2}, true, false},
        {{{0, 2, 2}, 0, {3, 0, 0}, 1 / 3.f}, false, false},  /* no power of two */
        {{{0x1p-30f, 2, 2}, 0, {1, 0, 0}, 1}, false, false}, /* the distance is no float */
        {{{0, 1, 2}, 0, {1, 0, 0}, most}, false, false},     /* along a face */
        {{{0, 2, 3}, 0, {1, 0, 0}, 1}, false, false},
        {{{0, 2, 5}, 0, {1, 0, 0}, 1}, false, false},
        {{{0, 5, 2}, 0, {1, 0, 0}, most}, false, false},
        {{{2, 0, 2}, 0, {0, 1, 0}, 1}, true, false},
        {{{2, 2, 0}, 0, {0, 0, 1}, 1}, true, false},
        {{{0, 0, 0}, 0, {1, 1, 1}, most}, true, true},
        {{{0, 0, 2}, 0, {1, 1, 0}, 1}, false, false}, /* exact along one axis only */
        {{{0, 2, 0}, 0, {1, 0, 2}, most}, true, true},
        {{{0, 3.5f, 0}, 0, {1, -3, 1}, most}, false, false},
        {{{1, 0, 2}, 0, {0, 1, 0}, most}, false, false},
        {{{4, 4, 4}, 0, {-1, -1, -1}, 0.9f}, false, false},
        {{{4, 4, 4}, 0, {-1, -1, -1}, 1.1f}, true, true},
    };
    for (size_t i = 0; i < sizeof(cases) / sizeof(cases[0]); i++) {
        const bool meets = placing_meets_box(&cases[i].ray, &box, 0, false);
        const bool meets_if_moved = placing_meets_box(&cases[i].ray, &box, 0, true);
        if (meets != cases[i].meets || meets_if_moved != cases[i].meets_if_moved)
            fail_msg("case %zu: %d %d", i, meets, meets_if_moved);
        assert_false(placing_meets_box(&cases[i].ray, &flat, 0, false));
        assert_false(
            placing_meets_box(&cases[i].ray, &box, 0x1p16, false)); /* nothing is certain */
    }
}
