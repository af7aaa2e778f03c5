/* SPDX-License-Identifier: Apache-2.0 */
/* Questions about formats. The only file that includes vk_format_utils.h, whose tables are big. */
#include "check/formats.h"

#include <vulkan/utility/vk_format_utils.h>

bool format_is_known(VkFormat format)
{
    return format == VK_FORMAT_UNDEFINED || vkuGetFormatInfo(format).texel_block_size != 0;
}

static bool has_whole_byte_components(const struct VKU_FORMAT_INFO *info)
{
    for (uint32_t i = 0; i < info->component_count; i++)
        if (info->components[i].size == 0 || info->components[i].size % 8)
            return false;
    return info->component_count > 0;
}

uint32_t format_smallest_component(VkFormat format)
{
    const struct VKU_FORMAT_INFO info = vkuGetFormatInfo(format);
    uint32_t smallest = 0;
    if (!has_whole_byte_components(&info))
        return 0;
    for (uint32_t i = 0; i < info.component_count; i++)
        if (!smallest || info.components[i].size < smallest)
            smallest = info.components[i].size;
    return smallest / 8;
}

uint32_t format_alignment(VkFormat format)
{
    return vkuFormatIsPacked(format) ? vkuFormatTexelBlockSize(format)
                                     : format_smallest_component(format);
}
