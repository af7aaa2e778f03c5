/* SPDX-License-Identifier: Apache-2.0 */
/* Trees of updates: what they cost, against what random lines look at in trees of the builder. */
#include <stdlib.h>
#include <string.h>

#include "src/advice/figures/refits.h"
#include "src/bvh/trace.h"
#include "src/platform/aligned.h"
#include "tests/figures/lines.h"
#include "tests/fixture/scarce_memory.h"
#include "tests/unit/unit_test.h"

enum { COUNT = 200, LINES = 20000, TREE_SIZE = 1 << 20 };

struct soup {
    float corners[COUNT][3][3];
};

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

static double cost_of(const struct soup *built, const struct soup *now)
{
    const struct source before = source_of(built, COUNT), after = source_of(now, COUNT);
    struct triangle_sample *sample = triangle_sample_create(&before),
                           *moved = triangle_sample_create(&after);
    assert_true(sample && moved);
    const double cost = triangle_sample_refit_cost(sample, moved);
    triangle_sample_release(sample);
    triangle_sample_release(moved);
    return cost;
}

/* ---- trees that lines go through */

static void *build(const struct soup *from, const struct soup *then)
{
    uint8_t *memory = aligned_allocate(BUILDER_ALIGNMENT, 2 * (size_t)TREE_SIZE);
    struct builder_geometry geometry = geometry_of(from);
    const VkAccelerationStructureBuildRangeInfoKHR range = {.primitiveCount = COUNT};
    const struct builder_input input = {
        .type = VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR,
        .flags = VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_UPDATE_BIT_KHR,
        .quality = BUILDER_BALANCED,
        .geometry_count = 1,
        .geometries = &geometry,
        .ranges = &range,
    };
    assert_non_null(memory);
    assert_int_equal(builder_build(&input, memory, TREE_SIZE, memory + TREE_SIZE, TREE_SIZE, NULL),
                     BUILDER_OK);
    geometry = geometry_of(then);
    assert_int_equal(
        builder_refit(&input, memory, memory, TREE_SIZE, memory + TREE_SIZE, TREE_SIZE, NULL),
        BUILDER_OK);
    return memory;
}

static enum trace_answer ignore(void *context, struct trace_hit *candidate)
{
    (void)context;
    (void)candidate;
    return TRACE_IGNORE;
}

/* The nodes and triangles that random lines look at. */
static double look_at(struct random *random, const void *tree)
{
    struct trace_counters counters = {0};
    const struct trace_scene scene = {
        .structure = tree, .accuracy = TRACE_FAST, .counters = &counters};
    const struct trace_visitor visitor = {.visit = ignore};
    float low[3], high[3];
    double lower[3], upper[3];
    assert_true(builder_bounds(tree, low, high));
    for (int i = 0; i < 3; i++) {
        lower[i] = low[i];
        upper[i] = high[i];
    }
    for (int lines = 0; lines < LINES;) {
        const struct line line = line_through(random, lower, upper);
        struct trace_ray ray = {.t_max = 1e6F};
        if (!line_meets(&line, lower, upper))
            continue;
        lines++;
        for (int i = 0; i < 3; i++) {
            ray.origin[i] = (float)line.origin[i];
            ray.direction[i] = (float)line.direction[i];
        }
        trace_candidates(&scene, &ray, &visitor);
    }
    return (double)(counters.nodes + counters.primitives);
}

TEST(test_cost_of_random_lines)
{
    struct random random = random_of("refits");
    struct soup built, now;
    write_soup(&random, &built);
    write_soup(&random, &now);
    void *kept = build(&built, &now), *fresh = build(&now, &now);
    const double cost = cost_of(&built, &now),
                 looked = look_at(&random, kept) / look_at(&random, fresh);
    assert_true(cost > 2);
    assert_true(fabs(cost - looked) <= 0.05 * looked);
    aligned_free(kept);
    aligned_free(fresh);
}

/* ---- what moves */

TEST(test_triangles_that_stay_together)
{
    struct random random = random_of("refits");
    struct soup built, now;
    write_soup(&random, &built);
    assert_true(cost_of(&built, &built) == 1);
    for (int i = 0; i < 9 * COUNT; i++) { /* all move, and swing a little */
        const float *from = built.corners[i / 9][i % 9 / 3];
        now.corners[i / 9][i % 9 / 3][i % 3] =
            100 + from[i % 3] +
            sinf(from[(i + 1) % 3] / 3) * (float)random_between(&random, 0.9, 1);
    }
    const double cost = cost_of(&built, &now);
    assert_true(cost > 0.5 && cost < 1.5);
}

/* ---- samples */

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
