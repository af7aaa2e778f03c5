/* SPDX-License-Identifier: Apache-2.0 */
/* Rules about triangles with an opacity micromap of VK_EXT_opacity_micromap. */
#include "src/rules/micromap/shared.h"
#include "src/rules/predicates.h"
#include "src/rules/shared.h"

static const struct micromap_support *support_of(const struct opacity_ext_view *opacity)
{
    return &opacity->geometry->build->call->device->micromap;
}

bool ext_opacity_micromap_is_valid(const struct opacity_ext_view *opacity_ext,
                                   struct finding *finding)
{
    return opacity_ext->micromap.alive != NO || opacity_ext->micromap.of_another_device ||
           violated_by_handle(
               finding, OPACITY_EXT_DATA "micromap",
               object(VK_OBJECT_TYPE_MICROMAP_EXT, handle_number(opacity_ext->micromap.handle)),
               "a micromap of this device");
}

/* ---- usages */

bool ext_opacity_has_one_usage_array(const struct opacity_ext_view *opacity_ext,
                                     struct finding *finding)
{
    return usages_are_given_once(&opacity_ext->usages, finding);
}

bool ext_opacity_usages_are_readable(const struct opacity_ext_view *opacity_ext,
                                     struct finding *finding)
{
    return usage_array_is_readable(&opacity_ext->usages, finding);
}

bool ext_opacity_usage_pointers_are_readable(const struct opacity_ext_view *opacity_ext,
                                             struct finding *finding)
{
    return usage_pointers_are_readable(&opacity_ext->usages, finding);
}

static bool is_of_type(const struct opacity_ext_view *opacity, VkMicromapTypeEXT type)
{
    return opacity->micromap.alive == YES && opacity->micromap.type == type;
}

bool ext_opacity_usage_format_is_an_opacity_format(const struct opacity_ext_view *opacity_ext,
                                                   struct finding *finding)
{
    return !is_of_type(opacity_ext, VK_MICROMAP_TYPE_OPACITY_MICROMAP_EXT) ||
           opacity_ext->geometry->build->call->device->newer_than_registry ||
           usage_formats_are_valid(&opacity_ext->usages, VK_OPACITY_MICROMAP_FORMAT_4_STATE_EXT,
                                   "VkOpacityMicromapFormatEXT", finding);
}

bool ext_opacity_2_state_level_is_within_limit(const struct opacity_ext_view *opacity_ext,
                                               struct finding *finding)
{
    return !is_of_type(opacity_ext, VK_MICROMAP_TYPE_OPACITY_MICROMAP_EXT) ||
           usage_levels_are_within(&opacity_ext->usages, VK_OPACITY_MICROMAP_FORMAT_2_STATE_EXT,
                                   support_of(opacity_ext)->ext_limits.opacity_2_state_level,
                                   "maxOpacity2StateSubdivisionLevel", finding);
}

bool ext_opacity_4_state_level_is_within_limit(const struct opacity_ext_view *opacity_ext,
                                               struct finding *finding)
{
    return !is_of_type(opacity_ext, VK_MICROMAP_TYPE_OPACITY_MICROMAP_EXT) ||
           usage_levels_are_within(&opacity_ext->usages, VK_OPACITY_MICROMAP_FORMAT_4_STATE_EXT,
                                   support_of(opacity_ext)->ext_limits.opacity_4_state_level,
                                   "maxOpacity4StateSubdivisionLevel", finding);
}

bool ext_opacity_usage_format_is_a_displacement_format(const struct opacity_ext_view *opacity_ext,
                                                       struct finding *finding)
{
    return !is_of_type(opacity_ext, VK_MICROMAP_TYPE_DISPLACEMENT_MICROMAP_NV) ||
           opacity_ext->geometry->build->call->device->newer_than_registry ||
           usage_formats_are_valid(&opacity_ext->usages,
                                   VK_DISPLACEMENT_MICROMAP_FORMAT_1024_TRIANGLES_128_BYTES_NV,
                                   "VkDisplacementMicromapFormatNV", finding);
}

bool ext_opacity_displacement_level_is_within_limit(const struct opacity_ext_view *opacity_ext,
                                                    struct finding *finding)
{
    return !is_of_type(opacity_ext, VK_MICROMAP_TYPE_DISPLACEMENT_MICROMAP_NV) ||
           usage_levels_are_within(&opacity_ext->usages, ANY_FORMAT,
                                   support_of(opacity_ext)->displacement_level,
                                   "maxDisplacementMicromapSubdivisionLevel", finding);
}

/* ---- indices */

bool ext_opacity_index_type_is_valid(const struct opacity_ext_view *opacity_ext,
                                     struct finding *finding)
{
    return micromap_index_type_is_valid(finding, OPACITY_EXT_DATA "indexType",
                                        opacity_ext->geometry, opacity_ext->opacity->indexType);
}

bool ext_opacity_index_type_is_16_or_32_bits_or_none(const struct opacity_ext_view *opacity_ext,
                                                     struct finding *finding)
{
    return opacity_ext->opacity->indexType != VK_INDEX_TYPE_UINT8 ||
           violated_plainly(
               finding, OPACITY_EXT_DATA "indexType",
               "is VK_INDEX_TYPE_UINT8, which VK_EXT_opacity_micromap does not accept");
}

bool ext_opacity_index_stride_is_aligned(const struct opacity_ext_view *opacity_ext,
                                         struct finding *finding)
{
    return micromap_index_stride_is_aligned(finding, OPACITY_EXT_DATA "indexStride",
                                            opacity_ext->opacity->indexType,
                                            opacity_ext->opacity->indexStride);
}

bool ext_opacity_index_stride_fits_32_bits(const struct opacity_ext_view *opacity_ext,
                                           struct finding *finding)
{
    return micromap_index_stride_fits_32_bits(finding, OPACITY_EXT_DATA "indexStride",
                                              opacity_ext->opacity->indexType,
                                              opacity_ext->opacity->indexStride);
}

static const char *index_field(const struct opacity_ext_view *opacity)
{
    return opacity->geometry->build->call->command == COMMAND_HOST
               ? OPACITY_EXT_DATA "indexBuffer.hostAddress"
               : OPACITY_EXT_DATA "indexBuffer.deviceAddress";
}

bool ext_opacity_index_address_is_given(const struct opacity_ext_view *opacity_ext,
                                        struct finding *finding)
{
    return micromap_indices_are_given(finding, index_field(opacity_ext), opacity_ext->geometry,
                                      opacity_ext->opacity->indexType,
                                      opacity_ext->opacity->indexBuffer.deviceAddress);
}

bool ext_opacity_without_indices_has_no_index_address(const struct opacity_ext_view *opacity_ext,
                                                      struct finding *finding)
{
    return micromap_indices_are_absent(finding, index_field(opacity_ext),
                                       opacity_ext->opacity->indexType,
                                       opacity_ext->opacity->indexBuffer.deviceAddress);
}
