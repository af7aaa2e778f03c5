/* SPDX-License-Identifier: Apache-2.0 */
/* Build ranges: offsets, and the vertices that they reach without indices. */
#include "case.h"

#define FIRST_UNINDEXED TRIANGLES(UNINDEXED, 0)

static void limit_instances(struct null_driver_config *config)
{
    config->as_properties.maxInstanceCount = 5;
    config->sizes.structure.per_primitive = 0;
    config->sizes.build_scratch.per_primitive = 0;
}

static const struct test_case cases[] = {
    SHARED(RULE(index_offset_is_aligned), .commands = ON_WITH_RANGES, .below_content = true),
    CASE("index_offset_misaligned", EITHER_SET(ranges[INDEXED][0].primitiveOffset, 2, 4),
         .path = "ppBuildRangeInfos[0][0].primitiveOffset"),
    CASE("index_offset_misaligned_to_16_bits",
         EITHER_SET(ranges[UNINDEXED][1].primitiveOffset, 3, 6),
         .path = "ppBuildRangeInfos[1][1].primitiveOffset"),

    SHARED(RULE(vertex_offset_is_aligned), .commands = ON_WITH_RANGES),
    CASE("vertex_offset_misaligned", EITHER_SET(ranges[UNINDEXED][0].primitiveOffset, 6, 4),
         .path = "ppBuildRangeInfos[1][0].primitiveOffset"),
    CASE("vertex_offset_misaligned_to_16_bits",
         PREPARE_EDITS(SET(FIRST_UNINDEXED.vertexFormat, VK_FORMAT_R16G16_SNORM)),
         EITHER_SET(ranges[UNINDEXED][0].primitiveOffset, 5, 6)),
    CASE("vertex_offset_misaligned_to_pack", SETUP(.configure = offer_packed_format),
         PREPARE_EDITS(SET(FIRST_UNINDEXED.vertexFormat, VK_FORMAT_A2B10G10R10_SNORM_PACK32)),
         EITHER_SET(ranges[UNINDEXED][0].primitiveOffset, 2, 8)),
    CASE("transform_offset_misaligned", RULE(transform_offset_is_aligned),
         EITHER_SET(ranges[INDEXED][0].transformOffset, 24, SCENE_TRANSFORM_OFFSET),
         .below_content = true, .path = "ppBuildRangeInfos[0][0].transformOffset"),
    CASE("transform_offset_ignored_for_boxes", RULE(transform_offset_is_aligned), .silent = true,
         EDITS(SET(ranges[AABBS][0].transformOffset, 3))),

    SHARED(RULE(instance_offset_is_aligned), .commands = ON_WITH_RANGES),
    CASE("aabb_offset_misaligned", RULE(aabb_offset_is_aligned),
         EITHER_SET(ranges[AABBS][1].primitiveOffset, 4, 8),
         .path = "ppBuildRangeInfos[2][1].primitiveOffset"),
    CASE("instance_offset_misaligned", EITHER_SET(ranges[TLAS][0].primitiveOffset, 8, 64),
         .below_content = true, .path = "ppBuildRangeInfos[3][0].primitiveOffset"),
    CASE("instance_offset_misaligned_in_array_of_pointers", .commands = ON_DEVICE,
         EDITS(SET(INSTANCES(TLAS, 0).arrayOfPointers, VK_TRUE),
               SET(ranges[TLAS][0].primitiveOffset, 8))),

    SHARED(RULE(unindexed_vertices_are_within_max_vertex), .commands = ON_WITH_RANGES),
    CASE("max_vertex_too_low", EITHER_SET(FIRST_UNINDEXED.maxVertex, 4, 6), .below_content = true,
         .path = "[1]"),
    CASE("max_vertex_too_low_for_first_vertex",
         PREPARE_EDITS(SET(ranges[UNINDEXED][0].firstVertex, 1)),
         TWIN_EDITS(SET(FIRST_UNINDEXED.maxVertex, 6))),
    CASE("max_vertex_too_low_by_overflow", .commands = ON_DEVICE,
         EDITS(SET(ranges[UNINDEXED][0].firstVertex, 0xffffffff))),
    CASE("max_vertex_without_primitives", .silent = true,
         EDITS(SET(ranges[UNINDEXED][0].primitiveCount, 0), SET(FIRST_UNINDEXED.maxVertex, 0))),
    CASE("max_vertex_with_indices", .silent = true, EDITS(SET(TRIANGLES(INDEXED, 0).maxVertex, 3))),

    SHARED(RULE(instance_count_is_within_limit), .path = "[3]"),
    CASE("instances_over_limit", SETUP(.configure = limit_instances),
         EITHER_SET(ranges[TLAS][0].primitiveCount, 6, 5)),
    /* No device takes as many, backend cpu included. */
    CASE("instances_over_any_limit", .commands = ON_COMMAND_BUFFERS,
         EDITS(SET(ranges[TLAS][0].primitiveCount, 0xffffffff))),
    /* Nor has any host that much memory. */
    CASE("instances_over_any_limit",
         RULES(RULE_instance_count_is_within_limit, RULE_instance_host_address_is_readable),
         .commands = ON_HOST, EDITS(SET(ranges[TLAS][0].primitiveCount, 0xffffffff))),
};

CASE_LIST(cases_range, cases);
