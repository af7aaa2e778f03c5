/* SPDX-License-Identifier: Apache-2.0 */
/* Triangles that use opacity micromaps: of VK_KHR_opacity_micromap and VK_EXT_opacity_micromap. */
#include "case.h"

#define OPACITY_PATH(member)                                                                       \
    "pInfos[0].pGeometries[0].geometry.triangles."                                                 \
    "pNext<VkAccelerationStructureTrianglesOpacityMicromapKHR>." member
#define OPACITY_EXT_PATH(member)                                                                   \
    "pInfos[0].pGeometries[0].geometry.triangles."                                                 \
    "pNext<VkAccelerationStructureTrianglesOpacityMicromapEXT>." member

enum {
    /* As the null driver has them. */
    LIMIT_2_STATE = 6,
    LIMIT_4_STATE = 5,
    LIMIT_DISPLACEMENT = 5,
    LEVEL_OF_NONE = 13,
};

static void offer_limits(struct null_driver_config *config)
{
    config->micromap_properties.maxOpacity2StateSubdivisionLevel = LIMIT_2_STATE;
    config->micromap_properties.maxOpacity4StateSubdivisionLevel = LIMIT_4_STATE;
}

static const struct setup with_ext = {.enable = ENABLE_OPACITY_MICROMAP_EXT};
static const struct setup with_khr = {.enable = ENABLE_OPACITY_MICROMAP_KHR};

#define WITHOUT_INDICES                                                                            \
    SET(micromaps.opacity.indexType, VK_INDEX_TYPE_NONE_KHR),                                      \
        SET(micromaps.opacity.indexBuffer, 0), SET(micromaps.opacity.indexStride, 0)
#define USAGE_POINTERS                                                                             \
    SET(micromaps.opacity_ext.pUsageCounts, 0),                                                    \
        POINT(micromaps.opacity_ext.ppUsageCounts, micromaps.usage_pointers_ext)
#define MICROMAP                                                                                   \
    MAKE_STRUCTURE_WITH(micromaps.opacity.micromap, scene_micromap_structure,                      \
                        VK_ACCELERATION_STRUCTURE_TYPE_OPACITY_MICROMAP_KHR)

static void use_displacement_as_opacity(struct scene *scene)
{
    scene_use_micromap_ext(scene);
    scene->micromaps.opacity_ext.micromap =
        scene_micromap_ext(scene, VK_MICROMAP_TYPE_DISPLACEMENT_MICROMAP_NV);
    scene->micromaps.usages_ext[0].format =
        VK_DISPLACEMENT_MICROMAP_FORMAT_1024_TRIANGLES_128_BYTES_NV;
}

static const struct test_case cases[] = {
    SHARED(RULE(opacity_without_indices_has_a_micromap), .setup = &with_khr),
    CASE("micromap_destroyed", RULE(opacity_micromap_is_valid), .commands = ON_COMMAND_BUFFERS,
         .prepare = scene_use_micromap, EDITS(MICROMAP, DESTROY(micromaps.opacity.micromap)),
         .path = OPACITY_PATH("micromap")),
    CASE("micromap_destroyed_in_host_build",
         RULES(RULE_opacity_micromap_is_valid, RULE_host_build_uses_no_micromap),
         .commands = ON_HOST, .prepare = scene_use_micromap,
         EDITS(MICROMAP, DESTROY(micromaps.opacity.micromap)), .may_fail_on_cpu = true),
    CASE("micromap_null_without_indices", .commands = ON_COMMAND_BUFFERS,
         .prepare = scene_use_micromap, PREPARE_EDITS(WITHOUT_INDICES),
         EDITS(SET(micromaps.opacity.micromap, 0)), .path = OPACITY_PATH("micromap")),
    CASE("micromap_null_without_indices_in_host_build", .commands = ON_HOST,
         .prepare = scene_use_micromap, EDITS(WITHOUT_INDICES), .may_fail_on_cpu = true),
    CASE("micromap_null_with_indices", .silent = true, .mutate = scene_use_micromap,
         EDITS(SET(micromaps.opacity.micromap, 0)), .may_fail_on_cpu = true),

    SHARED(.setup = &with_khr, .prepare = scene_use_micromap),
    CASE("micromap_index_type_of_none", RULE(opacity_index_type_is_valid),
         NAMES(RULE_opacity_index_type_is_8_to_32_bits_or_none),
         EITHER_SET(micromaps.opacity.indexType, 7, VK_INDEX_TYPE_UINT8), .may_fail_on_cpu = true,
         .path = OPACITY_PATH("indexType")),
    CASE("micromap_without_indices_has_some", RULE(opacity_without_indices_has_no_index_buffer),
         .commands = ON_COMMAND_BUFFERS,
         EDITS(SET(micromaps.opacity.indexType, VK_INDEX_TYPE_NONE_KHR)),
         TWIN_EDITS(WITHOUT_INDICES), .path = OPACITY_PATH("indexBuffer")),
    /* Without indices the host, which takes no micromap, has nothing to go by. */
    CASE("micromap_without_indices_has_some_in_host_build",
         RULES(RULE_opacity_without_indices_has_no_index_buffer,
               RULE_opacity_without_indices_has_a_micromap),
         .commands = ON_HOST, EDITS(SET(micromaps.opacity.indexType, VK_INDEX_TYPE_NONE_KHR)),
         .may_fail_on_cpu = true),
    CASE("micromap_indices_at_0", RULE(opacity_index_buffer_is_given),
         EDITS(SET(micromaps.opacity.indexBuffer, 0)), .may_fail_on_cpu = true,
         .path = OPACITY_PATH("indexBuffer")),
    CASE("micromap_index_stride_6", RULE(opacity_index_stride_is_aligned),
         PREPARE_EDITS(SET(micromaps.opacity.indexStride, 6)),
         TWIN_EDITS(SET(micromaps.opacity.indexType, VK_INDEX_TYPE_UINT16)),
         .may_fail_on_cpu = true, .path = OPACITY_PATH("indexStride")),
    CASE("micromap_index_stride_beyond_32_bits",
         RULES(RULE_opacity_index_stride_fits_32_bits, RULE_opacity_indices_are_in_one_buffer),
         .commands = ON_DEVICE, EDITS(SET(micromaps.opacity.indexStride, 1ull << 32))),
    CASE("micromap_index_stride_beyond_32_bits_alone", RULE(opacity_index_stride_fits_32_bits),
         .commands = ON_COMMAND_BUFFERS | ON_HOST,
         EDITS(SET(micromaps.opacity.indexStride, 1ull << 32),
               SET(ranges[INDEXED][0].primitiveCount, 0)),
         TWIN_EDITS(SET(micromaps.opacity.indexStride, (1ull << 32) - 4),
                    SET(ranges[INDEXED][0].primitiveCount, 0)),
         .may_fail_on_cpu = true, .path = OPACITY_PATH("indexStride")),
    CASE(
        "micromap_indices_beyond_the_buffer", RULE(opacity_indices_are_in_one_buffer),
        EITHER_SET(micromaps.opacity.indexStride, SCENE_BUFFER_SIZE / 2 + 4, SCENE_BUFFER_SIZE / 2),
        .may_fail_on_cpu = true, .path = OPACITY_PATH("indexBuffer")),
    CASE("micromap_in_host_build", RULE(host_build_uses_no_micromap), EDITS(MICROMAP),
         .may_fail_on_cpu = true, .path = OPACITY_PATH("micromap")),

    SHARED(RULE(ext_opacity_micromap_is_valid), .setup = &with_ext,
           .prepare = scene_use_micromap_ext, .path = OPACITY_EXT_PATH("micromap")),
    CASE("ext_micromap_destroyed", EDITS(DESTROY(micromaps.opacity_ext.micromap))),
    CASE("ext_micromap_forged", EITHER_SET(micromaps.opacity_ext.micromap, 0x1234, 0)),

    SHARED(.setup = &with_ext, .prepare = scene_use_micromap_ext,
           .path = OPACITY_EXT_PATH("pUsageCounts")),
    CASE("ext_usages_both", RULE(ext_opacity_has_one_usage_array), PREPARE_EDITS(USAGE_POINTERS),
         EDITS(POINT(micromaps.opacity_ext.pUsageCounts, micromaps.usages_ext))),
    CASE("ext_usages_unreadable", RULE(ext_opacity_usages_are_readable),
         PREPARE_EDITS(UNREADABLE(micromaps.opacity_ext.pUsageCounts)),
         TWIN_EDITS(SET(micromaps.opacity_ext.usageCountsCount, 0))),
    CASE("ext_usage_behind_pointer_unreadable", RULE(ext_opacity_usage_pointers_are_readable),
         PREPARE_EDITS(USAGE_POINTERS), EDITS(UNREADABLE(micromaps.usage_pointers_ext[0])),
         .path = OPACITY_EXT_PATH("ppUsageCounts")),
    CASE("ext_usage_format_3", RULE(ext_opacity_usage_format_is_an_opacity_format),
         EITHER_SET(micromaps.usages_ext[0].format, 3, 2)),
    CASE("ext_usage_of_2_states_too_fine", RULE(ext_opacity_2_state_level_is_within_limit),
         SETUP(.enable = ENABLE_OPACITY_MICROMAP_EXT, .configure = offer_limits),
         EITHER_SET(micromaps.usages_ext[0].subdivisionLevel, LIMIT_2_STATE + 1, LIMIT_2_STATE)),
    CASE("ext_usage_of_4_states_too_fine", RULE(ext_opacity_4_state_level_is_within_limit),
         SETUP(.enable = ENABLE_OPACITY_MICROMAP_EXT, .configure = offer_limits),
         EDITS(SET(micromaps.usages_ext[0].subdivisionLevel, LIMIT_4_STATE + 1),
               SET(micromaps.usages_ext[0].format, VK_OPACITY_MICROMAP_FORMAT_4_STATE_EXT)),
         TWIN_EDITS(SET(micromaps.usages_ext[0].subdivisionLevel, LIMIT_4_STATE),
                    SET(micromaps.usages_ext[0].format, VK_OPACITY_MICROMAP_FORMAT_4_STATE_EXT))),
    /* No device has as many, backend cpu included. */
    CASE("ext_usage_of_2_states_finer_than_any", RULE(ext_opacity_2_state_level_is_within_limit),
         EITHER_SET(micromaps.usages_ext[0].subdivisionLevel, LEVEL_OF_NONE, LIMIT_2_STATE)),
    CASE("ext_usage_of_4_states_finer_than_any", RULE(ext_opacity_4_state_level_is_within_limit),
         EDITS(SET(micromaps.usages_ext[0].subdivisionLevel, LEVEL_OF_NONE),
               SET(micromaps.usages_ext[0].format, VK_OPACITY_MICROMAP_FORMAT_4_STATE_EXT)),
         TWIN_EDITS(SET(micromaps.usages_ext[0].subdivisionLevel, LIMIT_4_STATE),
                    SET(micromaps.usages_ext[0].format, VK_OPACITY_MICROMAP_FORMAT_4_STATE_EXT))),

    SHARED(SETUP(.enable = ENABLE_DISPLACEMENT_MICROMAP)),
    CASE("ext_usages_without_a_micromap",
         RULES(RULE_ext_opacity_usage_format_is_an_opacity_format,
               RULE_ext_opacity_2_state_level_is_within_limit,
               RULE_ext_opacity_usage_format_is_a_displacement_format,
               RULE_ext_opacity_displacement_level_is_within_limit),
         .silent = true, .mutate = scene_use_micromap_ext,
         EDITS(SET(micromaps.opacity_ext.micromap, 0),
               SET(micromaps.usages_ext[0].subdivisionLevel, 100),
               SET(micromaps.usages_ext[0].format, 100))),
    CASE("displacement_usage_format_4", RULE(ext_opacity_usage_format_is_a_displacement_format),
         .prepare = use_displacement_as_opacity, EDITS(SET(micromaps.usages_ext[0].format, 4)),
         .path = OPACITY_EXT_PATH("pUsageCounts")),
    CASE("displacement_usage_too_fine", RULE(ext_opacity_displacement_level_is_within_limit),
         .prepare = use_displacement_as_opacity,
         EITHER_SET(micromaps.usages_ext[0].subdivisionLevel, LIMIT_DISPLACEMENT + 1,
                    LIMIT_DISPLACEMENT),
         .path = OPACITY_EXT_PATH("pUsageCounts")),

    SHARED(.setup = &with_ext, .prepare = scene_use_micromap_ext),
    CASE("ext_index_type_of_none", RULE(ext_opacity_index_type_is_valid),
         EITHER_SET(micromaps.opacity_ext.indexType, 7, VK_INDEX_TYPE_UINT16),
         .path = OPACITY_EXT_PATH("indexType")),
    CASE("ext_index_type_of_8_bits", RULE(ext_opacity_index_type_is_16_or_32_bits_or_none),
         EDITS(SET(micromaps.opacity_ext.indexType, VK_INDEX_TYPE_UINT8)),
         .path = OPACITY_EXT_PATH("indexType")),
    CASE("ext_index_stride_6", RULE(ext_opacity_index_stride_is_aligned),
         PREPARE_EDITS(SET(micromaps.opacity_ext.indexStride, 6)),
         TWIN_EDITS(SET(micromaps.opacity_ext.indexType, VK_INDEX_TYPE_UINT16)),
         .path = OPACITY_EXT_PATH("indexStride")),
    CASE("ext_index_stride_beyond_32_bits", RULE(ext_opacity_index_stride_fits_32_bits),
         EITHER_SET(micromaps.opacity_ext.indexStride, 1ull << 32, (1ull << 32) - 4),
         .may_fail_on_cpu = true, .path = OPACITY_EXT_PATH("indexStride")),
    CASE("ext_indices_at_0", RULE(ext_opacity_index_address_is_given),
         EDITS(SET(micromaps.opacity_ext.indexBuffer, 0)), .path = OPACITY_EXT_PATH("indexBuffer")),
    CASE("ext_without_indices_has_some", RULE(ext_opacity_without_indices_has_no_index_address),
         PREPARE_EDITS(SET(micromaps.opacity_ext.indexType, VK_INDEX_TYPE_NONE_KHR)),
         TWIN_EDITS(SET(micromaps.opacity_ext.indexBuffer.deviceAddress, 0),
                    SET(micromaps.opacity_ext.indexStride, UINT64_MAX)),
         .path = OPACITY_EXT_PATH("indexBuffer")),

    SHARED(RULE(input_address_is_in_a_buffer), .commands = ON_COMMAND_BUFFERS, .setup = &with_khr,
           .prepare = scene_use_micromap, .path = OPACITY_PATH("indexBuffer")),
    CASE("micromap_indices_nowhere", EDITS(SET(micromaps.opacity.indexBuffer, 0x1000)),
         TWIN_EDITS(WITHOUT_INDICES)),
    /* In host builds, too, it is a device address. */
    CASE("micromap_indices_of_the_host_nowhere", .commands = ON_HOST,
         EDITS(SET(micromaps.opacity.indexBuffer, 0x1000)), .may_fail_on_cpu = true),
    CASE("micromap_indices_unbound", RULE(input_buffer_is_bound),
         .commands = ON_COMMAND_BUFFERS | ON_HOST,
         EDITS(MAKE_ADDRESS(micromaps.opacity.indexBuffer, scene_freed_address)),
         .may_fail_on_cpu = true),
    CASE("ext_indices_nowhere", .setup = &with_ext, .prepare = scene_use_micromap_ext,
         EDITS(SET(micromaps.opacity_ext.indexBuffer, 0x1000)),
         TWIN_EDITS(SET(micromaps.opacity_ext.indexType, VK_INDEX_TYPE_NONE_KHR),
                    SET(micromaps.opacity_ext.indexBuffer.deviceAddress, 0),
                    SET(micromaps.opacity_ext.indexStride, UINT64_MAX)),
         .path = OPACITY_EXT_PATH("indexBuffer")),
    CASE("ext_indices_unbound", RULE(input_buffer_is_bound), .setup = &with_ext,
         .prepare = scene_use_micromap_ext,
         EDITS(MAKE_ADDRESS(micromaps.opacity_ext.indexBuffer.deviceAddress, scene_freed_address)),
         .path = OPACITY_EXT_PATH("indexBuffer")),
};

CASE_LIST(cases_micromap_use, cases);
