/* SPDX-License-Identifier: Apache-2.0 */
/* Build ranges: offsets, and the vertices that they reach without indices. */
#include "case.h"

#define FIRST_UNINDEXED TRIANGLES(UNINDEXED, 0)

static void offer_packed_format(struct null_driver_config *config)
{
    config->formats[config->format_count++] = (struct null_driver_format){
        VK_FORMAT_A2B10G10R10_SNORM_PACK32,
        VK_FORMAT_FEATURE_2_ACCELERATION_STRUCTURE_VERTEX_BUFFER_BIT_KHR};
}

static void limit_instances(struct null_driver_config *config)
{
    config->as_properties.maxInstanceCount = 5;
    config->sizes.structure.per_primitive = 0;
    config->sizes.build_scratch.per_primitive = 0;
}

static const struct setup with_packed_format = {.configure = offer_packed_format};
static const struct setup with_few_instances = {.configure = limit_instances};

static const struct test_case cases[] = {
    CASE("index_offset_misaligned", RULES(RULE_index_offset_is_aligned), .commands = ON_WITH_RANGES,
         .edits = EDITS(SET(ranges[INDEXED][0].primitiveOffset, 2)),
         .twin_edits = EDITS(SET(ranges[INDEXED][0].primitiveOffset, 4)),
         .path = "ppBuildRangeInfos[0][0].primitiveOffset", .below_content = true),
    CASE("index_offset_misaligned_to_16_bits", RULES(RULE_index_offset_is_aligned),
         .commands = ON_WITH_RANGES, .edits = EDITS(SET(ranges[UNINDEXED][1].primitiveOffset, 3)),
         .twin_edits = EDITS(SET(ranges[UNINDEXED][1].primitiveOffset, 6)),
         .path = "ppBuildRangeInfos[1][1].primitiveOffset", .below_content = true),
    CASE("vertex_offset_misaligned", RULES(RULE_vertex_offset_is_aligned),
         .commands = ON_WITH_RANGES, .edits = EDITS(SET(ranges[UNINDEXED][0].primitiveOffset, 6)),
         .twin_edits = EDITS(SET(ranges[UNINDEXED][0].primitiveOffset, 4)),
         .path = "ppBuildRangeInfos[1][0].primitiveOffset"),
    CASE("vertex_offset_misaligned_to_16_bits", RULES(RULE_vertex_offset_is_aligned),
         .commands = ON_WITH_RANGES,
         .prepare_edits = EDITS(SET(FIRST_UNINDEXED.vertexFormat, VK_FORMAT_R16G16_SNORM)),
         .edits = EDITS(SET(ranges[UNINDEXED][0].primitiveOffset, 5)),
         .twin_edits = EDITS(SET(ranges[UNINDEXED][0].primitiveOffset, 6))),
    CASE("vertex_offset_misaligned_to_pack", RULES(RULE_vertex_offset_is_aligned),
         .commands = ON_WITH_RANGES, .setup = &with_packed_format,
         .prepare_edits =
             EDITS(SET(FIRST_UNINDEXED.vertexFormat, VK_FORMAT_A2B10G10R10_SNORM_PACK32)),
         .edits = EDITS(SET(ranges[UNINDEXED][0].primitiveOffset, 2)),
         .twin_edits = EDITS(SET(ranges[UNINDEXED][0].primitiveOffset, 8))),
    CASE("transform_offset_misaligned", RULES(RULE_transform_offset_is_aligned),
         .commands = ON_WITH_RANGES, .edits = EDITS(SET(ranges[INDEXED][0].transformOffset, 24)),
         .twin_edits = EDITS(SET(ranges[INDEXED][0].transformOffset, SCENE_TRANSFORM_OFFSET)),
         .path = "ppBuildRangeInfos[0][0].transformOffset", .below_content = true),
    CASE("transform_offset_ignored_for_boxes", RULES(RULE_transform_offset_is_aligned),
         .silent = true, .commands = ON_WITH_RANGES,
         .edits = EDITS(SET(ranges[AABBS][0].transformOffset, 3))),
    CASE("aabb_offset_misaligned", RULES(RULE_aabb_offset_is_aligned), .commands = ON_WITH_RANGES,
         .edits = EDITS(SET(ranges[AABBS][1].primitiveOffset, 4)),
         .twin_edits = EDITS(SET(ranges[AABBS][1].primitiveOffset, 8)),
         .path = "ppBuildRangeInfos[2][1].primitiveOffset"),
    CASE("instance_offset_misaligned", RULES(RULE_instance_offset_is_aligned),
         .commands = ON_WITH_RANGES, .edits = EDITS(SET(ranges[TLAS][0].primitiveOffset, 8)),
         .twin_edits = EDITS(SET(ranges[TLAS][0].primitiveOffset, 64)),
         .path = "ppBuildRangeInfos[3][0].primitiveOffset", .below_content = true),
    CASE("instance_offset_misaligned_in_array_of_pointers", RULES(RULE_instance_offset_is_aligned),
         .commands = ON_DEVICE,
         .edits = EDITS(SET(INSTANCES(TLAS, 0).arrayOfPointers, VK_TRUE),
                        SET(ranges[TLAS][0].primitiveOffset, 8))),
    CASE("max_vertex_too_low", RULES(RULE_unindexed_vertices_are_within_max_vertex),
         .commands = ON_WITH_RANGES, .edits = EDITS(SET(FIRST_UNINDEXED.maxVertex, 4)),
         .twin_edits = EDITS(SET(FIRST_UNINDEXED.maxVertex, 6)), .path = "[1]",
         .below_content = true),
    CASE("max_vertex_too_low_for_first_vertex",
         RULES(RULE_unindexed_vertices_are_within_max_vertex), .commands = ON_WITH_RANGES,
         .edits = EDITS(SET(ranges[UNINDEXED][0].firstVertex, 1)),
         .twin_edits =
             EDITS(SET(ranges[UNINDEXED][0].firstVertex, 1), SET(FIRST_UNINDEXED.maxVertex, 6))),
    CASE("max_vertex_too_low_by_overflow", RULES(RULE_unindexed_vertices_are_within_max_vertex),
         .commands = ON_DEVICE, .edits = EDITS(SET(ranges[UNINDEXED][0].firstVertex, 0xffffffff))),
    CASE("max_vertex_without_primitives", RULES(RULE_unindexed_vertices_are_within_max_vertex),
         .silent = true, .commands = ON_WITH_RANGES,
         .edits =
             EDITS(SET(ranges[UNINDEXED][0].primitiveCount, 0), SET(FIRST_UNINDEXED.maxVertex, 0))),
    CASE("max_vertex_with_indices", RULES(RULE_unindexed_vertices_are_within_max_vertex),
         .silent = true, .commands = ON_WITH_RANGES,
         .edits = EDITS(SET(TRIANGLES(INDEXED, 0).maxVertex, 3))),
    CASE("instances_over_limit", RULES(RULE_instance_count_is_within_limit),
         .setup = &with_few_instances, .edits = EDITS(SET(ranges[TLAS][0].primitiveCount, 6)),
         .twin_edits = EDITS(SET(ranges[TLAS][0].primitiveCount, 5)), .path = "[3]"),
    /* No device takes as many, backend cpu included. */
    CASE("instances_over_any_limit", RULES(RULE_instance_count_is_within_limit),
         .commands = ON_COMMAND_BUFFERS,
         .edits = EDITS(SET(ranges[TLAS][0].primitiveCount, 0xffffffff)), .path = "[3]"),
    /* Nor has any host that much memory. */
    CASE("instances_over_any_limit",
         RULES(RULE_instance_count_is_within_limit, RULE_instance_host_address_is_readable),
         .commands = ON_HOST, .edits = EDITS(SET(ranges[TLAS][0].primitiveCount, 0xffffffff)),
         .path = "[3]"),
};

CASE_LIST(cases_range, cases);
