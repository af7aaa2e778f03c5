/* SPDX-License-Identifier: Apache-2.0 */
/* Triangles that use displacement micromaps, of VK_NV_displacement_micromap. */
#include "case.h"

#define DISPLACEMENT_PATH(member)                                                                  \
    "pInfos[0].pGeometries[0].geometry.triangles."                                                 \
    "pNext<VkAccelerationStructureTrianglesDisplacementMicromapNV>." member

static const struct test_case cases[] = {
    SHARED(SETUP(.enable = ENABLE_DISPLACEMENT_MICROMAP), .prepare = scene_use_displacement),
    CASE("displacement_destroyed", RULE(displacement_micromap_is_valid),
         EDITS(DESTROY(micromaps.displacement.micromap)), .path = DISPLACEMENT_PATH("micromap")),
    CASE("displacement_bias_format_of_none", RULE(displacement_bias_and_scale_format_is_valid),
         EITHER_SET(micromaps.displacement.displacementBiasAndScaleFormat, 99999,
                    VK_FORMAT_R16G16_SFLOAT),
         .path = DISPLACEMENT_PATH("displacementBiasAndScaleFormat")),
    CASE("displacement_bias_format_undefined", RULE(displacement_bias_and_scale_format_is_defined),
         EDITS(SET(micromaps.displacement.displacementBiasAndScaleFormat, 0)),
         .path = DISPLACEMENT_PATH("displacementBiasAndScaleFormat")),
    CASE("displacement_vector_format_of_none", RULE(displacement_vector_format_is_valid),
         EITHER_SET(micromaps.displacement.displacementVectorFormat, 99999,
                    VK_FORMAT_R16G16B16_SFLOAT),
         .path = DISPLACEMENT_PATH("displacementVectorFormat")),
    CASE("displacement_vector_format_undefined", RULE(displacement_vector_format_is_defined),
         EDITS(SET(micromaps.displacement.displacementVectorFormat, 0)),
         .path = DISPLACEMENT_PATH("displacementVectorFormat")),
    CASE("displacement_index_type_of_none", RULE(displacement_index_type_is_valid),
         EITHER_SET(micromaps.displacement.indexType, 7, VK_INDEX_TYPE_UINT16),
         .path = DISPLACEMENT_PATH("indexType")),
    CASE("displacement_usages_both", RULE(displacement_has_one_usage_array),
         PREPARE_EDITS(SET(micromaps.displacement.pUsageCounts, 0),
                       POINT(micromaps.displacement.ppUsageCounts, micromaps.usage_pointers_ext)),
         EDITS(POINT(micromaps.displacement.pUsageCounts, micromaps.usages_ext)),
         .path = DISPLACEMENT_PATH("pUsageCounts")),
    CASE("displacement_usages_unreadable", RULE(displacement_usages_are_readable),
         PREPARE_EDITS(UNREADABLE(micromaps.displacement.pUsageCounts)),
         TWIN_EDITS(SET(micromaps.displacement.usageCountsCount, 0)),
         .path = DISPLACEMENT_PATH("pUsageCounts")),
    CASE("displacement_usage_pointers_unreadable", RULE(displacement_usage_pointers_are_readable),
         PREPARE_EDITS(SET(micromaps.displacement.pUsageCounts, 0),
                       POINT(micromaps.displacement.ppUsageCounts, micromaps.usage_pointers_ext)),
         EDITS(UNREADABLE(micromaps.displacement.ppUsageCounts)),
         .path = DISPLACEMENT_PATH("ppUsageCounts")),
};

CASE_LIST(cases_displacement, cases);
