/* SPDX-License-Identifier: Apache-2.0 */
/* Vertex formats and indices: converts bytes to three floats, and reads indices. */
#ifndef ASSAY_BVH_INPUT_FORMATS_H
#define ASSAY_BVH_INPUT_FORMATS_H

#include <stdbool.h>
#include <stdint.h>
#include <vulkan/vulkan_core.h>

struct vertex_format {
    VkFormat format;
    uint32_t size; /* bytes read, without components beyond the third */
    bool has_nan;  /* formats without NaN are always active */
    void (*read)(const uint8_t *from, float position[3]);
};

/* Returns NULL if the builder does not support the format. */
const struct vertex_format *vertex_format_find(VkFormat format);

/* Returns the size of a radius in bytes, or 0 if the builder does not support the format. */
uint32_t radius_format_size(VkFormat format);

float float_from_half(uint16_t half); /* exact; NaN stays NaN */

/* ---- the size of an index, and scans of whole arrays of indices and positions */

/* Returns the size of an index in bytes, or 0 for VK_INDEX_TYPE_NONE_KHR and invalid values. */
static inline uint32_t index_type_size(VkIndexType type)
{
    switch ((int)type) {
    case VK_INDEX_TYPE_UINT8:
        return 1;
    case VK_INDEX_TYPE_UINT16:
        return 2;
    case VK_INDEX_TYPE_UINT32:
        return 4;
    default:
        return 0;
    }
}

/* The largest of `count` indices of `size` bytes each (1, 2 or 4), at any address; 0 if there are
 * none. */
uint32_t indices_max(const uint8_t *indices, uint32_t size, uint64_t count);

/* Whether any of `count` positions, three floats each, has an element that is NaN. `stride` is in
 * bytes; addresses need no alignment. */
bool positions_have_nan(const uint8_t *positions, uint64_t stride, uint64_t count);

#endif
