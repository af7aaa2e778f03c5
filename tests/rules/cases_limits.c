/* SPDX-License-Identifier: Apache-2.0 */
/* The limits of what a build may count: geometries and primitives. */
#include "case.h"

static void limit_counts(struct null_driver_config *config)
{
    config->as_properties.maxGeometryCount = 3;
    config->as_properties.maxPrimitiveCount = 10;
    config->as_properties.maxInstanceCount = 10;
    config->sizes.structure.per_primitive = 0;
    config->sizes.build_scratch.per_primitive = 0;
    config->sizes.update_scratch.per_primitive = 0;
}

static const struct setup with_limits = {.configure = limit_counts};

static void repeat_first_geometry(struct scene *scene, uint32_t build, VkDeviceSize count)
{
    for (uint32_t i = 1; i < count; i++) {
        scene->geometries[build][i] = scene->geometries[build][0];
        scene->ranges[build][i] = scene->ranges[build][0];
    }
    scene->infos[build].geometryCount = (uint32_t)count;
}

/* Each build stays within a limit that all of them together exceed. */
static void add_builds_of_many_primitives(struct scene *scene)
{
    for (int i = 0; i < 6; i++) {
        scene->ranges[scene_add_build(scene, INDEXED)][0].primitiveCount = 10;
        scene->ranges[scene_add_build(scene, AABBS)][0].primitiveCount = 7;
    }
}

static const struct test_case cases[] = {
    SHARED(RULE(blas_aabb_count_is_within_limit), .setup = &with_limits),
    CASE("geometries_over_limit", RULE(blas_geometry_count_is_within_limit),
         EITHER_CALL_FOR(repeat_first_geometry, INDEXED, 4, 3), .path = "pInfos[0].geometryCount"),
    CASE("aabbs_over_limit", .commands = ON_WITH_RANGES,
         EITHER_SET(ranges[AABBS][0].primitiveCount, 8, 7), .path = "pInfos[2]"),
    CASE("aabbs_over_limit_by_overflow", .commands = ON_DEVICE,
         EDITS(SET(ranges[AABBS][0].primitiveCount, 0xffffffff),
               SET(ranges[AABBS][1].primitiveCount, 1))),

    SHARED(.commands = ON_WITH_RANGES),
    CASE("triangles_over_limit", RULE(blas_triangle_count_is_within_limit), .setup = &with_limits,
         EITHER_SET(ranges[INDEXED][0].primitiveCount, 11, 10), .path = "pInfos[0]"),
    CASE("triangles_over_limit_together", RULE(blas_triangle_count_is_within_limit),
         .setup = &with_limits, EITHER_SET(ranges[UNINDEXED][1].primitiveCount, 9, 8)),
    /* No device takes as many, backend cpu included. */
    CASE("geometries_over_any_limit",
         RULES(RULE_blas_geometry_count_is_within_limit, RULE_geometries_are_readable,
               RULE_build_ranges_of_build_are_readable),
         EDITS(SET(infos[INDEXED].geometryCount, UINT32_MAX)), .keep_arrays = true),
    CASE("geometries_over_any_limit",
         RULES(RULE_blas_geometry_count_is_within_limit, RULE_geometries_are_readable,
               RULE_indirect_ranges_are_in_one_buffer),
         .commands = ON_INDIRECT, EDITS(SET(infos[INDEXED].geometryCount, UINT32_MAX))),
    CASE("aabbs_over_any_limit", RULE(blas_aabb_count_is_within_limit),
         EDITS(SET(BOXES(AABBS, 0).stride, 0), SET(ranges[AABBS][0].primitiveCount, 1u << 29))),
    CASE("triangles_over_any_limit", RULE(blas_triangle_count_is_within_limit),
         EDITS(SET(TRIANGLES(UNINDEXED, 0).vertexStride, 0),
               SET(TRIANGLES(UNINDEXED, 0).maxVertex, UINT32_MAX),
               SET(ranges[UNINDEXED][0].primitiveCount, 1u << 29))),

    SHARED(),
    CASE("primitives_of_all_builds_over_limit",
         RULES(RULE_blas_triangle_count_is_within_limit, RULE_blas_aabb_count_is_within_limit),
         .silent = true, .setup = &with_limits, .mutate = add_builds_of_many_primitives),
};

CASE_LIST(cases_limits, cases);
