/* SPDX-License-Identifier: Apache-2.0 */
/* What rules ask about a VkFormat, from the tables of Vulkan-Utility-Libraries. */
#ifndef ASSAY_VIEW_FORMATS_H
#define ASSAY_VIEW_FORMATS_H

#include <stdbool.h>
#include <stdint.h>
#include <vulkan/vulkan_core.h>

bool format_is_known(VkFormat format); /* VK_FORMAT_UNDEFINED is a value of VkFormat, too */

/* The size of the smallest component in bytes; 0 where components aren't whole bytes. */
uint32_t format_smallest_component(VkFormat format);
/* Of one element; 0 for formats that aren't known. */
uint32_t format_size(VkFormat format);

/* What addresses of such data are aligned to: all of a packed format, one component of another; 0
 * where the format has no such size. */
uint32_t format_alignment(VkFormat format);

#endif
