/* SPDX-License-Identifier: Apache-2.0 */
/* Checks that rules about micromaps share, for every structure that has usage counts, or indices
 * into a micromap. */
#ifndef ASSAY_RULES_MICROMAP_SHARED_H
#define ASSAY_RULES_MICROMAP_SHARED_H

#include "src/model/geometry.h"
#include "src/view/finding.h"
#include "src/view/micromap_view.h"
#include "src/view/names.h"
#include "src/view/phrases.h"

/* Returns usage `index`, which must be less than the count. */
VkMicromapUsageEXT usage_at(const struct micromap_usages *usages, uint32_t index);

/* Returns the path of the array that the application gives. */
const char *usages_field(const struct micromap_usages *usages);

/* Returns the sum of the counts of all usages. */
uint64_t usages_sum(const struct micromap_usages *usages);

/* Statements that apply to every structure with usages. Each returns true, or fills the finding and
 * returns false. */
bool usages_are_given_once(const struct micromap_usages *usages, struct finding *finding);
bool usage_array_is_readable(const struct micromap_usages *usages, struct finding *finding);
bool usage_pointers_are_readable(const struct micromap_usages *usages, struct finding *finding);

/* Each format is from 1 to `last`. `type` is the name of the enumeration. */
bool usage_formats_are_valid(const struct micromap_usages *usages, uint32_t last, const char *type,
                             struct finding *finding);

/* The level of each usage of `format`, or of every usage if `format` is ANY_FORMAT, is within
 * `limit`. */
enum { ANY_FORMAT = 0 };
bool usage_levels_are_within(const struct micromap_usages *usages, uint32_t format, uint32_t limit,
                             const char *limit_name, struct finding *finding);

/* ---- Indices into a micromap. Each function returns true, or fills the finding and returns false.
 */

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
