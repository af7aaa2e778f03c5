/* SPDX-License-Identifier: Apache-2.0 */
/* Checks that rules about indices into a micromap share, for every structure that has such indices.
 * Each returns true, or fills the finding and returns false. */
#ifndef ASSAY_RULES_MICROMAP_INDICES_H
#define ASSAY_RULES_MICROMAP_INDICES_H

#include "src/view/geometry_data.h"
#include "src/view/names.h"
#include "src/view/phrases.h"

static inline bool micromap_index_type_is_valid(struct finding *finding, const char *field,
                                                const struct geometry_view *geometry,
                                                VkIndexType type)
{
    return index_type_size(type) || type == VK_INDEX_TYPE_NONE_KHR ||
           geometry->build->call->device->newer_than_registry ||
           violated(finding, field, "{} is not a VkIndexType", index_type(type));
}

static inline bool micromap_index_stride_is_aligned(struct finding *finding, const char *field,
                                                    VkIndexType type, VkDeviceSize stride)
{
    uint32_t size = index_type_size(type);
    return !size || stride % size == 0 ||
           violated(finding, field, "{} is not a multiple of the size of indexType {} ({})",
                    number(stride), index_type(type), number(size));
}

static inline bool micromap_index_stride_fits_32_bits(struct finding *finding, const char *field,
                                                      VkIndexType type, VkDeviceSize stride)
{
    return type == VK_INDEX_TYPE_NONE_KHR || stride <= UINT32_MAX ||
           stride_fits_32_bits(finding, field, stride);
}

static inline bool micromap_indices_are_given(struct finding *finding, const char *field,
                                              const struct geometry_view *geometry,
                                              VkIndexType type, uint64_t address)
{
    return type == VK_INDEX_TYPE_NONE_KHR || address || geometry_is_empty(geometry) ||
           violated(finding, field, "is 0, but indexType is {}", index_type(type));
}

static inline bool micromap_indices_are_absent(struct finding *finding, const char *field,
                                               VkIndexType type, uint64_t address)
{
    return type != VK_INDEX_TYPE_NONE_KHR || !address ||
           violated(finding, field, "{} is not 0, but indexType is VK_INDEX_TYPE_NONE_KHR",
                    hex(address));
}

#endif
