/* SPDX-License-Identifier: Apache-2.0 */
/* Triangles that use displacement micromaps, of VK_NV_displacement_micromap. */
#include "case.h"

#define DISPLACEMENT_PATH(member)                                                                  \
    "pInfos[0].pGeometries[0].geometry.triangles."                                                 \
    "pNext<VkAccelerationStructureTrianglesDisplacementMicromapNV>." member

static const struct setup with_displacement = {.enable = ENABLE_DISPLACEMENT_MICROMAP};

static void use_pointers_of_displacement(struct scene *scene)
{
    scene_use_displacement(scene);
    scene->micromaps.displacement.pUsageCounts = NULL;
    scene->micromaps.displacement.ppUsageCounts = scene->micromaps.usage_pointers_ext;
}

#define DISPLACEMENT_CASE(name_, rule, member, edits_, twin_edits_)                                \
    {                                                                                              \
        .name = name_, RULES(rule), .setup = &with_displacement, .mutate = scene_use_displacement, \
        .edits = edits_, .mutate_twin = scene_use_displacement, .twin_edits = twin_edits_,         \
        .path = DISPLACEMENT_PATH(member)                                                          \
    }

static const struct test_case cases[] = {
    CASE("displacement_destroyed", RULES(RULE_displacement_micromap_is_valid),
         .setup = &with_displacement, .prepare = scene_use_displacement,
         .edits = EDITS(DESTROY(micromaps.displacement.micromap)),
         .path = DISPLACEMENT_PATH("micromap")),
    DISPLACEMENT_CASE(
        "displacement_bias_format_of_none", RULE_displacement_bias_and_scale_format_is_valid,
        "displacementBiasAndScaleFormat",
        EDITS(SET(micromaps.displacement.displacementBiasAndScaleFormat, 99999)),
        EDITS(SET(micromaps.displacement.displacementBiasAndScaleFormat, VK_FORMAT_R16G16_SFLOAT))),
    DISPLACEMENT_CASE("displacement_bias_format_undefined",
                      RULE_displacement_bias_and_scale_format_is_defined,
                      "displacementBiasAndScaleFormat",
                      EDITS(SET(micromaps.displacement.displacementBiasAndScaleFormat, 0)), NULL),
    DISPLACEMENT_CASE(
        "displacement_vector_format_of_none", RULE_displacement_vector_format_is_valid,
        "displacementVectorFormat",
        EDITS(SET(micromaps.displacement.displacementVectorFormat, 99999)),
        EDITS(SET(micromaps.displacement.displacementVectorFormat, VK_FORMAT_R16G16B16_SFLOAT))),
    DISPLACEMENT_CASE("displacement_vector_format_undefined",
                      RULE_displacement_vector_format_is_defined, "displacementVectorFormat",
                      EDITS(SET(micromaps.displacement.displacementVectorFormat, 0)), NULL),
    DISPLACEMENT_CASE("displacement_index_type_of_none", RULE_displacement_index_type_is_valid,
                      "indexType", EDITS(SET(micromaps.displacement.indexType, 7)),
                      EDITS(SET(micromaps.displacement.indexType, VK_INDEX_TYPE_UINT16))),
    CASE("displacement_usages_both", RULES(RULE_displacement_has_one_usage_array),
         .setup = &with_displacement, .prepare = use_pointers_of_displacement,
         .edits = EDITS(POINT(micromaps.displacement.pUsageCounts, micromaps.usages_ext)),
         .path = DISPLACEMENT_PATH("pUsageCounts")),
    CASE("displacement_usages_unreadable", RULES(RULE_displacement_usages_are_readable),
         .setup = &with_displacement, .prepare = scene_use_displacement,
         .edits = EDITS(UNREADABLE(micromaps.displacement.pUsageCounts)),
         .twin_edits = EDITS(UNREADABLE(micromaps.displacement.pUsageCounts),
                             SET(micromaps.displacement.usageCountsCount, 0)),
         .path = DISPLACEMENT_PATH("pUsageCounts")),
    CASE("displacement_usage_pointers_unreadable",
         RULES(RULE_displacement_usage_pointers_are_readable), .setup = &with_displacement,
         .prepare = use_pointers_of_displacement,
         .edits = EDITS(UNREADABLE(micromaps.displacement.ppUsageCounts)),
         .path = DISPLACEMENT_PATH("ppUsageCounts")),
};

CASE_LIST(cases_displacement, cases);
