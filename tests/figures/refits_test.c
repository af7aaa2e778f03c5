/* SPDX-License-Identifier: Apache-2.0 */
/* Trees of updates: triangles that are not sampled, and costs that are unknown. */
#include <math.h>

#include "src/advice/figures/refits.h"
#include "tests/fixture/scarce_memory.h"
#include "tests/unit/random.h"
#include "tests/unit/unit_test.h"

enum { COUNT = 200 };

struct soup {
    float corners[COUNT][3][3];
};

static double random_between(struct random *random, double least, double most)
{
    return least + (most - least) * (double)(random_next(random) >> 11) * 0x1p-53;
}

static void write_soup(struct random *random, struct soup *to)
{
    for (int i = 0; i < 9 * COUNT; i++) {
        float(*corners)[3] = to->corners[i / 9];
        corners[i % 9 / 3][i % 3] = i % 9 < 3
                                        ? (float)random_between(random, 0, 10)
                                        : corners[0][i % 3] + (float)random_between(random, -1, 1);
    }
}

static struct builder_geometry geometry_of(const struct soup *from)
{
    return (struct builder_geometry){.type = VK_GEOMETRY_TYPE_TRIANGLES_KHR,
                                     .triangles = {.vertex_format = VK_FORMAT_R32G32B32_SFLOAT,
                                                   .index_type = VK_INDEX_TYPE_NONE_KHR,
                                                   .max_vertex = 3 * COUNT - 1,
                                                   .vertex_stride = sizeof(from->corners[0][0]),
                                                   .vertices = from->corners,
                                                   .vertices_size = sizeof(from->corners)}};
}

static struct source source_of(const struct soup *from, uint32_t count)
{
    const struct builder_geometry geometry = geometry_of(from);
    const VkAccelerationStructureBuildRangeInfoKHR range = {.primitiveCount = count};
    struct source source = {0};
    assert_true(source_open(&source, false, &geometry, &range));
    return source;
}

static bool is_sampled(const struct soup *from, uint32_t count)
{
    const struct source source = source_of(from, count);
    struct triangle_sample *sample = triangle_sample_create(&source);
    triangle_sample_release(sample);
    return sample;
}

TEST(test_triangles_that_are_not_sampled)
{
    struct random random = random_of("refits");
    struct soup soup;
    write_soup(&random, &soup);
    assert_true(is_sampled(&soup, COUNT) && is_sampled(&soup, 64) && !is_sampled(&soup, 63));
    soup.corners[7][1][0] = NAN;
    assert_false(is_sampled(&soup, COUNT));
    soup.corners[7][1][0] = INFINITY;
    assert_false(is_sampled(&soup, COUNT));
    soup.corners[7][1][0] = 0;
    WITHOUT_MEMORY(assert_false(is_sampled(&soup, COUNT)));
}

TEST(test_costs_that_are_unknown)
{
    struct random random = random_of("refits");
    struct soup built, now;
    write_soup(&random, &built);
    write_soup(&random, &now);
    const struct source before = source_of(&built, COUNT), fewer = source_of(&now, COUNT - 1),
                        after = source_of(&now, COUNT);
    struct triangle_sample *sample = triangle_sample_create(&before),
                           *shared = triangle_sample_share(sample),
                           *of_fewer = triangle_sample_create(&fewer),
                           *moved = triangle_sample_create(&after);
    triangle_sample_release(sample);
    assert_true(triangle_sample_refit_cost(shared, of_fewer) == 0);
    assert_true(triangle_sample_refit_cost(shared, moved) > 2);
    WITHOUT_MEMORY(assert_true(triangle_sample_refit_cost(shared, moved) == 0));
    now.corners[0][0][1] = INFINITY;
    assert_null(triangle_sample_create(&after));
    triangle_sample_release(shared);
    triangle_sample_release(of_fewer);
    triangle_sample_release(moved);
}
