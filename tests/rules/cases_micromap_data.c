/* SPDX-License-Identifier: Apache-2.0 */
/* What a micromap of VK_KHR_opacity_micromap is built from. */
#include "case.h"

#define DATA_PATH(member)                                                                          \
    "pInfos[2].pGeometries[0].pNext<VkAccelerationStructureGeometryMicromapDataKHR>." member

enum {
    LOSSY = VK_BUILD_ACCELERATION_STRUCTURE_MICROMAP_LOSSY_BIT_KHR,
    STATES_4 = VK_OPACITY_MICROMAP_FORMAT_4_STATE_KHR,
    /* As the null driver has them. */
    LIMIT_2_STATE = 6,
    LIMIT_4_STATE = 5,
    LIMIT_LOSSY = 4,
    LIMIT_TRIANGLES = 4096,
    LEVEL_OF_NONE = 13,
};

static void offer_limits(struct null_driver_config *config)
{
    config->micromap_properties_khr.maxOpacity2StateSubdivisionLevel = LIMIT_2_STATE;
    config->micromap_properties_khr.maxOpacity4StateSubdivisionLevel = LIMIT_4_STATE;
    config->micromap_properties_khr.maxOpacityLossy4StateSubdivisionLevel = LIMIT_LOSSY;
    config->micromap_properties_khr.maxMicromapTriangles = LIMIT_TRIANGLES;
}

static const struct setup with_khr = {.enable = ENABLE_OPACITY_MICROMAP_KHR};

/* ---- usages ---- */

static void build_4_state_micromap(struct scene *scene)
{
    scene_build_micromap(scene);
    for (uint32_t i = 0; i < SCENE_USAGES; i++)
        scene->micromaps.triangles[i].format = STATES_4;
}

/* Two of them are there. */
static void cut_usages(struct scene *scene)
{
    VkMicromapUsageKHR *usages = bytes_before_unreadable_page(2 * sizeof(*usages));
    scene_build_micromap(scene);
    usages[0] = usages[1] = scene->micromaps.usages[0];
    scene->micromaps.data.pUsageCounts = usages;
}

static void lose_the_structure(struct scene *scene)
{
    VkBaseInStructure *header = bytes_before_unreadable_page(sizeof(*header));
    scene_build_micromap(scene);
    header->sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_MICROMAP_DATA_KHR;
    scene->geometries[AABBS][0].pNext = header;
}

#define USAGE_POINTERS                                                                             \
    SET(micromaps.data.pUsageCounts, 0),                                                           \
        POINT(micromaps.data.ppUsageCounts, micromaps.usage_pointers)
/* The last 128 bytes of the buffer, for 16 triangles of 8 bytes. */
#define END_OF_BUFFER                                                                              \
    ADD(micromaps.data.triangleArray, SCENE_MICROMAP_INPUT_SIZE - 128), TWO_USAGES,                \
        SET(micromaps.usages[0].count, 8), SET(micromaps.usages[1].count, 8)
#define TWO_USAGES SET(micromaps.data.usageCountsCount, 2)

static const struct test_case cases[] = {
    SHARED(RULE(micromap_data_usages_are_readable), .commands = ON_WITH_RANGES,
           .refusal = &indirect_takes_no_micromap, .setup = &with_khr, .may_fail_on_cpu = true),
    CASE("usages_both", RULE(micromap_data_has_one_usage_array), .prepare = scene_build_micromap,
         PREPARE_EDITS(USAGE_POINTERS), EDITS(POINT(micromaps.data.pUsageCounts, micromaps.usages)),
         .path = DATA_PATH("pUsageCounts")),
    CASE("usages_unreadable", .prepare = scene_build_micromap,
         PREPARE_EDITS(UNREADABLE(micromaps.data.pUsageCounts)),
         TWIN_EDITS(SET(micromaps.data.usageCountsCount, 0)), .path = DATA_PATH("pUsageCounts")),
    CASE("usages_end_too_early", .prepare = cut_usages,
         EDITS(SET(micromaps.data.usageCountsCount, 3)), TWIN_EDITS(TWO_USAGES)),
    CASE("usages_too_many", .mutate = cut_usages,
         EDITS(SET(micromaps.data.usageCountsCount, UINT32_MAX))),
    CASE("usage_pointers_unreadable", RULE(micromap_data_usage_pointers_are_readable),
         .prepare = scene_build_micromap, PREPARE_EDITS(USAGE_POINTERS),
         EDITS(UNREADABLE(micromaps.data.ppUsageCounts)), .path = DATA_PATH("ppUsageCounts")),

    SHARED(RULE(micromap_data_usage_format_is_valid), .commands = ON_WITH_RANGES,
           .refusal = &indirect_takes_no_micromap, .setup = &with_khr, .may_fail_on_cpu = true),
    CASE("usage_behind_pointer_unreadable", RULE(micromap_data_usage_pointers_are_readable),
         .prepare = scene_build_micromap,
         PREPARE_EDITS(USAGE_POINTERS, UNREADABLE(micromaps.usage_pointers[1])), EDITS(TWO_USAGES)),
    CASE("micromap_data_ends_too_early", RULE(geometry_chain_is_known),
         .mutate = lose_the_structure, .mutate_twin = scene_build_micromap,
         .path = "pInfos[2].pGeometries[0].pNext"),
    CASE("usage_format_0", .prepare = scene_build_micromap,
         EDITS(TWO_USAGES, SET(micromaps.usages[1].format, 0)),
         TWIN_EDITS(SET(micromaps.usages[1].format, 0)), .path = DATA_PATH("pUsageCounts")),
    CASE("usage_format_3", .prepare = scene_build_micromap,
         EITHER_SET(micromaps.usages[0].format, 3, STATES_4), .path = DATA_PATH("pUsageCounts")),
    CASE("usage_format_behind_pointer", .prepare = scene_build_micromap,
         PREPARE_EDITS(USAGE_POINTERS), EDITS(TWO_USAGES, SET(micromaps.usages[1].format, 7)),
         .path = DATA_PATH("ppUsageCounts")),

    SHARED(.commands = ON_WITH_RANGES, .refusal = &indirect_takes_no_micromap,
           SETUP(.enable = ENABLE_OPACITY_MICROMAP_KHR, .configure = offer_limits),
           .prepare = scene_build_micromap, .may_fail_on_cpu = true,
           .path = DATA_PATH("pUsageCounts")),
    CASE("lossy_usage_of_2_states", RULE(lossy_usage_is_4_state), .setup = &with_khr,
         .prepare = build_4_state_micromap,
         PREPARE_EDITS(TWO_USAGES, SET(infos[AABBS].flags, LOSSY),
                       SET(micromaps.usages[0].format, STATES_4)),
         TWIN_EDITS(SET(micromaps.usages[1].format, STATES_4))),
    CASE("usage_of_2_states_too_fine", RULE(usage_2_state_level_is_within_limit),
         EITHER_SET(micromaps.usages[0].subdivisionLevel, LIMIT_2_STATE + 1, LIMIT_2_STATE)),
    CASE("usage_of_4_states_too_fine", RULE(usage_4_state_level_is_within_limit),
         EDITS(SET(micromaps.usages[0].subdivisionLevel, LIMIT_4_STATE + 1),
               SET(micromaps.usages[0].format, STATES_4)),
         TWIN_EDITS(SET(micromaps.usages[0].subdivisionLevel, LIMIT_4_STATE),
                    SET(micromaps.usages[0].format, STATES_4))),
    CASE("lossy_usage_too_fine", RULE(lossy_usage_level_is_within_limit),
         .prepare = build_4_state_micromap,
         EDITS(SET(micromaps.usages[0].subdivisionLevel, LIMIT_LOSSY + 1),
               SET(micromaps.usages[0].format, STATES_4), SET(infos[AABBS].flags, LOSSY)),
         TWIN_EDITS(SET(micromaps.usages[0].subdivisionLevel, LIMIT_LOSSY),
                    SET(micromaps.usages[0].format, STATES_4), SET(infos[AABBS].flags, LOSSY))),
    CASE("too_many_triangles", RULE(micromap_triangle_count_is_within_limit),
         EDITS(TWO_USAGES, SET(micromaps.usages[1].count, LIMIT_TRIANGLES)),
         TWIN_EDITS(TWO_USAGES, SET(micromaps.usages[1].count, LIMIT_TRIANGLES - 1))),

    SHARED(.setup = &with_khr, .prepare = scene_build_micromap,
           EDITS(SET(micromaps.usages[0].count, UINT32_MAX))),
    /* No device has as many, backend cpu included. */
    CASE("more_triangles_than_any_takes",
         RULES(RULE_micromap_triangle_count_is_within_limit,
               RULE_micromap_triangles_are_in_one_buffer),
         .commands = ON_DEVICE),
    CASE("more_triangles_than_any_takes", RULE(micromap_triangle_count_is_within_limit),
         .commands = ON_HOST, .refusal = &indirect_takes_no_micromap, .may_fail_on_cpu = true),

    SHARED(.commands = ON_WITH_RANGES, .refusal = &indirect_takes_no_micromap, .setup = &with_khr,
           .prepare = scene_build_micromap, .may_fail_on_cpu = true,
           .path = DATA_PATH("pUsageCounts")),
    CASE("usage_of_2_states_finer_than_any", RULE(usage_2_state_level_is_within_limit),
         EITHER_SET(micromaps.usages[0].subdivisionLevel, LEVEL_OF_NONE, LIMIT_2_STATE)),
    CASE("usage_of_4_states_finer_than_any", RULE(usage_4_state_level_is_within_limit),
         EDITS(SET(micromaps.usages[0].subdivisionLevel, LEVEL_OF_NONE),
               SET(micromaps.usages[0].format, STATES_4)),
         TWIN_EDITS(SET(micromaps.usages[0].subdivisionLevel, LIMIT_4_STATE),
                    SET(micromaps.usages[0].format, STATES_4))),
    CASE("lossy_usage_finer_than_any", RULE(lossy_usage_level_is_within_limit),
         .prepare = build_4_state_micromap,
         EDITS(SET(micromaps.usages[0].subdivisionLevel, LEVEL_OF_NONE),
               SET(micromaps.usages[0].format, STATES_4), SET(infos[AABBS].flags, LOSSY)),
         TWIN_EDITS(SET(micromaps.usages[0].subdivisionLevel, LIMIT_LOSSY),
                    SET(micromaps.usages[0].format, STATES_4), SET(infos[AABBS].flags, LOSSY))),
    CASE("triangle_stride_4", RULE(micromap_triangle_stride_holds_a_triangle),
         EITHER_SET(micromaps.data.triangleArrayStride, 4, 8),
         .path = DATA_PATH("triangleArrayStride")),
    CASE("triangle_stride_10", RULE(micromap_triangle_stride_is_aligned),
         EITHER_SET(micromaps.data.triangleArrayStride, 10, 12),
         .path = DATA_PATH("triangleArrayStride")),

    SHARED(.setup = &with_khr, .prepare = scene_build_micromap),
    CASE("triangles_at_0", RULE(micromap_addresses_are_given),
         EDITS(SET(micromaps.data.triangleArray, 0)), .path = DATA_PATH("triangleArray")),
    CASE("micromap_data_at_0", RULE(micromap_addresses_are_given),
         EDITS(SET(micromaps.data.data, 0)), .path = DATA_PATH("data")),
    CASE("triangles_at_0_with_usages", RULE(micromap_addresses_are_given),
         PREPARE_EDITS(SET(micromaps.data.triangleArray, 0), SET(micromaps.data.data, 0)),
         TWIN_EDITS(SET(micromaps.usages[0].count, 0)),
         .path = DATA_PATH("data and triangleArray are 0.")),
    CASE("triangles_nowhere_with_usages", RULE(input_address_is_in_a_buffer), .commands = ON_DEVICE,
         PREPARE_EDITS(SET(micromaps.data.triangleArray, 0x1000)),
         TWIN_EDITS(SET(micromaps.data.usageCountsCount, 0), SET(micromaps.data.pUsageCounts, 0))),
    CASE("triangles_without_usage_flag_with_usages", RULE(micromap_buffers_have_build_input_usage),
         PREPARE_EDITS(MAKE_ADDRESS(micromaps.data.triangleArray, scene_address_without_usage)),
         TWIN_EDITS(SET(micromaps.usages[0].count, 0))),
    CASE("triangles_unaligned", RULE(micromap_addresses_are_aligned),
         EITHER_ADD(micromaps.data.triangleArray, 64, 128), .path = DATA_PATH("triangleArray")),
    CASE("micromap_data_unaligned", RULE(micromap_addresses_are_aligned),
         EITHER_ADD(micromaps.data.data, 4, 128), .path = DATA_PATH("data")),
    CASE("triangles_and_data_unaligned", RULE(micromap_addresses_are_aligned),
         EDITS(ADD(micromaps.data.data, 4), ADD(micromaps.data.triangleArray, 64)),
         TWIN_EDITS(ADD(micromaps.data.data, 128), ADD(micromaps.data.triangleArray, 128)),
         .path = " and triangleArray 0x"),
    CASE("triangles_nowhere", RULE(input_address_is_in_a_buffer), .commands = ON_DEVICE,
         EDITS(SET(micromaps.data.triangleArray, 0x1000)), .path = DATA_PATH("triangleArray")),
    CASE("micromap_data_without_usage", RULE(micromap_buffers_have_build_input_usage),
         EDITS(MAKE_ADDRESS(micromaps.data.data, scene_address_without_usage)),
         .path = DATA_PATH("data")),
    CASE("triangles_without_usage", RULE(micromap_buffers_have_build_input_usage),
         EDITS(MAKE_ADDRESS(micromaps.data.triangleArray, scene_address_without_usage)),
         .path = DATA_PATH("triangleArray")),
    CASE("triangles_beyond_the_buffer", RULE(micromap_triangles_are_in_one_buffer),
         PREPARE_EDITS(END_OF_BUFFER), EDITS(ADD(micromaps.usages[1].count, 1)),
         .path = DATA_PATH("triangleArray")),
    CASE("triangles_far_beyond_the_buffer", RULE(micromap_triangles_are_in_one_buffer),
         PREPARE_EDITS(END_OF_BUFFER),
         EDITS(SET(micromaps.data.triangleArrayStride, UINT64_MAX / 16 * 4 + 4))),
};

CASE_LIST(cases_micromap_data, cases);
