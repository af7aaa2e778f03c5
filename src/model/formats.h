/* SPDX-License-Identifier: Apache-2.0 */
/* Properties of a VkFormat that rules need, from the tables of Vulkan-Utility-Libraries. */
#ifndef ASSAY_MODEL_FORMATS_H
#define ASSAY_MODEL_FORMATS_H

#include <stdbool.h>
#include <stdint.h>
#include <vulkan/vulkan_core.h>

bool format_is_known(VkFormat format); /* true for VK_FORMAT_UNDEFINED, too */

/* Returns the size of the smallest component in bytes, or 0 if components are not whole bytes. */
uint32_t format_smallest_component(VkFormat format);
/* Returns the size of one element in bytes, or 0 if the format is unknown. */
uint32_t format_size(VkFormat format);
/* Returns the size of the first three components: a build does not read a fourth one. */
uint32_t format_position_size(VkFormat format);

/* Returns the alignment that addresses of such data need, in bytes: the size of a packed format,
 * and the size of a component for other formats. Returns 0 if the format has no such size. */
uint32_t format_alignment(VkFormat format);

/* Returns how numbers of the format are encoded, as NumPy calls it: 'f', 'i' or 'u'. */
char format_number_kind(VkFormat format);

/* Finds the blocks of a color image of one plane. Returns false for other formats. */
struct format_block {
    uint32_t size; /* bytes */
    uint32_t width, height;
};
bool format_color_block(VkFormat format, struct format_block *block);

#endif
