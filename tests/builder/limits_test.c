/* SPDX-License-Identifier: Apache-2.0 */
/* How far into arrays the builder looks: to the last element, and no further. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include "src/bvh/input/source.h"
#include "tests/builder/fixture.h"

/* The vertices that spheres name: one more than the largest index, whatever follows the last. */
static void test_vertices_of_spheres(void **state)
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
    (void)state;
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
            print_message("case %zu\n", i);
        assert_int_equal(count, cases[i].expected);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_vertices_of_spheres)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
