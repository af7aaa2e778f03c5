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
static const struct setup with_limits = {.enable = ENABLE_OPACITY_MICROMAP_EXT,
                                         .configure = offer_limits};
static const struct setup with_khr = {.enable = ENABLE_OPACITY_MICROMAP_KHR};
static const struct setup with_displacement = {.enable = ENABLE_DISPLACEMENT_MICROMAP};

/* ---- VK_KHR_opacity_micromap ---- */

static void use_micromap_without_indices(struct scene *scene)
{
    scene_use_micromap(scene);
    scene->micromaps.opacity.indexType = VK_INDEX_TYPE_NONE_KHR;
    scene->micromaps.opacity.indexBuffer = 0;
    scene->micromaps.opacity.indexStride = 0;
}

static void leave_indices_of_khr_unbound(struct scene *scene)
{
    const struct test_buffer buffer = scene_buffer(scene, SCENE_BUFFER_SIZE, INPUT_USAGE);
    scene_use_micromap(scene);
    scene->micromaps.opacity.indexBuffer = buffer.address;
    scene_destroy(scene, (uint64_t)buffer.memory);
}

/* ---- VK_EXT_opacity_micromap ---- */

static void leave_indices_unbound(struct scene *scene)
{
    const struct test_buffer buffer = scene_buffer(scene, SCENE_BUFFER_SIZE, INPUT_USAGE);
    scene_use_micromap_ext(scene);
    scene->micromaps.opacity_ext.indexBuffer.deviceAddress = buffer.address;
    scene_destroy(scene, (uint64_t)buffer.memory);
}

static void use_pointers_ext(struct scene *scene)
{
    scene_use_micromap_ext(scene);
    scene->micromaps.opacity_ext.pUsageCounts = NULL;
    scene->micromaps.opacity_ext.ppUsageCounts = scene->micromaps.usage_pointers_ext;
}

static void use_null_ext(struct scene *scene)
{
    scene_use_micromap_ext(scene);
    scene->micromaps.opacity_ext.micromap = VK_NULL_HANDLE;
    scene->micromaps.usages_ext[0] =
        (VkMicromapUsageEXT){.count = 1, .subdivisionLevel = 100, .format = 100};
}

static void use_displacement_as_opacity(struct scene *scene)
{
    scene_use_micromap_ext(scene);
    scene->micromaps.opacity_ext.micromap =
        scene_micromap_ext(scene, VK_MICROMAP_TYPE_DISPLACEMENT_MICROMAP_NV);
    scene->micromaps.usages_ext[0].format =
        VK_DISPLACEMENT_MICROMAP_FORMAT_1024_TRIANGLES_128_BYTES_NV;
}

/* Their indices are in device memory, which the host may not be able to read. */
#define KHR_CASE(name_, rule, member, edits_, twin_edits_)                                         \
    {                                                                                              \
        .name = name_, RULES(rule), .setup = &with_khr, .mutate = scene_use_micromap,              \
        .edits = edits_, .mutate_twin = scene_use_micromap, .twin_edits = twin_edits_,             \
        .may_fail_on_cpu = true, .path = OPACITY_PATH(member)                                      \
    }
#define EXT_CASE(name_, rule, member, edits_, twin_edits_)                                         \
    EXT_CASE_WITH(with_ext, name_, rule, member, edits_, twin_edits_)
#define EXT_CASE_WITH(setup_, name_, rule, member, edits_, twin_edits_)                            \
    {                                                                                              \
        .name = name_, RULES(rule), .setup = &setup_, .mutate = scene_use_micromap_ext,            \
        .edits = edits_, .mutate_twin = scene_use_micromap_ext, .twin_edits = twin_edits_,         \
        .path = OPACITY_EXT_PATH(member)                                                           \
    }
static const struct test_case cases[] = {
    CASE("micromap_destroyed", RULES(RULE_opacity_micromap_is_valid),
         .commands = ON_COMMAND_BUFFERS, .setup = &with_khr, .prepare = scene_use_micromap,
         .edits = EDITS(MAKE_STRUCTURE_WITH(micromaps.opacity.micromap, scene_micromap_structure,
                                            VK_ACCELERATION_STRUCTURE_TYPE_OPACITY_MICROMAP_KHR),
                        DESTROY(micromaps.opacity.micromap)),
         .path = OPACITY_PATH("micromap")),
    CASE("micromap_destroyed_in_host_build",
         RULES(RULE_opacity_micromap_is_valid, RULE_host_build_uses_no_micromap),
         .commands = ON_HOST, .setup = &with_khr, .prepare = scene_use_micromap,
         .edits = EDITS(MAKE_STRUCTURE_WITH(micromaps.opacity.micromap, scene_micromap_structure,
                                            VK_ACCELERATION_STRUCTURE_TYPE_OPACITY_MICROMAP_KHR),
                        DESTROY(micromaps.opacity.micromap)),
         .may_fail_on_cpu = true),
    CASE("micromap_null_without_indices", RULES(RULE_opacity_without_indices_has_a_micromap),
         .commands = ON_COMMAND_BUFFERS, .setup = &with_khr,
         .prepare = use_micromap_without_indices,
         .edits = EDITS(SET(micromaps.opacity.micromap, 0)), .path = OPACITY_PATH("micromap")),
    CASE("micromap_null_without_indices_in_host_build",
         RULES(RULE_opacity_without_indices_has_a_micromap), .commands = ON_HOST,
         .setup = &with_khr, .mutate = use_micromap_without_indices,
         .mutate_twin = scene_use_micromap, .may_fail_on_cpu = true),
    CASE("micromap_null_with_indices", RULES(RULE_opacity_without_indices_has_a_micromap),
         .silent = true, .setup = &with_khr, .mutate = scene_use_micromap,
         .edits = EDITS(SET(micromaps.opacity.micromap, 0)), .may_fail_on_cpu = true),
    CASE("micromap_index_type_of_none",
         RULES(RULE_opacity_index_type_is_valid, RULE_opacity_index_type_is_8_to_32_bits_or_none),
         .setup = &with_khr, .prepare = scene_use_micromap,
         .edits = EDITS(SET(micromaps.opacity.indexType, 7)),
         .twin_edits = EDITS(SET(micromaps.opacity.indexType, VK_INDEX_TYPE_UINT8)),
         .may_fail_on_cpu = true, .path = OPACITY_PATH("indexType")),
    CASE("micromap_without_indices_has_some",
         RULES(RULE_opacity_without_indices_has_no_index_buffer), .commands = ON_COMMAND_BUFFERS,
         .setup = &with_khr, .mutate = scene_use_micromap,
         .edits = EDITS(SET(micromaps.opacity.indexType, VK_INDEX_TYPE_NONE_KHR)),
         .mutate_twin = use_micromap_without_indices, .path = OPACITY_PATH("indexBuffer")),
    /* Without indices the host, which takes no micromap, has nothing to go by. */
    CASE("micromap_without_indices_has_some_in_host_build",
         RULES(RULE_opacity_without_indices_has_no_index_buffer,
               RULE_opacity_without_indices_has_a_micromap),
         .commands = ON_HOST, .setup = &with_khr, .prepare = scene_use_micromap,
         .edits = EDITS(SET(micromaps.opacity.indexType, VK_INDEX_TYPE_NONE_KHR)),
         .may_fail_on_cpu = true),
    KHR_CASE("micromap_indices_at_0", RULE_opacity_index_buffer_is_given, "indexBuffer",
             EDITS(SET(micromaps.opacity.indexBuffer, 0)), NULL),
    KHR_CASE("micromap_index_stride_6", RULE_opacity_index_stride_is_aligned, "indexStride",
             EDITS(SET(micromaps.opacity.indexStride, 6)),
             EDITS(SET(micromaps.opacity.indexStride, 6),
                   SET(micromaps.opacity.indexType, VK_INDEX_TYPE_UINT16))),
    CASE("micromap_index_stride_beyond_32_bits",
         RULES(RULE_opacity_index_stride_fits_32_bits, RULE_opacity_indices_are_in_one_buffer),
         .commands = ON_DEVICE, .setup = &with_khr, .prepare = scene_use_micromap,
         .edits = EDITS(SET(micromaps.opacity.indexStride, 1ull << 32)), .path = NULL),
    CASE("micromap_index_stride_beyond_32_bits_alone",
         RULES(RULE_opacity_index_stride_fits_32_bits), .commands = ON_COMMAND_BUFFERS | ON_HOST,
         .setup = &with_khr, .prepare = scene_use_micromap,
         .edits = EDITS(SET(micromaps.opacity.indexStride, 1ull << 32),
                        SET(ranges[INDEXED][0].primitiveCount, 0)),
         .twin_edits = EDITS(SET(micromaps.opacity.indexStride, (1ull << 32) - 4),
                             SET(ranges[INDEXED][0].primitiveCount, 0)),
         .may_fail_on_cpu = true, .path = OPACITY_PATH("indexStride")),
    KHR_CASE("micromap_indices_beyond_the_buffer", RULE_opacity_indices_are_in_one_buffer,
             "indexBuffer", EDITS(SET(micromaps.opacity.indexStride, SCENE_BUFFER_SIZE / 2 + 4)),
             EDITS(SET(micromaps.opacity.indexStride, SCENE_BUFFER_SIZE / 2))),
    CASE("micromap_in_host_build", RULES(RULE_host_build_uses_no_micromap), .setup = &with_khr,
         .prepare = scene_use_micromap,
         .edits = EDITS(MAKE_STRUCTURE_WITH(micromaps.opacity.micromap, scene_micromap_structure,
                                            VK_ACCELERATION_STRUCTURE_TYPE_OPACITY_MICROMAP_KHR)),
         .may_fail_on_cpu = true, .path = OPACITY_PATH("micromap")),

    CASE("ext_micromap_destroyed", RULES(RULE_ext_opacity_micromap_is_valid), .setup = &with_ext,
         .prepare = scene_use_micromap_ext, .edits = EDITS(DESTROY(micromaps.opacity_ext.micromap)),
         .path = OPACITY_EXT_PATH("micromap")),
    EXT_CASE("ext_micromap_forged", RULE_ext_opacity_micromap_is_valid, "micromap",
             EDITS(SET(micromaps.opacity_ext.micromap, 0x1234)),
             EDITS(SET(micromaps.opacity_ext.micromap, 0))),
    CASE("ext_usages_both", RULES(RULE_ext_opacity_has_one_usage_array), .setup = &with_ext,
         .prepare = use_pointers_ext,
         .edits = EDITS(POINT(micromaps.opacity_ext.pUsageCounts, micromaps.usages_ext)),
         .path = OPACITY_EXT_PATH("pUsageCounts")),
    CASE("ext_usages_unreadable", RULES(RULE_ext_opacity_usages_are_readable), .setup = &with_ext,
         .prepare = scene_use_micromap_ext,
         .edits = EDITS(UNREADABLE(micromaps.opacity_ext.pUsageCounts)),
         .twin_edits = EDITS(UNREADABLE(micromaps.opacity_ext.pUsageCounts),
                             SET(micromaps.opacity_ext.usageCountsCount, 0)),
         .path = OPACITY_EXT_PATH("pUsageCounts")),
    CASE("ext_usage_behind_pointer_unreadable", RULES(RULE_ext_opacity_usage_pointers_are_readable),
         .setup = &with_ext, .prepare = use_pointers_ext,
         .edits = EDITS(UNREADABLE(micromaps.usage_pointers_ext[0])),
         .path = OPACITY_EXT_PATH("ppUsageCounts")),
    EXT_CASE("ext_usage_format_3", RULE_ext_opacity_usage_format_is_an_opacity_format,
             "pUsageCounts", EDITS(SET(micromaps.usages_ext[0].format, 3)),
             EDITS(SET(micromaps.usages_ext[0].format, 2))),
    EXT_CASE_WITH(with_limits, "ext_usage_of_2_states_too_fine",
                  RULE_ext_opacity_2_state_level_is_within_limit, "pUsageCounts",
                  EDITS(SET(micromaps.usages_ext[0].subdivisionLevel, LIMIT_2_STATE + 1)),
                  EDITS(SET(micromaps.usages_ext[0].subdivisionLevel, LIMIT_2_STATE))),
    EXT_CASE_WITH(
        with_limits, "ext_usage_of_4_states_too_fine",
        RULE_ext_opacity_4_state_level_is_within_limit, "pUsageCounts",
        EDITS(SET(micromaps.usages_ext[0].subdivisionLevel, LIMIT_4_STATE + 1),
              SET(micromaps.usages_ext[0].format, VK_OPACITY_MICROMAP_FORMAT_4_STATE_EXT)),
        EDITS(SET(micromaps.usages_ext[0].subdivisionLevel, LIMIT_4_STATE),
              SET(micromaps.usages_ext[0].format, VK_OPACITY_MICROMAP_FORMAT_4_STATE_EXT))),
    /* No device has as many, backend cpu included. */
    EXT_CASE("ext_usage_of_2_states_finer_than_any", RULE_ext_opacity_2_state_level_is_within_limit,
             "pUsageCounts", EDITS(SET(micromaps.usages_ext[0].subdivisionLevel, LEVEL_OF_NONE)),
             EDITS(SET(micromaps.usages_ext[0].subdivisionLevel, LIMIT_2_STATE))),
    EXT_CASE("ext_usage_of_4_states_finer_than_any", RULE_ext_opacity_4_state_level_is_within_limit,
             "pUsageCounts",
             EDITS(SET(micromaps.usages_ext[0].subdivisionLevel, LEVEL_OF_NONE),
                   SET(micromaps.usages_ext[0].format, VK_OPACITY_MICROMAP_FORMAT_4_STATE_EXT)),
             EDITS(SET(micromaps.usages_ext[0].subdivisionLevel, LIMIT_4_STATE),
                   SET(micromaps.usages_ext[0].format, VK_OPACITY_MICROMAP_FORMAT_4_STATE_EXT))),
    CASE("ext_usages_without_a_micromap",
         RULES(RULE_ext_opacity_usage_format_is_an_opacity_format,
               RULE_ext_opacity_2_state_level_is_within_limit,
               RULE_ext_opacity_usage_format_is_a_displacement_format,
               RULE_ext_opacity_displacement_level_is_within_limit),
         .silent = true, .setup = &with_displacement, .mutate = use_null_ext),
    CASE("displacement_usage_format_4",
         RULES(RULE_ext_opacity_usage_format_is_a_displacement_format), .setup = &with_displacement,
         .prepare = use_displacement_as_opacity,
         .edits = EDITS(SET(micromaps.usages_ext[0].format, 4)),
         .path = OPACITY_EXT_PATH("pUsageCounts")),
    CASE("displacement_usage_too_fine", RULES(RULE_ext_opacity_displacement_level_is_within_limit),
         .setup = &with_displacement, .prepare = use_displacement_as_opacity,
         .edits = EDITS(SET(micromaps.usages_ext[0].subdivisionLevel, LIMIT_DISPLACEMENT + 1)),
         .twin_edits = EDITS(SET(micromaps.usages_ext[0].subdivisionLevel, LIMIT_DISPLACEMENT)),
         .path = OPACITY_EXT_PATH("pUsageCounts")),
    EXT_CASE("ext_index_type_of_none", RULE_ext_opacity_index_type_is_valid, "indexType",
             EDITS(SET(micromaps.opacity_ext.indexType, 7)),
             EDITS(SET(micromaps.opacity_ext.indexType, VK_INDEX_TYPE_UINT16))),
    EXT_CASE("ext_index_type_of_8_bits", RULE_ext_opacity_index_type_is_16_or_32_bits_or_none,
             "indexType", EDITS(SET(micromaps.opacity_ext.indexType, VK_INDEX_TYPE_UINT8)), NULL),
    EXT_CASE("ext_index_stride_6", RULE_ext_opacity_index_stride_is_aligned, "indexStride",
             EDITS(SET(micromaps.opacity_ext.indexStride, 6)),
             EDITS(SET(micromaps.opacity_ext.indexStride, 6),
                   SET(micromaps.opacity_ext.indexType, VK_INDEX_TYPE_UINT16))),
    CASE("ext_index_stride_beyond_32_bits", RULES(RULE_ext_opacity_index_stride_fits_32_bits),
         .setup = &with_ext, .prepare = scene_use_micromap_ext,
         .edits = EDITS(SET(micromaps.opacity_ext.indexStride, 1ull << 32)),
         .twin_edits = EDITS(SET(micromaps.opacity_ext.indexStride, (1ull << 32) - 4)),
         .may_fail_on_cpu = true, .path = OPACITY_EXT_PATH("indexStride")),
    EXT_CASE("ext_indices_at_0", RULE_ext_opacity_index_address_is_given, "indexBuffer",
             EDITS(SET(micromaps.opacity_ext.indexBuffer, 0)), NULL),
    CASE("ext_without_indices_has_some",
         RULES(RULE_ext_opacity_without_indices_has_no_index_address), .setup = &with_ext,
         .prepare = scene_use_micromap_ext,
         .edits = EDITS(SET(micromaps.opacity_ext.indexType, VK_INDEX_TYPE_NONE_KHR)),
         .twin_edits = EDITS(SET(micromaps.opacity_ext.indexType, VK_INDEX_TYPE_NONE_KHR),
                             SET(micromaps.opacity_ext.indexBuffer.deviceAddress, 0),
                             SET(micromaps.opacity_ext.indexStride, UINT64_MAX)),
         .path = OPACITY_EXT_PATH("indexBuffer")),

    CASE("micromap_indices_nowhere", RULES(RULE_input_address_is_in_a_buffer),
         .commands = ON_COMMAND_BUFFERS, .setup = &with_khr, .mutate = scene_use_micromap,
         .edits = EDITS(SET(micromaps.opacity.indexBuffer, 0x1000)),
         .mutate_twin = use_micromap_without_indices, .path = OPACITY_PATH("indexBuffer")),
    /* In host builds, too, it is a device address. */
    CASE("micromap_indices_of_the_host_nowhere", RULES(RULE_input_address_is_in_a_buffer),
         .commands = ON_HOST, .setup = &with_khr, .prepare = scene_use_micromap,
         .edits = EDITS(SET(micromaps.opacity.indexBuffer, 0x1000)), .may_fail_on_cpu = true,
         .path = OPACITY_PATH("indexBuffer")),
    CASE("micromap_indices_unbound", RULES(RULE_input_buffer_is_bound),
         .commands = ON_COMMAND_BUFFERS | ON_HOST, .setup = &with_khr,
         .mutate = leave_indices_of_khr_unbound, .mutate_twin = scene_use_micromap,
         .may_fail_on_cpu = true, .path = OPACITY_PATH("indexBuffer")),
    CASE("ext_indices_nowhere", RULES(RULE_input_address_is_in_a_buffer),
         .commands = ON_COMMAND_BUFFERS, .setup = &with_ext, .prepare = scene_use_micromap_ext,
         .edits = EDITS(SET(micromaps.opacity_ext.indexBuffer, 0x1000)),
         .twin_edits = EDITS(SET(micromaps.opacity_ext.indexType, VK_INDEX_TYPE_NONE_KHR),
                             SET(micromaps.opacity_ext.indexBuffer.deviceAddress, 0),
                             SET(micromaps.opacity_ext.indexStride, UINT64_MAX)),
         .path = OPACITY_EXT_PATH("indexBuffer")),
    CASE("ext_indices_unbound", RULES(RULE_input_buffer_is_bound), .commands = ON_COMMAND_BUFFERS,
         .setup = &with_ext, .mutate = leave_indices_unbound, .mutate_twin = scene_use_micromap_ext,
         .path = OPACITY_EXT_PATH("indexBuffer")),
};

CASE_LIST(cases_micromap_use, cases);
