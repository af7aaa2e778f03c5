/* SPDX-License-Identifier: Apache-2.0 */
/* Builds of micromaps, and the build flags about micromaps. */
#include "case.h"

#define MICROMAP_FLAG(name) VK_BUILD_ACCELERATION_STRUCTURE_##name

static const struct setup with_ext = {.enable = ENABLE_OPACITY_MICROMAP_EXT};
static const struct setup with_khr = {.enable = ENABLE_OPACITY_MICROMAP_KHR};
static const struct setup with_ext_feature_alone = {.enable = ENABLE_OPACITY_MICROMAP_EXT |
                                                              ENABLE_OPACITY_MICROMAP_KHR,
                                                    .disable = DISABLE_MICROMAP_KHR};
static const struct setup without_features = {
    .enable = ENABLE_OPACITY_MICROMAP_EXT | ENABLE_OPACITY_MICROMAP_KHR,
    .disable = DISABLE_MICROMAP_EXT | DISABLE_MICROMAP_KHR};

/* ---- builds ---- */

static void use_4_state_usages(struct scene *scene)
{
    scene_build_micromap(scene);
    for (uint32_t i = 0; i < SCENE_USAGES; i++) {
        scene->micromaps.usages[i].format = VK_OPACITY_MICROMAP_FORMAT_4_STATE_KHR;
        scene->micromaps.triangles[i].format = VK_OPACITY_MICROMAP_FORMAT_4_STATE_KHR;
    }
}

static void build_into(struct scene *scene, VkAccelerationStructureTypeKHR type)
{
    scene_build_micromap(scene);
    scene->infos[AABBS].dstAccelerationStructure = scene_micromap_structure(scene, type);
}

static void build_into_half_the_size(struct scene *scene)
{
    const VkDeviceSize size = scene_sizes(scene, AABBS).accelerationStructureSize / 2;
    const struct test_buffer buffer = scene_buffer(scene, size, ACCEL_USAGE);
    scene->infos[AABBS].dstAccelerationStructure = scene_accel_in(
        scene, &buffer, 0, size, VK_ACCELERATION_STRUCTURE_TYPE_OPACITY_MICROMAP_KHR);
}

static void give_scratch(struct scene *scene, VkDeviceSize size)
{
    scene_build_micromap(scene);
    const struct test_buffer buffer = scene_buffer(scene, size, SCRATCH_USAGE);
    scene->infos[AABBS].scratchData.deviceAddress = buffer.address;
}

static void give_scratch_of_half_the_size(struct scene *scene)
{
    give_scratch(scene, scene_sizes(scene, AABBS).buildScratchSize / 2);
}

static void give_scratch_of_just_the_size(struct scene *scene)
{
    give_scratch(scene, scene_sizes(scene, AABBS).buildScratchSize);
}

/* ---- geometries ---- */

static void add_second_data(struct scene *scene)
{
    static VkAccelerationStructureGeometryMicromapDataKHR second;
    scene_build_micromap(scene);
    second = scene->micromaps.data;
    scene->micromaps.data.pNext = &second;
}

static const struct test_case cases[] = {
    CASE("micromap_update_and_data_update", RULE(micromap_update_excludes_data_update),
         .setup = &with_ext,
         EDITS(SET(infos[INDEXED].flags,
                   MICROMAP_FLAG(ALLOW_OPACITY_MICROMAP_UPDATE_BIT_KHR) |
                       MICROMAP_FLAG(ALLOW_OPACITY_MICROMAP_DATA_UPDATE_BIT_EXT))),
         TWIN_EDITS(SET(infos[INDEXED].flags, MICROMAP_FLAG(ALLOW_OPACITY_MICROMAP_UPDATE_BIT_KHR)),
                    SET(infos[UNINDEXED].flags,
                        MICROMAP_FLAG(ALLOW_OPACITY_MICROMAP_DATA_UPDATE_BIT_EXT))),
         .path = "pInfos[0].flags"),
    CASE("data_update_without_feature", RULE(micromap_data_update_flag_has_its_feature),
         SETUP(.enable = ENABLE_OPACITY_MICROMAP_EXT, .disable = DISABLE_MICROMAP_EXT),
         .twin_setup = &with_ext,
         PREPARE_EDITS(
             SET(infos[INDEXED].flags, MICROMAP_FLAG(ALLOW_OPACITY_MICROMAP_DATA_UPDATE_BIT_EXT))),
         .path = "pInfos[0].flags"),
    CASE("micromap_update_without_feature", RULE(micromap_update_flag_has_its_feature),
         .setup = &without_features,
         TWIN_SETUP(.enable = ENABLE_OPACITY_MICROMAP_EXT | ENABLE_OPACITY_MICROMAP_KHR),
         PREPARE_EDITS(
             SET(infos[INDEXED].flags, MICROMAP_FLAG(ALLOW_OPACITY_MICROMAP_UPDATE_BIT_KHR))),
         .path = "pInfos[0].flags"),
    CASE("micromap_update_without_khr_feature", RULE(micromap_update_flag_has_its_feature),
         SETUP(.enable = ENABLE_OPACITY_MICROMAP_KHR, .disable = DISABLE_MICROMAP_KHR),
         .twin_setup = &with_ext_feature_alone,
         PREPARE_EDITS(
             SET(infos[AABBS].flags, MICROMAP_FLAG(ALLOW_OPACITY_MICROMAP_UPDATE_BIT_KHR)))),
    CASE("disable_micromaps_without_feature", RULE(disable_micromaps_flag_has_its_feature),
         .setup = &without_features, .twin_setup = &with_khr,
         PREPARE_EDITS(
             SET(infos[INDEXED].flags, MICROMAP_FLAG(ALLOW_DISABLE_OPACITY_MICROMAPS_BIT_KHR))),
         .path = "pInfos[0].flags"),

    SHARED(.commands = ON_WITH_RANGES, .refusal = &indirect_takes_no_micromap, .setup = &with_khr,
           .may_fail_on_cpu = true),
    CASE("micromap_build_without_feature", RULE(micromap_build_feature_is_enabled),
         SETUP(.enable = ENABLE_OPACITY_MICROMAP_KHR, .disable = DISABLE_MICROMAP_KHR),
         .twin_setup = &with_khr, .prepare = scene_build_micromap, .path = "pInfos[2].type"),
    CASE("micromap_build_with_ext_feature_alone", RULE(micromap_build_feature_is_enabled),
         .setup = &with_ext_feature_alone,
         TWIN_SETUP(.enable = ENABLE_OPACITY_MICROMAP_EXT | ENABLE_OPACITY_MICROMAP_KHR),
         .prepare = scene_build_micromap),
    CASE("micromap_build_that_allows_update", RULE(micromap_build_flags_are_allowed),
         .mutate = scene_build_micromap,
         EITHER_SET(infos[AABBS].flags, MICROMAP_FLAG(ALLOW_UPDATE_BIT_KHR),
                    MICROMAP_FLAG(ALLOW_COMPACTION_BIT_KHR) |
                        MICROMAP_FLAG(PREFER_FAST_BUILD_BIT_KHR) |
                        MICROMAP_FLAG(MICROMAP_LOSSY_BIT_KHR)),
         .mutate_twin = use_4_state_usages, .path = "pInfos[2].flags"),
    CASE("micromap_build_that_prefers_fast_trace", RULE(micromap_build_flags_are_allowed),
         .silent = true, .prepare = scene_build_micromap,
         EDITS(SET(infos[AABBS].flags, MICROMAP_FLAG(PREFER_FAST_TRACE_BIT_KHR)))),
    CASE("micromap_build_of_two_geometries", RULE(micromap_build_has_one_geometry),
         .prepare = scene_build_micromap, EDITS(SET(infos[AABBS].geometryCount, 2)),
         .path = "pInfos[2].geometryCount"),
    CASE("micromap_build_of_no_geometry", RULE(micromap_build_has_one_geometry),
         .prepare = scene_build_micromap, EDITS(SET(infos[AABBS].geometryCount, 0))),

    SHARED(.setup = &with_khr),
    CASE("lossy_blas", RULE(lossy_build_is_a_micromap),
         EDITS(SET(infos[INDEXED].flags, MICROMAP_FLAG(MICROMAP_LOSSY_BIT_KHR))),
         .path = "pInfos[0].type"),
    CASE("lossy_micromap", RULE(lossy_build_is_a_micromap), .silent = true, .commands = ON_DEVICE,
         .mutate = use_4_state_usages,
         EDITS(SET(infos[AABBS].flags, MICROMAP_FLAG(MICROMAP_LOSSY_BIT_KHR)))),
    CASE("micromap_build_with_build_ranges", RULE(micromap_build_has_no_build_ranges),
         .prepare = scene_build_micromap, EDITS(POINT(range_pointers[AABBS], ranges[AABBS])),
         .path = "pInfos[2]"),
    CASE("micromap_build_on_the_host_without_ranges", RULE(build_ranges_of_build_are_readable),
         .commands = ON_HOST, .prepare = scene_build_micromap, .may_fail_on_cpu = true,
         EDITS(SET(range_pointers[AABBS], 0)), .path = "ppBuildRangeInfos[2]"),
    CASE("micromap_build_indirect", RULE(micromap_build_is_not_indirect),
         .mutate = scene_build_micromap, .path = "pInfos[2].type"),
    CASE("micromap_build_into_blas", RULE(micromap_dst_is_micromap_or_generic),
         EITHER_CALL(build_into, VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR,
                     VK_ACCELERATION_STRUCTURE_TYPE_GENERIC_KHR),
         .path = "pInfos[2].dstAccelerationStructure"),

    SHARED(.commands = ON_DEVICE, .setup = &with_khr, .prepare = scene_build_micromap),
    CASE("micromap_build_into_too_little", RULE(dst_is_large_enough),
         .mutate = build_into_half_the_size, .path = "pInfos[2].dstAccelerationStructure"),
    CASE("micromap_build_with_too_little_scratch", RULE(build_scratch_is_in_one_buffer),
         .mutate = give_scratch_of_half_the_size, .mutate_twin = give_scratch_of_just_the_size,
         .path = "pInfos[2].scratchData"),

    SHARED(RULE(other_build_geometry_is_not_a_micromap), .commands = ON_WITH_RANGES,
           .setup = &with_khr, .may_fail_on_cpu = true,
           .path = "pInfos[2].pGeometries[0].geometryType"),
    CASE("micromap_build_of_triangles", RULE(micromap_build_geometry_is_a_micromap),
         .refusal = &indirect_takes_no_micromap, .prepare = scene_build_micromap,
         EDITS(COPY(geometries[AABBS][0], geometries[INDEXED][0]))),
    CASE("blas_of_a_micromap",
         PREPARE_EDITS(CALL_WITH(build_into, VK_ACCELERATION_STRUCTURE_TYPE_GENERIC_KHR)),
         EDITS(SET(infos[AABBS].type, VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR))),
    CASE("blas_of_a_micromap_indirect", .commands = ON_INDIRECT,
         EDITS(CALL_WITH(build_into, VK_ACCELERATION_STRUCTURE_TYPE_GENERIC_KHR),
               SET(infos[AABBS].type, VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR))),

    SHARED(.commands = ON_WITH_RANGES, .refusal = &indirect_takes_no_micromap, .setup = &with_khr,
           .may_fail_on_cpu = true),
    CASE("micromap_geometry_without_data", RULE(micromap_geometry_has_micromap_data),
         .prepare = scene_build_micromap, EDITS(SET(geometries[AABBS][0].pNext, 0)),
         .path = "pInfos[2].pGeometries[0].pNext"),
    CASE("micromap_geometry_with_data_twice", RULES(RULE_geometry_chain_has_no_duplicates),
         NAMES(RULE_micromap_geometry_has_micromap_data), .mutate = add_second_data,
         .mutate_twin = scene_build_micromap),
    CASE("micromap_geometry_with_flags", RULE(micromap_geometry_has_no_flags),
         .prepare = scene_build_micromap,
         EDITS(SET(geometries[AABBS][0].flags, VK_GEOMETRY_OPAQUE_BIT_KHR)),
         .path = "pInfos[2].pGeometries[0].flags"),
    CASE("micromap_data_stype", RULES(RULE_micromap_data_has_its_stype),
         NAMES(RULE_geometry_chain_is_known, RULE_micromap_geometry_has_micromap_data),
         .prepare = scene_build_micromap,
         EDITS(SET(micromaps.data.sType,
                   VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_OPACITY_MICROMAP_FEATURES_KHR)),
         .path = "pInfos[2].pGeometries[0].pNext"),

    SHARED(.path = "pInfos[0].pGeometries[0].geometry.triangles.pNext"),
    CASE("opacity_stype", RULES(RULE_opacity_has_its_stype), NAMES(RULE_triangles_chain_is_known),
         .setup = &with_khr, .prepare = scene_use_micromap,
         EDITS(SET(micromaps.opacity.sType,
                   VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_MICROMAP_DATA_KHR)),
         .may_fail_on_cpu = true),
    CASE("ext_opacity_stype", RULES(RULE_ext_opacity_has_its_stype),
         NAMES(RULE_triangles_chain_is_known), .setup = &with_ext,
         .prepare = scene_use_micromap_ext,
         EDITS(SET(micromaps.opacity_ext.sType, VK_STRUCTURE_TYPE_MICROMAP_BUILD_INFO_EXT))),
    CASE("displacement_stype", RULE(displacement_has_its_stype),
         NAMES(RULE_triangles_chain_is_known), SETUP(.enable = ENABLE_DISPLACEMENT_MICROMAP),
         .prepare = scene_use_displacement,
         EDITS(SET(micromaps.displacement.sType,
                   VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DISPLACEMENT_MICROMAP_FEATURES_NV))),
};

CASE_LIST(cases_micromap, cases);
