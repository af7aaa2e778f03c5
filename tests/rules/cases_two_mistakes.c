/* SPDX-License-Identifier: Apache-2.0 */
/* Cases of a build with two mistakes, of which one is about its sizes: both are found, unless the
 * other is in what vkGetAccelerationStructureBuildSizesKHR reads, so that there are no sizes. */
#include "case.h"

static void need_update_scratch(struct scene *scene)
{
    if (scene_scratch_size(scene, UPDATE) == 0)
        scene_skip(scene, "the driver wants no scratch for updates");
}

/* A dst that is a byte too small. */
static void make_dst_small(struct scene *scene)
{
    const VkDeviceSize size = scene_sizes(scene, INDEXED).accelerationStructureSize;
    if (size < 2) {
        scene_skip(scene, "structures are too small to make one smaller");
        return;
    }
    scene->infos[INDEXED].dstAccelerationStructure =
        scene_accel_in(scene, &scene->dst_buffers[INDEXED], 0, size - 1,
                       VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR);
}

#define T_INDEXED TRIANGLES(INDEXED, 0)
#define NO_SCRATCH SET(infos[INDEXED].scratchData.deviceAddress, 0)

static const struct test_case cases[] = {
    SHARED(.mutate = need_update_scratch,
           EDITS(SET(infos[UPDATE].srcAccelerationStructure, 0),
                 SET(infos[UPDATE].scratchData.deviceAddress, 0)),
           .path = "pInfos[4].s"),
    CASE("update_without_source_and_scratch",
         RULES(RULE_update_has_a_source, RULE_update_scratch_is_in_one_buffer),
         .commands = ON_COMMAND_BUFFERS),
    CASE("update_without_source_and_scratch_by_the_host",
         RULES(RULE_update_has_a_source, RULE_update_scratch_is_host_memory), .commands = ON_HOST),

    SHARED(.commands = ON_COMMAND_BUFFERS),
    CASE("misaligned_indices_and_no_scratch",
         RULES(RULE_index_address_is_aligned, RULE_build_scratch_is_in_one_buffer),
         EDITS(ADD(T_INDEXED.indexData.deviceAddress, 2), NO_SCRATCH), .path = "pInfos[0]."),
    CASE("misaligned_indices_and_a_small_dst",
         RULES(RULE_index_address_is_aligned, RULE_dst_is_large_enough), .commands = ON_DEVICE,
         .mutate = make_dst_small, EDITS(ADD(T_INDEXED.indexData.deviceAddress, 2)),
         .path = "pInfos[0]."),
    CASE("no_vertices_and_no_scratch",
         RULES(RULE_input_address_is_in_a_buffer, RULE_build_scratch_is_in_one_buffer),
         EDITS(SET(T_INDEXED.vertexData.deviceAddress, 4), NO_SCRATCH), .path = "pInfos[0]."),
    CASE("misaligned_offset_and_no_scratch",
         RULES(RULE_index_offset_is_aligned, RULE_build_scratch_is_in_one_buffer),
         .commands = ON_DEVICE, EDITS(ADD(ranges[INDEXED][0].primitiveOffset, 2), NO_SCRATCH),
         .path = "p"),
    CASE("format_unsupported_hides_no_scratch", RULE(vertex_format_is_supported),
         EDITS(SET(T_INDEXED.vertexFormat, VK_FORMAT_A8_UNORM_KHR), NO_SCRATCH)),
    CASE("format_invalid_hides_no_scratch", RULE(vertex_format_is_valid),
         EDITS(SET(T_INDEXED.vertexFormat, VK_FORMAT_MAX_ENUM), NO_SCRATCH)),
    CASE(
        "geometry_type_invalid_hides_no_scratch", RULE(geometry_type_is_valid),
        EDITS(SET(geometries[INDEXED][0].geometryType, VK_GEOMETRY_TYPE_MAX_ENUM_KHR), NO_SCRATCH)),
};

CASE_LIST(cases_two_mistakes, cases);
