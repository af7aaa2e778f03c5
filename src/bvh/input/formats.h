/* SPDX-License-Identifier: Apache-2.0 */
/* Vertex formats: from their bytes to three floats. */
#ifndef ASSAY_BVH_INPUT_FORMATS_H
#define ASSAY_BVH_INPUT_FORMATS_H

#include <stdbool.h>
#include <stdint.h>
#include <vulkan/vulkan_core.h>

struct vertex_format {
    VkFormat format;
    uint32_t size; /* bytes that are read; components beyond the third are not */
    bool has_nan;  /* others are always active */
    void (*read)(const uint8_t *from, float position[3]);
};

/* NULL for a format that the builder doesn't take. */
const struct vertex_format *vertex_format_find(VkFormat format);

uint32_t radius_format_size(VkFormat format); /* 0: none that the builder takes */

float float_from_half(uint16_t half); /* every half is a float; NaN stays NaN */

#endif
