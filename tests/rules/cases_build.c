/* SPDX-License-Identifier: Apache-2.0 */
/* The members of VkAccelerationStructureBuildGeometryInfoKHR on their own. */
#include "case.h"

static const VkBaseInStructure stray = {.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO};
static const VkBaseInStructure unknown = {.sType = (VkStructureType)2000000123};

static void chain_stray(struct scene *scene)
{
    scene->infos[AABBS].pNext = &stray;
}

static void chain_unknown(struct scene *scene)
{
    scene->infos[TLAS].pNext = &unknown;
}

static void use_both_arrays(struct scene *scene)
{
    scene->infos[AABBS].ppGeometries = scene->geometry_pointers[AABBS];
}

static void use_only_pointers(struct scene *scene)
{
    use_both_arrays(scene);
    scene->infos[AABBS].pGeometries = NULL;
}

static void use_both_arrays_but_none_of_them(struct scene *scene)
{
    use_both_arrays(scene);
    scene->infos[AABBS].geometryCount = 0;
}

/* A bottom-level build of a triangle geometry and one of boxes. */
static void mix_geometries(struct scene *scene)
{
    scene->geometries[UNINDEXED][1] = scene->geometries[AABBS][0];
    scene->ranges[UNINDEXED][1] = scene->ranges[AABBS][0];
}

static void mix_only_beyond_count(struct scene *scene)
{
    scene->geometries[UNINDEXED][1] = scene->geometries[AABBS][0];
    scene->infos[UNINDEXED].geometryCount = 1;
}

static void prefer_one_each(struct scene *scene)
{
    scene->infos[AABBS].flags = VK_BUILD_ACCELERATION_STRUCTURE_PREFER_FAST_BUILD_BIT_KHR;
    scene->infos[TLAS].flags = VK_BUILD_ACCELERATION_STRUCTURE_PREFER_FAST_TRACE_BIT_KHR;
    scene_give_objects(scene, AABBS);
    scene_give_objects(scene, TLAS);
}

static void give_tlas_two_geometries(struct scene *scene)
{
    scene->geometries[TLAS][1] = scene->geometries[TLAS][0];
    scene->ranges[TLAS][1] = scene->ranges[TLAS][0];
    scene->infos[TLAS].geometryCount = 2;
}

/* Sizes depend on flags. */
static void set_no_flags(struct scene *scene)
{
    scene->infos[INDEXED].flags = 0;
    scene_give_objects(scene, INDEXED);
}

static void build_micromap_with_source(struct scene *scene)
{
    scene_build_micromap(scene);
    scene->infos[AABBS].srcAccelerationStructure = scene_accel_for(scene, INDEXED);
}

static const struct setup with_micromaps = {.enable = ENABLE_OPACITY_MICROMAP_EXT};
static const struct setup with_micromaps_khr = {.enable = ENABLE_OPACITY_MICROMAP_KHR};
static const struct setup with_future = {.enable = ENABLE_FUTURE};

#define FAST_BOTH                                                                                  \
    (VK_BUILD_ACCELERATION_STRUCTURE_PREFER_FAST_TRACE_BIT_KHR |                                   \
     VK_BUILD_ACCELERATION_STRUCTURE_PREFER_FAST_BUILD_BIT_KHR)
#define MICROMAP_FLAGS                                                                             \
    (VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_OPACITY_MICROMAP_UPDATE_BIT_EXT |                       \
     VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_DISABLE_OPACITY_MICROMAPS_BIT_EXT)

static const struct test_case cases[] = {
    {.name = "info_stype_0",
     RULES(RULE_build_info_has_its_stype),
     .edits = EDITS(SET(infos[INDEXED].sType, 0)),
     .path = "pInfos[0].sType"},
    {.name = "info_stype_of_geometry",
     RULES(RULE_build_info_has_its_stype),
     .edits = EDITS(SET(infos[TLAS].sType, VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_KHR)),
     .path = "pInfos[3].sType"},
    {.name = "info_chain",
     RULES(RULE_build_info_has_no_chain),
     .mutate = chain_stray,
     .path = "pInfos[2].pNext"},
    {.name = "info_chain_unknown", RULES(RULE_build_info_has_no_chain), .mutate = chain_unknown},
    {.name = "info_chain_unreadable",
     RULES(RULE_build_info_has_no_chain),
     .edits = EDITS(SET(infos[UPDATE].pNext, 0x10)),
     .path = "pInfos[4].pNext"},
    {.name = "type_out_of_range",
     RULES(RULE_build_type_is_valid),
     .edits = EDITS(SET(infos[AABBS].type, 3)),
     .path = "pInfos[2].type"},
    {.name = "type_max_enum",
     RULES(RULE_build_type_is_valid),
     .edits = EDITS(SET(infos[TLAS].type, VK_ACCELERATION_STRUCTURE_TYPE_MAX_ENUM_KHR))},
    {.name = "type_of_extension_not_enabled",
     RULES(RULE_build_type_is_valid),
     .edits = EDITS(SET(infos[AABBS].type, VK_ACCELERATION_STRUCTURE_TYPE_OPACITY_MICROMAP_KHR))},
    {.name = "type_out_of_range_though_there_are_more",
     RULES(RULE_build_type_is_valid),
     .setup = &with_micromaps_khr,
     .edits = EDITS(SET(infos[AABBS].type, 3))},
    {.name = "type_of_an_extension_nobody_knows",
     RULES(RULE_build_type_is_valid),
     .silent = true,
     .setup = &with_future,
     .edits = EDITS(SET(infos[AABBS].type, 1999999000))},
    {.name = "type_generic",
     RULES(RULE_build_type_is_not_generic),
     .edits = EDITS(SET(infos[INDEXED].type, VK_ACCELERATION_STRUCTURE_TYPE_GENERIC_KHR)),
     .path = "pInfos[0].type"},
    {.name = "flags_unknown_bit",
     RULES(RULE_build_flags_are_valid),
     .edits = EDITS(SET(infos[INDEXED].flags, 1u << 30)),
     .mutate_twin = set_no_flags,
     .path = "pInfos[0].flags"},
    {.name = "flags_of_extension_not_enabled",
     RULES(RULE_build_flags_are_valid),
     .edits = EDITS(SET(infos[AABBS].flags, VK_BUILD_ACCELERATION_STRUCTURE_MOTION_BIT_NV))},
    {.name = "flags_of_micromaps_not_enabled",
     RULES(RULE_build_flags_are_valid),
     .edits = EDITS(SET(infos[INDEXED].flags, MICROMAP_FLAGS))},
    {.name = "flags_of_micromaps_on_a_build_without_one",
     RULES(RULE_build_flags_are_valid),
     .silent = true,
     .setup = &with_micromaps,
     .edits = EDITS(SET(infos[INDEXED].flags, MICROMAP_FLAGS))},
    {.name = "flags_nobody_knows",
     RULES(RULE_build_flags_are_valid),
     .silent = true,
     .setup = &with_future,
     .edits = EDITS(SET(infos[AABBS].flags, 1u << 30))},
    {.name = "flags_prefer_both",
     RULES(RULE_fast_trace_excludes_fast_build),
     .edits = EDITS(SET(infos[AABBS].flags, FAST_BOTH)),
     .mutate_twin = prefer_one_each,
     .path = "pInfos[2].flags"},
    {.name = "flags_prefer_both_and_low_memory",
     RULES(RULE_fast_trace_excludes_fast_build),
     .edits = EDITS(
         SET(infos[TLAS].flags, FAST_BOTH | VK_BUILD_ACCELERATION_STRUCTURE_LOW_MEMORY_BIT_KHR))},
    {.name = "mode_out_of_range",
     RULES(RULE_build_mode_is_valid),
     .edits = EDITS(SET(infos[AABBS].mode, 2)),
     .path = "pInfos[2].mode"},
    {.name = "mode_max_enum",
     RULES(RULE_build_mode_is_valid),
     .edits = EDITS(SET(infos[REFIT].mode, VK_BUILD_ACCELERATION_STRUCTURE_MODE_MAX_ENUM_KHR))},
    {.name = "micromap_updated",
     RULES(RULE_micromap_build_is_no_update, RULE_micromap_build_has_no_source),
     .setup = &with_micromaps_khr,
     .mutate = build_micromap_with_source,
     .edits = EDITS(SET(infos[AABBS].mode, VK_BUILD_ACCELERATION_STRUCTURE_MODE_UPDATE_KHR)),
     .mutate_twin = scene_build_micromap,
     .path = "pInfos[2]."},
    /* By the letter: an update has a source, whatever it updates. */
    {.name = "micromap_update_without_source",
     RULES(RULE_micromap_build_is_no_update, RULE_update_has_a_source),
     .setup = &with_micromaps_khr,
     .mutate = scene_build_micromap,
     .edits = EDITS(SET(infos[AABBS].mode, VK_BUILD_ACCELERATION_STRUCTURE_MODE_UPDATE_KHR)),
     .mutate_twin = scene_build_micromap,
     .path = "pInfos[2]."},
    {.name = "micromap_with_source",
     RULES(RULE_micromap_build_has_no_source),
     .setup = &with_micromaps_khr,
     .mutate = build_micromap_with_source,
     .mutate_twin = scene_build_micromap,
     .path = "pInfos[2].srcAccelerationStructure"},
    {.name = "update_without_source",
     RULES(RULE_update_has_a_source),
     .edits = EDITS(SET(infos[UPDATE].srcAccelerationStructure, 0)),
     .path = "pInfos[4].srcAccelerationStructure"},
    {.name = "build_without_source",
     RULES(RULE_update_has_a_source),
     .silent = true,
     .edits = EDITS(SET(infos[INDEXED].srcAccelerationStructure, 0))},
    {.name = "geometry_arrays_none",
     RULES(RULE_exactly_one_geometry_array_is_given),
     .edits = EDITS(SET(infos[AABBS].pGeometries, 0)),
     .twin_edits = EDITS(SET(infos[AABBS].pGeometries, 0), SET(infos[AABBS].geometryCount, 0)),
     .path = "pInfos[2]"},
    {.name = "geometry_arrays_both",
     RULES(RULE_exactly_one_geometry_array_is_given),
     .mutate = use_both_arrays,
     .mutate_twin = use_only_pointers},
    {.name = "geometry_arrays_both_without_geometries",
     RULES(RULE_exactly_one_geometry_array_is_given),
     .silent = true,
     .mutate = use_both_arrays_but_none_of_them},
    {.name = "tlas_with_no_geometry",
     RULES(RULE_tlas_has_one_geometry),
     .edits = EDITS(SET(infos[TLAS].geometryCount, 0)),
     .path = "pInfos[3].geometryCount"},
    {.name = "tlas_with_two_geometries",
     RULES(RULE_tlas_has_one_geometry),
     .mutate = give_tlas_two_geometries},
    {.name = "blas_with_no_geometry",
     RULES(RULE_tlas_has_one_geometry),
     .silent = true,
     .edits = EDITS(SET(infos[INDEXED].geometryCount, 0))},
    {.name = "blas_of_two_types",
     RULES(RULE_blas_geometries_have_one_type),
     .mutate = mix_geometries,
     .mutate_twin = mix_only_beyond_count,
     .path = "pInfos[1].pGeometries"},
};

CASE_LIST(cases_build, cases);
