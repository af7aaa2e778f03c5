/* SPDX-License-Identifier: Apache-2.0 */
#include "src/advice/figures/refits.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "src/platform/aligned.h"

enum { SAMPLES_MIN = 64, SAMPLES_MAX = 256 };

/* ---- samples */

static bool read_corners(const struct source *source, uint32_t primitive, float corners[3][3])
{
    struct triangle_record triangle;
    if (source_triangle(source, primitive, &triangle) != SOURCE_ACTIVE)
        return false;
    memcpy(corners[0], triangle.a, sizeof(triangle.a));
    memcpy(corners[1], triangle.b, sizeof(triangle.b));
    memcpy(corners[2], triangle.c, sizeof(triangle.c));
    bool is_finite = true;
    for (int i = 0; i < 9; i++)
        is_finite &= isfinite(corners[i / 3][i % 3]) != 0;
    return is_finite;
}

struct triangle_sample *triangle_sample_create(const struct source *source)
{
    const uint32_t count = source->count < SAMPLES_MAX ? source->count : SAMPLES_MAX;
    struct triangle_sample *sample =
        count < SAMPLES_MIN ? NULL : malloc(sizeof(*sample) + count * sizeof(sample->corners[0]));
    if (!sample)
        return NULL;
    atomic_init(&sample->block.references, 1);
    sample->count = count;
    sample->of = source->count;
    for (uint32_t i = 0; i < count; i++) {
        if (!read_corners(source, (uint32_t)((uint64_t)i * source->count / count),
                          sample->corners[i])) {
            free(sample);
            return NULL;
        }
    }
    return sample;
}

/* ---- trees */

struct tree {
    struct builder_geometry geometry;
    VkAccelerationStructureBuildRangeInfoKHR range;
    struct builder_input input;
    struct builder_sizes sizes;
    uint64_t scratch_size;
    uint8_t *structure; /* the scratch follows */
};

static void describe_sample(struct tree *tree, const struct triangle_sample *sample)
{
    tree->geometry = (struct builder_geometry){
        .type = VK_GEOMETRY_TYPE_TRIANGLES_KHR,
        .triangles = {.vertex_format = VK_FORMAT_R32G32B32_SFLOAT,
                      .index_type = VK_INDEX_TYPE_NONE_KHR,
                      .max_vertex = 3 * sample->count - 1,
                      .vertex_stride = sizeof(sample->corners[0][0]),
                      .vertices = sample->corners,
                      .vertices_size = sample->count * sizeof(sample->corners[0])}};
    tree->range = (VkAccelerationStructureBuildRangeInfoKHR){.primitiveCount = sample->count};
    tree->input = (struct builder_input){
        .type = VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR,
        .flags = VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_UPDATE_BIT_KHR,
        .quality = BUILDER_BALANCED,
        .geometry_count = 1,
        .geometries = &tree->geometry,
        .ranges = &tree->range,
    };
}

static uint64_t aligned(uint64_t size)
{
    return (size + BUILDER_ALIGNMENT - 1) / BUILDER_ALIGNMENT * BUILDER_ALIGNMENT;
}

static bool build_sample_tree(struct tree *tree, const struct triangle_sample *sample)
{
    describe_sample(tree, sample);
    tree->structure = NULL;
    if (builder_get_sizes(&tree->input, NULL, &tree->sizes) != BUILDER_OK)
        return false;
    tree->sizes.structure = aligned(tree->sizes.structure);
    tree->scratch_size = aligned(tree->sizes.build_scratch > tree->sizes.update_scratch
                                     ? tree->sizes.build_scratch
                                     : tree->sizes.update_scratch);
    tree->structure =
        aligned_allocate(BUILDER_ALIGNMENT, tree->sizes.structure + tree->scratch_size);
    return tree->structure && builder_build(&tree->input, tree->structure, tree->sizes.structure,
                                            tree->structure + tree->sizes.structure,
                                            tree->scratch_size, NULL) == BUILDER_OK;
}

static bool refit(struct tree *tree, const struct triangle_sample *sample)
{
    describe_sample(tree, sample);
    return builder_refit(&tree->input, tree->structure, tree->structure, tree->sizes.structure,
                         tree->structure + tree->sizes.structure, tree->scratch_size,
                         NULL) == BUILDER_OK;
}

static double cost_of(const struct tree *tree)
{
    struct builder_statistics statistics;
    builder_measure(tree->structure, &statistics);
    return statistics.sah;
}

double triangle_sample_refit_cost(const struct triangle_sample *built,
                                  const struct triangle_sample *now)
{
    struct tree kept, fresh;
    if (built->of != now->of)
        return 0;
    const bool is_kept = build_sample_tree(&kept, built) && refit(&kept, now),
               is_fresh = build_sample_tree(&fresh, now);
    const double times = is_kept && is_fresh ? cost_of(&kept) / cost_of(&fresh) : 0;
    aligned_free(kept.structure);
    aligned_free(fresh.structure);
    return isfinite(times) ? times : 0;
}
