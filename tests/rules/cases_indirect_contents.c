/* SPDX-License-Identifier: Apache-2.0 */
/* The build ranges that the indirect command reads from memory. */
#include <string.h>

#include "case.h"

static const struct setup with_content = {.level = "content"};

#define ALLOW_UPDATE VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_UPDATE_BIT_KHR

/* One primitive less than the second geometry has. */
static void allow_fewer(struct scene *scene)
{
    static const uint32_t fewer[SCENE_GEOMETRIES] = {2, 1};
    scene->count_pointers[UNINDEXED] = fewer;
}

static void empty_boxes(struct scene *scene)
{
    memset(scene->boxes.host + SCENE_BUFFER_SIZE / 2, 0, SCENE_BUFFER_SIZE / 2);
}

static uint32_t update_of_itself(struct scene *scene)
{
    scene->infos[UNINDEXED].flags |= ALLOW_UPDATE;
    const uint32_t build = scene_add_build(scene, UNINDEXED);
    scene->infos[UNINDEXED].flags &= ~ALLOW_UPDATE;
    scene_build_before(scene, build, 1);
    scene->infos[build].mode = VK_BUILD_ACCELERATION_STRUCTURE_MODE_UPDATE_KHR;
    scene->infos[build].srcAccelerationStructure = scene->infos[build].dstAccelerationStructure;
    return build;
}

static void update_fewer(struct scene *scene)
{
    scene->ranges[update_of_itself(scene)][1].primitiveCount = 1;
}

static void update_as_many(struct scene *scene)
{
    update_of_itself(scene);
}

/* More than any device takes, and than the call says. */
enum { TOO_MANY = 1 << 29 };

#define READS_TOO_MANY(build)                                                                      \
    static void read_too_many_of_##build(struct scene *scene)                                      \
    {                                                                                              \
        static const uint32_t counts[SCENE_GEOMETRIES] = {2, 3};                                   \
        scene->count_pointers[build] = counts;                                                     \
        scene->ranges[build][0].primitiveCount = TOO_MANY;                                         \
    }
READS_TOO_MANY(INDEXED)
READS_TOO_MANY(AABBS)

static void limit_primitives(struct null_driver_config *config)
{
    config->as_properties.maxPrimitiveCount = 6;
}

static const struct setup with_few_primitives = {.configure = limit_primitives, .level = "content"};

#define READS(name, build, count)                                                                  \
    static void name(struct scene *scene)                                                          \
    {                                                                                              \
        scene->ranges[build][1].primitiveCount = count;                                            \
        scene_give_objects(scene, build);                                                          \
    }
READS(read_6_triangles, UNINDEXED, 4)
READS(read_7_triangles, UNINDEXED, 5)
READS(read_7_boxes, AABBS, 4)

static void empty_instances(struct scene *scene)
{
    memset(scene->instances.host, 0, SCENE_BUFFER_SIZE);
}

static const struct test_case cases[] = {
    SHARED(.commands = ON_INDIRECT, .setup = &with_content),
    CASE("more_primitives_read_than_allowed", RULE(indirect_primitive_count_is_within_maximum),
         .mutate = allow_fewer,
         .path = "ppMaxPrimitiveCounts[1][1] is 1, less than primitiveCount (2)"),
    CASE("index_offset_read_misaligned", RULES(RULE_index_offset_is_aligned),
         NAMES(RULE_indirect_build_ranges_are_valid),
         EITHER_SET(ranges[UNINDEXED][1].primitiveOffset, 1003, 1002),
         .path = "pIndirectDeviceAddresses[1][1].primitiveOffset 1003 is not a multiple of"),
    CASE("vertex_offset_read_misaligned", RULES(RULE_vertex_offset_is_aligned),
         NAMES(RULE_indirect_build_ranges_are_valid),
         EITHER_SET(ranges[UNINDEXED][0].primitiveOffset, 6, 4),
         .path = "pIndirectDeviceAddresses[1][0].primitiveOffset 6"),
    CASE("transform_offset_read_misaligned", RULES(RULE_transform_offset_is_aligned),
         NAMES(RULE_indirect_build_ranges_are_valid),
         EITHER_SET(ranges[UNINDEXED][0].transformOffset, 8, 32),
         .path = "pIndirectDeviceAddresses[1][0].transformOffset 8"),
    CASE("box_offset_read_misaligned", RULES(RULE_aabb_offset_is_aligned),
         NAMES(RULE_indirect_build_ranges_are_valid), .mutate = empty_boxes,
         EITHER_SET(ranges[AABBS][1].primitiveOffset, 1028, 1032), .mutate_twin = empty_boxes,
         .path = "pIndirectDeviceAddresses[2][1].primitiveOffset 1028"),
    CASE("instance_offset_read_misaligned", RULES(RULE_instance_offset_is_aligned),
         NAMES(RULE_indirect_build_ranges_are_valid), .mutate = empty_instances,
         EITHER_SET(ranges[TLAS][0].primitiveOffset, 24, 16), .mutate_twin = empty_instances,
         .path = "pIndirectDeviceAddresses[3][0].primitiveOffset 24"),
    CASE("vertices_read_beyond_max_vertex", RULES(RULE_unindexed_vertices_are_within_max_vertex),
         NAMES(RULE_indirect_build_ranges_are_valid),
         EDITS(SET(ranges[UNINDEXED][0].firstVertex, 1)),
         .path = "pIndirectDeviceAddresses[1][0].primitiveCount 2 with firstVertex 1"),
    CASE("more_triangles_read_than_the_limit", RULE(blas_triangle_count_is_within_limit),
         .setup = &with_few_primitives, .mutate = read_7_triangles, .mutate_twin = read_6_triangles,
         .path = "has 7 triangles in all of its geometries, more than maxPrimitiveCount (6)"),
    CASE("more_boxes_read_than_the_limit", RULE(blas_aabb_count_is_within_limit),
         .setup = &with_few_primitives, .mutate = read_7_boxes,
         .path = "has 7 AABBs in all of its geometries, more than maxPrimitiveCount (6)"),
    CASE("more_triangles_read_than_any_limit",
         RULES(RULE_blas_triangle_count_is_within_limit,
               RULE_indirect_primitive_count_is_within_maximum),
         .mutate = read_too_many_of_INDEXED),
    CASE("more_boxes_read_than_any_limit",
         RULES(RULE_blas_aabb_count_is_within_limit,
               RULE_indirect_primitive_count_is_within_maximum),
         .mutate = read_too_many_of_AABBS),
    CASE("update_reads_fewer_primitives", RULE(indirect_primitive_count_matches_source),
         .mutate = update_fewer, .mutate_twin = update_as_many,
         .path = "has primitiveCount 1 in its build range"),
};

CASE_LIST(cases_indirect_contents, cases);
