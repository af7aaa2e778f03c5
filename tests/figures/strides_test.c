/* SPDX-License-Identifier: Apache-2.0 */
/* Meshes that are read with a wrong stride, and wide ones that are read with the right one. */
#include <math.h>

#include "src/advice/figures/triangles.h"
#include "tests/unit/random.h"
#include "tests/unit/unit_test.h"

enum { SIDE = 64, VERTICES = (SIDE + 1) * (SIDE + 1), TRIANGLES = 2 * SIDE * SIDE };

/* With room for a larger stride. */
static float data[32 * VERTICES];
static uint32_t indices[TRIANGLES][3];

static void write_indices(void)
{
    for (uint32_t i = 0; i < TRIANGLES; i++) {
        const uint32_t first = i / 2 / SIDE * (SIDE + 1) + i / 2 % SIDE, odd = i % 2;
        indices[i][0] = first + odd;
        indices[i][1] = first + (odd ? SIDE + 2 : 1);
        indices[i][2] = first + SIDE + 1;
    }
}

/* The other floats of a vertex are those of a normal, and zeros. */
static void write_grid(uint32_t floats)
{
    for (uint32_t i = 0; i < 32 * VERTICES; i++)
        data[i] = i % floats == 4 && i / floats < VERTICES ? 1 : 0;
    for (uint32_t i = 0; i < VERTICES; i++) {
        data[i * floats] = (float)(i % (SIDE + 1));
        data[i * floats + 1] = (float)(i / (SIDE + 1));
        data[i * floats + 2] = 0;
    }
    write_indices();
}

static void write_soup(struct random *random, uint32_t floats)
{
    write_grid(floats);
    for (uint32_t i = 0; i < VERTICES; i++)
        for (uint32_t j = 0; j < 3; j++)
            data[i * floats + j] = (float)random_below(random, 10000) / 100;
}

static bool finds(uint32_t stride, struct other_stride *other)
{
    const struct builder_geometry geometry = {
        .type = VK_GEOMETRY_TYPE_TRIANGLES_KHR,
        .triangles = {.vertex_format = VK_FORMAT_R32G32B32_SFLOAT,
                      .index_type = VK_INDEX_TYPE_UINT32,
                      .max_vertex = VERTICES - 1,
                      .vertex_stride = stride,
                      .vertices = data,
                      .vertices_size = (uint64_t)stride * VERTICES,
                      .indices = indices,
                      .indices_size = sizeof(indices)}};
    const VkAccelerationStructureBuildRangeInfoKHR range = {.primitiveCount = TRIANGLES};
    struct source source = {0};
    struct triangle_figures figures;
    assert_true(source_open(&source, false, &geometry, &range));
    assert_true(triangle_figures_read(&source, &figures));
    return other_stride_find(&source, &figures, geometry.triangles.vertices_size, other);
}

TEST(test_wrong_strides)
{
    struct other_stride other;
    write_grid(3);
    assert_false(finds(12, &other));
    assert_true(finds(16, &other));
    assert_int_equal(other.stride, 12);
    assert_true(other.extent == SIDE && other.small == SIDE / 32);
    write_grid(8);
    assert_false(finds(32, &other));
    assert_true(finds(28, &other));
    assert_int_equal(other.stride, 32);
    assert_true(finds(36, &other));
    assert_int_equal(other.stride, 32);
}

/* Every second vertex may be meant. */
TEST(test_multiples)
{
    struct other_stride other;
    write_grid(6);
    assert_false(finds(12, &other));
    assert_false(finds(48, &other));
}

/* The other floats are equal in all vertices. */
TEST(test_wide_triangles)
{
    struct random random = random_of("strides");
    struct other_stride other;
    for (uint32_t floats = 3; floats <= 32; floats++) {
        write_soup(&random, floats);
        assert_false(finds(4 * floats, &other));
    }
}

/* A ribbon: vertices of two sides in turn. */
TEST(test_long_triangles)
{
    struct other_stride other;
    for (uint32_t floats = 3; floats <= 8; floats++) {
        write_grid(floats);
        for (uint32_t i = 0; i < VERTICES; i++) {
            data[i * floats] = (float)i / VERTICES;
            data[i * floats + 1] = (float)(i % 2);
        }
        for (uint32_t i = 0; i < TRIANGLES; i++)
            for (uint32_t j = 0; j < 3; j++)
                indices[i][j] = (i + j) % VERTICES;
        assert_false(finds(4 * floats, &other));
    }
}

/* A fan of rays from one place, without shared vertices. */
TEST(test_fans)
{
    struct other_stride other;
    for (uint32_t floats = 3; floats <= 8; floats++) {
        write_grid(floats);
        for (uint32_t i = 0; i < VERTICES; i++) {
            const double angle = i / 3 * 6.28 / (VERTICES / 3.0) + (i % 3 == 2 ? 0.001 : 0);
            data[i * floats] = i % 3 ? (float)cos(angle) : 0;
            data[i * floats + 1] = i % 3 ? (float)sin(angle) : 0;
        }
        for (uint32_t i = 0; i < TRIANGLES; i++)
            for (uint32_t j = 0; j < 3; j++)
                indices[i][j] = (3 * i + j) % VERTICES;
        assert_false(finds(4 * floats, &other));
    }
}
