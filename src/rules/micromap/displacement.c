/* SPDX-License-Identifier: Apache-2.0 */
/* Rules about triangles with a displacement micromap of VK_NV_displacement_micromap. */
#include "src/model/formats.h"
#include "src/rules/micromap/shared.h"
#include "src/rules/predicates.h"
#include "src/rules/shared.h"

bool displacement_micromap_is_valid(const struct displacement_view *displacement,
                                    struct finding *finding)
{
    return displacement->micromap.alive != NO || displacement->micromap.of_another_device ||
           violated_by_handle(
               finding, DISPLACEMENT_DATA "micromap",
               object(VK_OBJECT_TYPE_MICROMAP_EXT, handle_number(displacement->micromap.handle)),
               "a micromap of this device");
}

static bool format_is_valid(const struct displacement_view *displacement, struct finding *finding,
                            const char *field, VkFormat found)
{
    return format_is_known(found) ||
           displacement->geometry->build->call->device->newer_than_registry ||
           violated(finding, field, "{} is not a VkFormat", number((uint32_t)found));
}

static bool format_is_defined(struct finding *finding, const char *field, VkFormat found)
{
    return found != VK_FORMAT_UNDEFINED ||
           violated_plainly(finding, field, "is VK_FORMAT_UNDEFINED");
}

bool displacement_bias_and_scale_format_is_valid(const struct displacement_view *displacement,
                                                 struct finding *finding)
{
    return format_is_valid(displacement, finding,
                           DISPLACEMENT_DATA "displacementBiasAndScaleFormat",
                           displacement->displacement->displacementBiasAndScaleFormat);
}

bool displacement_bias_and_scale_format_is_defined(const struct displacement_view *displacement,
                                                   struct finding *finding)
{
    return format_is_defined(finding, DISPLACEMENT_DATA "displacementBiasAndScaleFormat",
                             displacement->displacement->displacementBiasAndScaleFormat);
}

bool displacement_vector_format_is_valid(const struct displacement_view *displacement,
                                         struct finding *finding)
{
    return format_is_valid(displacement, finding, DISPLACEMENT_DATA "displacementVectorFormat",
                           displacement->displacement->displacementVectorFormat);
}

bool displacement_vector_format_is_defined(const struct displacement_view *displacement,
                                           struct finding *finding)
{
    return format_is_defined(finding, DISPLACEMENT_DATA "displacementVectorFormat",
                             displacement->displacement->displacementVectorFormat);
}

bool displacement_index_type_is_valid(const struct displacement_view *displacement,
                                      struct finding *finding)
{
    return micromap_index_type_is_valid(finding, DISPLACEMENT_DATA "indexType",
                                        displacement->geometry,
                                        displacement->displacement->indexType);
}

bool displacement_has_one_usage_array(const struct displacement_view *displacement,
                                      struct finding *finding)
{
    return usages_are_given_once(&displacement->usages, finding);
}

bool displacement_usages_are_readable(const struct displacement_view *displacement,
                                      struct finding *finding)
{
    return usage_array_is_readable(&displacement->usages, finding);
}

bool displacement_usage_pointers_are_readable(const struct displacement_view *displacement,
                                              struct finding *finding)
{
    return usage_pointers_are_readable(&displacement->usages, finding);
}
