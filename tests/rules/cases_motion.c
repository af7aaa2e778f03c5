/* SPDX-License-Identifier: Apache-2.0 */
/* VK_NV_ray_tracing_motion_blur: builds with motion, and the second positions of triangles. */
#include "case.h"
#include "scene_extensions.h"

#define MOTION_PATH                                                                                \
    "pInfos[0].pGeometries[0].geometry.triangles."                                                 \
    "pNext<VkAccelerationStructureGeometryMotionTrianglesDataNV>.vertexData."

#define MOTION VK_BUILD_ACCELERATION_STRUCTURE_MOTION_BIT_NV
#define FLAGS_WITH_MOTION(build) SET(infos[build].flags, MOTION)

/* ---- second positions ---- */

static void chain_motion(struct scene *scene, uint64_t address)
{
    scene->motion = (VkAccelerationStructureGeometryMotionTrianglesDataNV){
        .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_MOTION_TRIANGLES_DATA_NV,
        .vertexData.deviceAddress = address};
    scene->geometries[INDEXED][0].geometry.triangles.pNext = &scene->motion;
    scene_give_motion_dst(scene, INDEXED);
    scene->infos[INDEXED].flags = MOTION;
}

static void moving(struct scene *scene)
{
    chain_motion(scene, scene_address(scene, &scene->vertices, 12));
}

static void moving_past_the_end(struct scene *scene)
{
    struct test_buffer buffer = scene_create_buffer(scene, 4096, INPUT_USAGE);
    const struct test_memory memory = scene_allocate(scene, 65536);
    scene_bind(scene, &buffer, &memory, 0);
    chain_motion(scene, buffer.address + 4096);
}

/* The structure begins where it can be read and ends where it can't. */
static void moving_off_the_page(struct scene *scene)
{
    VkBaseOutStructure *cut = bytes_before_unreadable_page(sizeof(*cut));
    cut->sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_MOTION_TRIANGLES_DATA_NV;
    scene->geometries[INDEXED][0].geometry.triangles.pNext = cut;
}

static const VkBaseInStructure info_for_creation = {
    .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_MOTION_INFO_NV};

static const struct test_case cases[] = {
    SHARED(SETUP(.enable = ENABLE_MOTION)),
    CASE("motion_dst_built_without_motion", RULE(motion_dst_is_built_with_motion),
         PREPARE_EDITS(CALL_WITH(scene_give_motion_dst, INDEXED)),
         TWIN_EDITS(FLAGS_WITH_MOTION(INDEXED)), .path = "pInfos[0].flags"),
    CASE("motion_tlas_built_without_motion", RULE(motion_dst_is_built_with_motion),
         PREPARE_EDITS(CALL_WITH(scene_give_motion_dst, TLAS)), TWIN_EDITS(FLAGS_WITH_MOTION(TLAS)),
         .may_fail_on_cpu = true, .below_content = true, .path = "pInfos[3].flags"),
    CASE("motion_build_of_plain_dst", RULE(motion_build_has_a_motion_dst),
         EDITS(FLAGS_WITH_MOTION(INDEXED)),
         TWIN_EDITS(CALL_WITH(scene_give_motion_dst, INDEXED), FLAGS_WITH_MOTION(INDEXED)),
         .path = "pInfos[0].flags"),
    CASE("motion_build_of_generic_type", RULES(RULE_build_type_is_not_generic),
         NAMES(RULE_motion_build_is_not_generic),
         PREPARE_EDITS(CALL_WITH(scene_give_motion_dst, INDEXED), FLAGS_WITH_MOTION(INDEXED)),
         EDITS(SET(infos[INDEXED].type, VK_ACCELERATION_STRUCTURE_TYPE_GENERIC_KHR)),
         .path = "pInfos[0]."),
    CASE("flags_of_motion", RULE(build_flags_are_valid), .silent = true,
         EDITS(CALL_WITH(scene_give_motion_dst, INDEXED), FLAGS_WITH_MOTION(INDEXED))),
    CASE("motion_data_of_other_stype", RULES(RULE_motion_triangles_have_their_stype),
         NAMES(RULE_triangles_chain_is_known), .prepare = moving,
         EDITS(SET(motion.sType, VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_MOTION_INFO_NV)),
         .path = "pInfos[0].pGeometries[0].geometry.triangles.pNext"),
    CASE("motion_data_without_stype", RULES(RULE_motion_triangles_have_their_stype),
         NAMES(RULE_triangles_chain_is_known), .prepare = moving, EDITS(SET(motion.sType, 0))),
    CASE("motion_data_and_a_stray", RULE(triangles_chain_is_known), .prepare = moving,
         EDITS(SET(motion.pNext, &info_for_creation))),
    CASE("motion_build_of_still_triangles", RULE(motion_triangles_have_their_stype), .silent = true,
         EDITS(CALL_WITH(scene_give_motion_dst, INDEXED), FLAGS_WITH_MOTION(INDEXED))),
    CASE("motion_data_off_the_page", RULE(triangles_chain_is_known), .prepare = moving,
         .mutate = moving_off_the_page),
    CASE("motion_address_null", RULE(motion_vertex_address_is_given),
         EDITS(CALL_WITH_SIZE(chain_motion, 0)), .mutate_twin = moving, .path = MOTION_PATH),
    CASE("motion_address_null_with_primitives", RULE(motion_vertex_address_is_given),
         PREPARE_EDITS(CALL_WITH_SIZE(chain_motion, 0)),
         TWIN_EDITS(SET(ranges[INDEXED][0].primitiveCount, 0))),
    CASE("motion_address_in_freed_memory_with_primitives", RULE(input_buffer_is_bound),
         .commands = ON_COMMAND_BUFFERS, .prepare = moving,
         PREPARE_EDITS(MAKE_ADDRESS(motion.vertexData.deviceAddress, scene_freed_address)),
         TWIN_EDITS(SET(ranges[INDEXED][0].primitiveCount, 0))),
    /* Not in a build with motion; the address has to be good all the same. */
    CASE("motion_address_null_in_build_without_motion", RULE(motion_vertex_address_is_given),
         EDITS(CALL_WITH_SIZE(chain_motion, 0), SET(infos[INDEXED].flags, 0),
               MAKE_STRUCTURE_WITH(infos[INDEXED].dstAccelerationStructure, scene_accel_for,
                                   INDEXED)),
         .mutate_twin = moving, .path = MOTION_PATH),
    CASE("motion_address_null_of_indirect_build", .silent = true, .commands = ON_INDIRECT,
         EDITS(CALL_WITH_SIZE(chain_motion, 0))),
    CASE("motion_address_past_the_end", RULE(input_address_is_in_a_buffer),
         .commands = ON_COMMAND_BUFFERS, .mutate = moving_past_the_end, .mutate_twin = moving,
         .path = MOTION_PATH "deviceAddress"),
    CASE("motion_address_in_freed_memory", RULE(input_buffer_is_bound),
         .commands = ON_COMMAND_BUFFERS, .prepare = moving,
         EDITS(MAKE_ADDRESS(motion.vertexData.deviceAddress, scene_freed_address)),
         .path = MOTION_PATH "deviceAddress"),
    /* 03673 lists members, and this is none of them. */
    CASE("motion_buffer_without_usage", RULE(input_buffer_has_build_input_usage), .silent = true,
         .mutate = moving,
         EDITS(MAKE_ADDRESS(motion.vertexData.deviceAddress, scene_address_without_usage))),
};

CASE_LIST(cases_motion, cases);
