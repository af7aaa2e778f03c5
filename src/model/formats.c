/* SPDX-License-Identifier: Apache-2.0 */
/* Properties of formats. The only file that includes vk_format_utils.h, whose tables are large. */
#include "src/model/formats.h"

#include <stdatomic.h>
#include <vulkan/utility/vk_format_utils.h>

#include "src/base/recording_path.h"

/* Facts about formats of Vulkan 1.0, which nearly all vertices use, are cached: each function of
 * vk_format_utils.h copies a table row. */
enum { REMEMBERED_FORMATS = VK_FORMAT_ASTC_12x12_SRGB_BLOCK + 1 };

/* All facts about a format, small enough for one atomic load or store. */
union format_facts {
    struct {
        bool looked_up, known;
        uint8_t smallest_component, alignment;
    };
    uint32_t number;
};

static bool has_whole_byte_components(const struct VKU_FORMAT_INFO *info)
{
    for (uint32_t i = 0; i < info->component_count; i++)
        if (info->components[i].size == 0 || info->components[i].size % 8)
            return false;
    return info->component_count > 0;
}

static uint32_t smallest_component(const struct VKU_FORMAT_INFO *info)
{
    uint32_t smallest = 0;
    if (!has_whole_byte_components(info))
        return 0;
    for (uint32_t i = 0; i < info->component_count; i++)
        if (!smallest || info->components[i].size < smallest)
            smallest = info->components[i].size;
    return smallest / 8;
}

static union format_facts look_up_format(VkFormat format)
{
    const struct VKU_FORMAT_INFO info = vkuGetFormatInfo(format);
    union format_facts facts = {{.looked_up = true}};
    facts.known = format == VK_FORMAT_UNDEFINED || info.texel_block_size != 0;
    facts.smallest_component = (uint8_t)smallest_component(&info);
    facts.alignment =
        vkuFormatIsPacked(format) ? (uint8_t)info.texel_block_size : facts.smallest_component;
    return facts;
}

/* Threads may look up one format concurrently; all store the same value. Caching never changes the
 * result, so the function may be `const`, which lets the compiler merge the calls of consecutive
 * rules. */
ON_RECORDING_PATH __attribute__((const, noinline)) static uint32_t number_of_facts(VkFormat format)
{
    static atomic_uint_least32_t remembered[REMEMBERED_FORMATS];
    if ((uint32_t)format >= REMEMBERED_FORMATS)
        return look_up_format(format).number;
    union format_facts facts = {
        .number = atomic_load_explicit(&remembered[format], memory_order_relaxed)};
    if (!facts.looked_up) {
        facts = look_up_format(format);
        atomic_store_explicit(&remembered[format], facts.number, memory_order_relaxed);
    }
    return facts.number;
}

/* The most common format needs no look-up. */
static inline union format_facts facts_of(VkFormat format)
{
    if (format == VK_FORMAT_R32G32B32_SFLOAT)
        return (union format_facts){{true, true, sizeof(float), sizeof(float)}};
    return (union format_facts){.number = number_of_facts(format)};
}

bool format_is_known(VkFormat format)
{
    return facts_of(format).known;
}

uint32_t format_smallest_component(VkFormat format)
{
    return facts_of(format).smallest_component;
}

uint32_t format_alignment(VkFormat format)
{
    return facts_of(format).alignment;
}

uint32_t format_size(VkFormat format)
{
    return vkuGetFormatInfo(format).texel_block_size;
}

uint32_t format_position_size(VkFormat format)
{
    if (format == VK_FORMAT_R32G32B32_SFLOAT)
        return 12;
    const struct VKU_FORMAT_INFO info = vkuGetFormatInfo(format);
    if (vkuFormatIsPacked(format) || !has_whole_byte_components(&info) || info.component_count < 4)
        return info.texel_block_size;
    return info.texel_block_size - info.components[3].size / 8;
}

bool format_color_block(VkFormat format, struct format_block *block)
{
    const struct VKU_FORMAT_INFO info = vkuGetFormatInfo(format);
    if (!info.texel_block_size || !vkuFormatIsColor(format) || vkuFormatIsMultiplane(format) ||
        info.block_extent.depth != 1)
        return false;
    *block = (struct format_block){info.texel_block_size, info.block_extent.width,
                                   info.block_extent.height};
    return true;
}

char format_number_kind(VkFormat format)
{
    return vkuFormatIsSFLOAT(format) ? 'f'
           : vkuFormatIsSNORM(format) || vkuFormatIsSINT(format) || vkuFormatIsSSCALED(format)
               ? 'i'
               : 'u';
}
