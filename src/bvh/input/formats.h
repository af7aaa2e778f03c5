/* SPDX-License-Identifier: Apache-2.0 */
/* Vertex formats: convert bytes to three floats. */
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

#endif
