/* SPDX-License-Identifier: Apache-2.0 */
/* Rules about triangles with an opacity micromap of VK_KHR_opacity_micromap. */
#include "src/rules/micromap/shared.h"
#include "src/rules/predicates.h"
#include "src/rules/shared.h"

static struct value micromap_of(const struct opacity_view *opacity)
{
    return object(VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR,
                  handle_number(opacity->opacity->micromap));
}

bool opacity_micromap_is_valid(const struct opacity_view *opacity, struct finding *finding)
{
    return opacity->micromap.alive != NO || opacity->micromap.of_another_device ||
           violated_by_handle(finding, OPACITY_DATA "micromap", micromap_of(opacity),
                              "an acceleration structure of this device");
}

bool opacity_without_indices_has_a_micromap(const struct opacity_view *opacity,
                                            struct finding *finding)
{
    return opacity->opacity->indexType != VK_INDEX_TYPE_NONE_KHR || opacity->opacity->micromap ||
           violated_plainly(finding, OPACITY_DATA "micromap",
                            "is VK_NULL_HANDLE, but indexType is VK_INDEX_TYPE_NONE_KHR");
}

bool opacity_index_type_is_valid(const struct opacity_view *opacity, struct finding *finding)
{
    return micromap_index_type_is_valid(finding, OPACITY_DATA "indexType", opacity->geometry,
                                        opacity->opacity->indexType) ||
           also_violates(finding, RULE_opacity_index_type_is_8_to_32_bits_or_none);
}

/* The enumeration has no other values: an invalid value violates both rules, and the message about
 * the first names the id of the second. */
bool opacity_index_type_is_8_to_32_bits_or_none(const struct opacity_view *opacity,
                                                struct finding *finding)
{
    VkIndexType type = opacity->opacity->indexType;
    return index_type_size(type) || type == VK_INDEX_TYPE_NONE_KHR ||
           opacity->geometry->build->call->device->newer_than_registry ||
           violated(finding, OPACITY_DATA "indexType",
                    "{} is none of VK_INDEX_TYPE_UINT8, _UINT16, _UINT32 and _NONE_KHR",
                    index_type(type)) ||
           is_reported_with(finding, RULE_opacity_index_type_is_valid);
}

bool opacity_without_indices_has_no_index_buffer(const struct opacity_view *opacity,
                                                 struct finding *finding)
{
    return micromap_indices_are_absent(finding, OPACITY_DATA "indexBuffer",
                                       opacity->opacity->indexType, opacity->opacity->indexBuffer);
}

bool opacity_index_buffer_is_given(const struct opacity_view *opacity, struct finding *finding)
{
    return micromap_indices_are_given(finding, OPACITY_DATA "indexBuffer", opacity->geometry,
                                      opacity->opacity->indexType, opacity->opacity->indexBuffer);
}

bool opacity_index_stride_is_aligned(const struct opacity_view *opacity, struct finding *finding)
{
    return micromap_index_stride_is_aligned(finding, OPACITY_DATA "indexStride",
                                            opacity->opacity->indexType,
                                            opacity->opacity->indexStride);
}

bool opacity_index_stride_fits_32_bits(const struct opacity_view *opacity, struct finding *finding)
{
    return micromap_index_stride_fits_32_bits(finding, OPACITY_DATA "indexStride",
                                              opacity->opacity->indexType,
                                              opacity->opacity->indexStride);
}

/* A product that overflows exceeds any buffer. */
bool opacity_indices_are_in_one_buffer(const struct opacity_view *opacity, struct finding *finding)
{
    const struct address_facts *indices = opacity->indices;
    VkDeviceSize stride = opacity->opacity->indexStride, size;
    if (!indices || !opacity->count_known || indices->status != ADDRESS_IN_BUFFER)
        return true;
    bool wraps = __builtin_mul_overflow(stride, opacity->primitive_count, &size);
    return (!wraps && size <= indices->bytes_left) ||
           violated(finding, OPACITY_DATA "indexBuffer",
                    "{} leaves {} to the end of {}, not enough for {} with indexStride {}",
                    hex(indices->address), count_of(indices->bytes_left, "byte"),
                    object(VK_OBJECT_TYPE_BUFFER, handle_number(indices->buffer)),
                    count_of(opacity->primitive_count, "triangle"), number(stride));
}

bool host_build_uses_no_micromap(const struct opacity_view *opacity, struct finding *finding)
{
    return !opacity->opacity->micromap ||
           violated(finding, OPACITY_DATA "micromap",
                    "{} is not VK_NULL_HANDLE, which a host build requires", micromap_of(opacity));
}
