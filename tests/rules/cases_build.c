/* SPDX-License-Identifier: Apache-2.0 */
/* The members of VkAccelerationStructureBuildGeometryInfoKHR on their own. */
#include "case.h"

static const VkBaseInStructure stray = {.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO};
static const VkBaseInStructure unknown = {.sType = (VkStructureType)2000000123};

static void prefer_one_each(struct scene *scene)
{
    scene->infos[AABBS].flags = VK_BUILD_ACCELERATION_STRUCTURE_PREFER_FAST_BUILD_BIT_KHR;
    scene->infos[TLAS].flags = VK_BUILD_ACCELERATION_STRUCTURE_PREFER_FAST_TRACE_BIT_KHR;
    scene_give_objects(scene, AABBS);
    scene_give_objects(scene, TLAS);
}

#define FAST_BOTH                                                                                  \
    (VK_BUILD_ACCELERATION_STRUCTURE_PREFER_FAST_TRACE_BIT_KHR |                                   \
     VK_BUILD_ACCELERATION_STRUCTURE_PREFER_FAST_BUILD_BIT_KHR)
#define MICROMAP_FLAGS                                                                             \
    (VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_OPACITY_MICROMAP_UPDATE_BIT_EXT |                       \
     VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_DISABLE_OPACITY_MICROMAPS_BIT_EXT)

static const struct test_case cases[] = {
    CASE("info_stype_0", RULE(build_info_has_its_stype), EDITS(SET(infos[INDEXED].sType, 0)),
         .path = "pInfos[0].sType"),
    CASE("info_stype_of_geometry", RULE(build_info_has_its_stype),
         EDITS(SET(infos[TLAS].sType, VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_KHR)),
         .path = "pInfos[3].sType"),
    CASE("info_chain", RULE(build_info_has_no_chain), EDITS(SET(infos[AABBS].pNext, &stray)),
         .path = "pInfos[2].pNext"),
    CASE("info_chain_unknown", RULE(build_info_has_no_chain),
         EDITS(SET(infos[TLAS].pNext, &unknown))),
    CASE("info_chain_unreadable", RULE(build_info_has_no_chain),
         EDITS(SET(infos[UPDATE].pNext, 0x10)), .path = "pInfos[4].pNext"),
    CASE("type_out_of_range", RULE(build_type_is_valid), EDITS(SET(infos[AABBS].type, 3)),
         .path = "pInfos[2].type"),
    CASE("type_max_enum", RULE(build_type_is_valid),
         EDITS(SET(infos[TLAS].type, VK_ACCELERATION_STRUCTURE_TYPE_MAX_ENUM_KHR))),
    CASE("type_of_extension_not_enabled", RULE(build_type_is_valid),
         EDITS(SET(infos[AABBS].type, VK_ACCELERATION_STRUCTURE_TYPE_OPACITY_MICROMAP_KHR))),
    CASE("type_out_of_range_though_there_are_more", RULE(build_type_is_valid),
         SETUP(.enable = ENABLE_OPACITY_MICROMAP_KHR), EDITS(SET(infos[AABBS].type, 3))),
    CASE("type_of_an_unknown_extension", RULE(build_type_is_valid), .silent = true,
         SETUP(.enable = ENABLE_FUTURE), EDITS(SET(infos[AABBS].type, 1999999000))),
    CASE("type_generic", RULE(build_type_is_not_generic),
         EDITS(SET(infos[INDEXED].type, VK_ACCELERATION_STRUCTURE_TYPE_GENERIC_KHR)),
         .path = "pInfos[0].type"),
    /* Sizes depend on flags. */
    CASE("flags_unknown_bit", RULE(build_flags_are_valid),
         EDITS(SET(infos[INDEXED].flags, 1u << 30)),
         TWIN_EDITS(SET(infos[INDEXED].flags, 0), CALL_WITH(scene_give_objects, INDEXED)),
         .path = "pInfos[0].flags"),
    CASE("flags_of_extension_not_enabled", RULE(build_flags_are_valid),
         EDITS(SET(infos[AABBS].flags, VK_BUILD_ACCELERATION_STRUCTURE_MOTION_BIT_NV))),
    CASE("flags_of_micromaps_not_enabled", RULE(build_flags_are_valid),
         EDITS(SET(infos[INDEXED].flags, MICROMAP_FLAGS))),
    CASE("flags_of_micromaps_on_a_build_without_one", RULE(build_flags_are_valid), .silent = true,
         SETUP(.enable = ENABLE_OPACITY_MICROMAP_EXT),
         EDITS(SET(infos[INDEXED].flags, MICROMAP_FLAGS))),
    CASE("flags_of_unknown_extension", RULE(build_flags_are_valid), .silent = true,
         SETUP(.enable = ENABLE_FUTURE), EDITS(SET(infos[AABBS].flags, 1u << 30))),
    CASE("flags_prefer_both", RULE(fast_trace_excludes_fast_build),
         EDITS(SET(infos[AABBS].flags, FAST_BOTH)), .mutate_twin = prefer_one_each,
         .path = "pInfos[2].flags"),
    CASE("flags_prefer_both_and_low_memory", RULE(fast_trace_excludes_fast_build),
         EDITS(SET(infos[TLAS].flags,
                   FAST_BOTH | VK_BUILD_ACCELERATION_STRUCTURE_LOW_MEMORY_BIT_KHR))),
    CASE("mode_out_of_range", RULE(build_mode_is_valid), EDITS(SET(infos[AABBS].mode, 2)),
         .path = "pInfos[2].mode"),
    CASE("mode_max_enum", RULE(build_mode_is_valid),
         EDITS(SET(infos[REFIT].mode, VK_BUILD_ACCELERATION_STRUCTURE_MODE_MAX_ENUM_KHR))),

    SHARED(SETUP(.enable = ENABLE_OPACITY_MICROMAP_KHR), .prepare = scene_build_micromap,
           .path = "pInfos[2]."),
    CASE("micromap_updated", RULE(micromap_build_is_no_update),
         NAMES(RULE_micromap_build_has_no_source),
         EDITS(MAKE_STRUCTURE_WITH(infos[AABBS].srcAccelerationStructure, scene_accel_for, INDEXED),
               SET(infos[AABBS].mode, VK_BUILD_ACCELERATION_STRUCTURE_MODE_UPDATE_KHR))),
    /* By the letter: an update has a source, whatever it updates. */
    CASE("micromap_update_without_source", RULES(RULE_micromap_build_is_no_update),
         NAMES(RULE_update_has_a_source),
         EDITS(SET(infos[AABBS].mode, VK_BUILD_ACCELERATION_STRUCTURE_MODE_UPDATE_KHR))),
    CASE(
        "micromap_with_source", RULE(micromap_build_has_no_source),
        EDITS(MAKE_STRUCTURE_WITH(infos[AABBS].srcAccelerationStructure, scene_accel_for, INDEXED)),
        .path = "pInfos[2].srcAccelerationStructure"),

    SHARED(RULE(exactly_one_geometry_array_is_given)),
    CASE("update_without_source", RULE(update_has_a_source),
         EDITS(SET(infos[UPDATE].srcAccelerationStructure, 0)),
         .path = "pInfos[4].srcAccelerationStructure"),
    CASE("build_without_source", RULE(update_has_a_source), .silent = true,
         EDITS(SET(infos[INDEXED].srcAccelerationStructure, 0))),
    CASE("geometry_arrays_none", PREPARE_EDITS(SET(infos[AABBS].pGeometries, 0)),
         TWIN_EDITS(SET(infos[AABBS].geometryCount, 0)), .path = "pInfos[2]"),
    CASE("geometry_arrays_both",
         PREPARE_EDITS(POINT(infos[AABBS].ppGeometries, geometry_pointers[AABBS])),
         TWIN_EDITS(SET(infos[AABBS].pGeometries, 0))),
    CASE("geometry_arrays_both_without_geometries", .silent = true,
         EDITS(POINT(infos[AABBS].ppGeometries, geometry_pointers[AABBS]),
               SET(infos[AABBS].geometryCount, 0))),

    SHARED(RULE(tlas_has_one_geometry)),
    CASE("tlas_with_no_geometry", EDITS(SET(infos[TLAS].geometryCount, 0)),
         .path = "pInfos[3].geometryCount"),
    CASE("tlas_with_two_geometries",
         EDITS(COPY(geometries[TLAS][1], geometries[TLAS][0]),
               COPY(ranges[TLAS][1], ranges[TLAS][0]), SET(infos[TLAS].geometryCount, 2))),
    CASE("blas_with_no_geometry", .silent = true, EDITS(SET(infos[INDEXED].geometryCount, 0))),
    /* A bottom-level build of a triangle geometry and one of boxes. */
    CASE("blas_of_two_types", RULE(blas_geometries_have_one_type),
         PREPARE_EDITS(COPY(geometries[UNINDEXED][1], geometries[AABBS][0])),
         EDITS(COPY(ranges[UNINDEXED][1], ranges[AABBS][0])),
         TWIN_EDITS(SET(infos[UNINDEXED].geometryCount, 1)), .path = "pInfos[1].pGeometries"),
};

CASE_LIST(cases_build, cases);
