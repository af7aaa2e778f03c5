/* SPDX-License-Identifier: Apache-2.0 */
/* Figures of triangles at random and at the ends of the numbers, and meshes whose strides only look
 * wrong. tests/programs/advice/data.cases has the mistakes. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "src/advice/figures/triangles.h"
#include "tests/unit/random.h"
#include "tests/unit/unit_test.h"

#define VERTICES_OF(side) (((side) + 1) * ((side) + 1))
#define TRIANGLES_OF(side) (2 * (side) * (side))

enum { SIDE = 8, VERTICES = VERTICES_OF(SIDE), TRIANGLES = TRIANGLES_OF(SIDE) };

/* Writes the indices of a square that has side * side smaller squares, each of two triangles. */
static void write_indices(uint32_t side, uint32_t (*indices)[3])
{
    for (uint32_t i = 0; i < TRIANGLES_OF(side); i++) {
        const uint32_t first = i / 2 / side * (side + 1) + i / 2 % side, odd = i % 2;
        indices[i][0] = first + odd;
        indices[i][1] = first + (odd ? side + 2 : 1);
        indices[i][2] = first + side + 1;
    }
}

static struct source open_source(uint32_t side, const float *vertices, uint32_t stride,
                                 const uint32_t (*indices)[3])
{
    const struct builder_geometry geometry = {
        .type = VK_GEOMETRY_TYPE_TRIANGLES_KHR,
        .triangles = {.vertex_format = VK_FORMAT_R32G32B32_SFLOAT,
                      .index_type = VK_INDEX_TYPE_UINT32,
                      .max_vertex = VERTICES_OF(side) - 1,
                      .vertex_stride = stride,
                      .vertices = vertices,
                      .vertices_size = (uint64_t)stride * VERTICES_OF(side),
                      .indices = indices,
                      .indices_size = TRIANGLES_OF(side) * sizeof(indices[0])}};
    const VkAccelerationStructureBuildRangeInfoKHR range = {.primitiveCount = TRIANGLES_OF(side)};
    struct source source = {0};
    assert_true(source_open(&source, false, &geometry, &range));
    return source;
}

struct mesh {
    float at[VERTICES][3];
    uint32_t indices[TRIANGLES][3];
};

static struct mesh grid(float x, float size)
{
    struct mesh mesh;
    for (uint32_t i = 0; i < VERTICES; i++) {
        mesh.at[i][0] = x + size * (float)(i % (SIDE + 1));
        mesh.at[i][1] = size * (float)(i / (SIDE + 1));
        mesh.at[i][2] = 0;
    }
    write_indices(SIDE, mesh.indices);
    return mesh;
}

static struct source source_of(const struct mesh *mesh)
{
    return open_source(SIDE, mesh->at[0], sizeof(mesh->at[0]), mesh->indices);
}

static struct triangle_figures figures_of(const struct mesh *mesh)
{
    const struct source source = source_of(mesh);
    struct triangle_figures figures;
    assert_true(triangle_figures_read(&source, &figures));
    return figures;
}

/* Zeros are equal whatever their sign; a subnormal number is not 0. */
TEST(test_zeros_and_subnormal_numbers)
{
    struct mesh mesh = grid(0, 0);
    for (uint32_t i = 0; i < VERTICES; i++)
        mesh.at[i][2] = i % 2 ? -0.0F : 0.0F;
    assert_int_equal(figures_of(&mesh).degenerate, TRIANGLES);
    mesh = grid(0, 0x1p-149F);
    const struct triangle_figures figures = figures_of(&mesh);
    assert_int_equal(figures.degenerate, 0);
    assert_true(figures.extent == SIDE * 0x1p-149);
    assert_true(figures.median == 0x1p-148);
}

TEST(test_largest_coordinates)
{
    struct mesh mesh = grid(0, 1);
    for (uint32_t i = 0; i < VERTICES; i++)
        mesh.at[i][0] = i % 2 ? 0x1.fffffep127F : -0x1.fffffep127F;
    const struct triangle_figures figures = figures_of(&mesh);
    assert_int_equal(figures.measured, TRIANGLES);
    assert_true(figures.extent == 2 * (double)0x1.fffffep127F);
    assert_true(figures.median == 0x1p129);
}

static struct mesh random_mesh(struct random *random)
{
    static const float odd[] = {NAN, -NAN, INFINITY, -INFINITY, -0.0F, 0, 0x1p-149F};
    struct mesh mesh = grid(0, 1);
    for (uint32_t i = 0; i < VERTICES; i++)
        for (int j = 0; j < 3; j++)
            mesh.at[i][j] = random_one_in(random, 60) ? odd[random_below(random, 7)]
                                                      : (float)random_below(random, 3) - 1;
    return mesh;
}

/* Plain triangles are read in another way than those that have a transform, which changes no
 * figure. */
TEST(test_plain_triangles_against_others)
{
    struct random random = random_of("plain");
    for (int round = 0; round < 500; round++) {
        const struct mesh mesh = random_mesh(&random);
        struct source source = source_of(&mesh);
        struct triangle_figures plain, other;
        assert_true(source.is_plain);
        assert_true(triangle_figures_read(&source, &plain));
        source.is_plain = false;
        assert_true(triangle_figures_read(&source, &other));
        assert_memory_equal(&plain, &other, sizeof(plain));
    }
}

static int compare(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Against a sort. */
TEST(test_median_of_random_triangles)
{
    struct random random = random_of("median");
    for (int round = 0; round < 200; round++) {
        struct mesh mesh = grid(0, 1);
        double extents[TRIANGLES];
        for (uint32_t i = 0; i < VERTICES; i++)
            for (int j = 0; j < 3; j++)
                mesh.at[i][j] = ldexpf((float)(random_below(&random, 1000) + 1),
                                       (int)random_below(&random, 40) - 20);
        for (uint32_t i = 0; i < TRIANGLES; i++) {
            const uint32_t *at = mesh.indices[i];
            extents[i] = 0;
            for (int j = 0; j < 3; j++)
                for (int k = 0; k < 3; k++)
                    extents[i] = fmax(
                        extents[i], fabs((double)mesh.at[at[k]][j] - mesh.at[at[(k + 1) % 3]][j]));
        }
        const struct triangle_figures figures = figures_of(&mesh);
        if (figures.degenerate)
            continue;
        qsort(extents, TRIANGLES, sizeof(extents[0]), compare);
        assert_true(figures.median >= extents[TRIANGLES / 2 - 1]);
        assert_true(figures.median <= 2 * extents[TRIANGLES / 2]);
    }
}

/* ---- strides: meshes that are read with a wrong one, and wide ones with the right one */

enum {
    WIDE_SIDE = 64,
    WIDE_VERTICES = VERTICES_OF(WIDE_SIDE),
    WIDE_TRIANGLES = TRIANGLES_OF(WIDE_SIDE)
};

/* With room for a larger stride. */
static float data[32 * WIDE_VERTICES];
static uint32_t indices[WIDE_TRIANGLES][3];

/* The other floats of a vertex are those of a normal, and zeros. */
static void write_grid(uint32_t floats)
{
    for (uint32_t i = 0; i < 32 * WIDE_VERTICES; i++)
        data[i] = i % floats == 4 && i / floats < WIDE_VERTICES ? 1 : 0;
    for (uint32_t i = 0; i < WIDE_VERTICES; i++) {
        data[i * floats] = (float)(i % (WIDE_SIDE + 1));
        data[i * floats + 1] = (float)(i / (WIDE_SIDE + 1));
        data[i * floats + 2] = 0;
    }
    write_indices(WIDE_SIDE, indices);
}

static void write_soup(struct random *random, uint32_t floats)
{
    write_grid(floats);
    for (uint32_t i = 0; i < WIDE_VERTICES; i++)
        for (uint32_t j = 0; j < 3; j++)
            data[i * floats + j] = (float)random_below(random, 10000) / 100;
}

static bool finds(uint32_t stride, struct other_stride *other)
{
    const struct source source = open_source(WIDE_SIDE, data, stride, indices);
    struct triangle_figures figures;
    assert_true(triangle_figures_read(&source, &figures));
    return other_stride_find(&source, &figures, (uint64_t)stride * WIDE_VERTICES, other);
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
        for (uint32_t i = 0; i < WIDE_VERTICES; i++) {
            data[i * floats] = (float)i / WIDE_VERTICES;
            data[i * floats + 1] = (float)(i % 2);
        }
        for (uint32_t i = 0; i < WIDE_TRIANGLES; i++)
            for (uint32_t j = 0; j < 3; j++)
                indices[i][j] = (i + j) % WIDE_VERTICES;
        assert_false(finds(4 * floats, &other));
    }
}

/* A fan of rays from one place, without shared vertices. */
TEST(test_fans)
{
    struct other_stride other;
    for (uint32_t floats = 3; floats <= 8; floats++) {
        write_grid(floats);
        for (uint32_t i = 0; i < WIDE_VERTICES; i++) {
            const double angle = i / 3 * 6.28 / (WIDE_VERTICES / 3.0) + (i % 3 == 2 ? 0.001 : 0);
            data[i * floats] = i % 3 ? (float)cos(angle) : 0;
            data[i * floats + 1] = i % 3 ? (float)sin(angle) : 0;
        }
        for (uint32_t i = 0; i < WIDE_TRIANGLES; i++)
            for (uint32_t j = 0; j < 3; j++)
                indices[i][j] = (3 * i + j) % WIDE_VERTICES;
        assert_false(finds(4 * floats, &other));
    }
}
