/* SPDX-License-Identifier: Apache-2.0 */
/* Bytes that two geometries read as vertices, in ways that contradict and in others. */
#include "src/advice/figures/layouts.h"
#include "tests/unit/unit_test.h"

enum { AT = 0x10000, COUNT = 100, FLOAT = 4, HALF = 2 };

static struct vertex_layout layout(uint64_t begin, uint64_t count, uint64_t stride,
                                   uint32_t component)
{
    return (struct vertex_layout){
        .begin = begin, .count = count, .stride = stride, .component = component, .is_float = true};
}

static bool contradict(struct vertex_layout one, struct vertex_layout other)
{
    struct vertex_layouts layouts = {0};
    one.geometry = 7;
    vertex_layouts_add(&layouts, &one);
    const struct vertex_layout *found = vertex_layouts_find_other(&layouts, &other);
    assert_true(!found || found->geometry == 7);
    return found;
}

TEST(test_strides)
{
    const struct vertex_layout one = layout(AT, 4 * COUNT, 12, FLOAT);
    assert_false(contradict(one, one));
    assert_true(contradict(one, layout(AT, 3 * COUNT, 16, FLOAT)));
    assert_true(contradict(layout(AT, 3 * COUNT, 16, FLOAT), one));
    assert_true(contradict(one, layout(AT + 4, 3 * COUNT, 16, FLOAT)));
    assert_false(contradict(one, layout(AT, 2 * COUNT, 24, FLOAT))); /* each second vertex */
    assert_false(contradict(layout(AT, 2 * COUNT, 24, FLOAT), one));
    assert_false(contradict(one, layout(AT, COUNT, 0, FLOAT)));
}

TEST(test_most_bytes_are_shared)
{
    const struct vertex_layout one = layout(AT, 4 * COUNT, 12, FLOAT);
    assert_true(contradict(one, layout(AT + 400, 3 * COUNT, 16, FLOAT)));
    assert_false(contradict(one, layout(AT + 600, 3 * COUNT, 16, FLOAT)));
    assert_false(contradict(one, layout(AT + 4 * COUNT * 12, 3 * COUNT, 16, FLOAT)));
    assert_false(contradict(one, layout(AT, COUNT, 16, FLOAT))); /* within the other */
    assert_false(contradict(layout(AT, COUNT, 16, FLOAT), one));
}

TEST(test_formats)
{
    struct vertex_layout one = layout(AT, COUNT, 24, FLOAT), other = one;
    other.component = HALF;
    assert_true(contradict(one, other));
    other.begin += 24;
    assert_true(contradict(one, other));
    other.begin = AT - 24;
    assert_true(contradict(one, other));
    other.begin = AT + 12; /* another member of the vertex */
    assert_false(contradict(one, other));
    other = one;
    other.is_float = false;
    assert_true(contradict(one, other));
    other = one;
    other.format = one.format + 1; /* such as one that reads fewer components */
    assert_false(contradict(one, other));
}

TEST(test_few_vertices)
{
    assert_true(contradict(layout(AT, 20, 12, FLOAT), layout(AT, 16, 15, FLOAT)));
    assert_false(contradict(layout(AT, 20, 12, FLOAT), layout(AT, 15, 16, FLOAT)));
    assert_false(contradict(layout(AT, 15, 16, FLOAT), layout(AT, 20, 12, FLOAT)));
}

TEST(test_many_geometries)
{
    struct vertex_layouts layouts = {0};
    for (uint32_t i = 0; i < 40; i++) {
        const struct vertex_layout one = layout(AT * (i + 1), COUNT, 16, FLOAT);
        vertex_layouts_add(&layouts, &one);
    }
    struct vertex_layout other = layout(AT * UINT64_C(16), COUNT, 16, HALF);
    assert_non_null(vertex_layouts_find_other(&layouts, &other));
    other.begin = AT * UINT64_C(17);
    assert_null(vertex_layouts_find_other(&layouts, &other));
}
