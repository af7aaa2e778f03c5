/* SPDX-License-Identifier: Apache-2.0 */
/* Formats: buffer features as configured, and images of every format there is. */
#include "tests/null_driver/internal.h"

static bool is_format(VkFormat format)
{
    return format > VK_FORMAT_UNDEFINED && format <= VK_FORMAT_ASTC_12x12_SRGB_BLOCK;
}

static VkFormatFeatureFlags2 image_features(VkFormat format)
{
    if (!is_format(format))
        return 0;
    const VkFormatFeatureFlags2 all = VK_FORMAT_FEATURE_2_SAMPLED_IMAGE_BIT |
                                      VK_FORMAT_FEATURE_2_TRANSFER_SRC_BIT |
                                      VK_FORMAT_FEATURE_2_TRANSFER_DST_BIT;
    if (format >= VK_FORMAT_D16_UNORM && format <= VK_FORMAT_D32_SFLOAT_S8_UINT)
        return all | VK_FORMAT_FEATURE_2_DEPTH_STENCIL_ATTACHMENT_BIT;
    return all | VK_FORMAT_FEATURE_2_COLOR_ATTACHMENT_BIT | VK_FORMAT_FEATURE_2_STORAGE_IMAGE_BIT;
}

static VkFormatProperties3 format_properties(const struct null_driver_config *config,
                                             VkFormat format)
{
    VkFormatProperties3 properties = {.linearTilingFeatures = image_features(format),
                                      .optimalTilingFeatures = image_features(format)};
    for (uint32_t i = 0; i < config->format_count; i++) {
        if (config->formats[i].format == format)
            properties.bufferFeatures =
                config->formats[i].buffer_features | VK_FORMAT_FEATURE_2_VERTEX_BUFFER_BIT;
    }
    return properties;
}

/* The older structure holds the flags that fit it. */
static VkFormatFeatureFlags fitting(VkFormatFeatureFlags2 features)
{
    return (VkFormatFeatureFlags)(features & 0x7fffffff);
}

COMMAND(GetPhysicalDeviceFormatProperties2)
{
    const VkFormatProperties3 properties = format_properties(CONFIG(physicalDevice), format);
    pFormatProperties->formatProperties = (VkFormatProperties){
        fitting(properties.linearTilingFeatures), fitting(properties.optimalTilingFeatures),
        fitting(properties.bufferFeatures)};
    for (VkBaseOutStructure *out = pFormatProperties->pNext; out != NULL; out = out->pNext) {
        if (out->sType == VK_STRUCTURE_TYPE_FORMAT_PROPERTIES_3) {
            VkFormatProperties3 *to = (VkFormatProperties3 *)out;
            to->linearTilingFeatures = properties.linearTilingFeatures;
            to->optimalTilingFeatures = properties.optimalTilingFeatures;
            to->bufferFeatures = properties.bufferFeatures;
        }
    }
}

COMMAND(GetPhysicalDeviceImageFormatProperties2)
{
    const struct null_driver_config *config = CONFIG(physicalDevice);
    VkImageFormatProperties *properties = &pImageFormatProperties->imageFormatProperties;
    const uint32_t side = config->properties.limits.maxImageDimension2D;
    *properties = (VkImageFormatProperties){0};
    if (!is_format(pImageFormatInfo->format))
        return VK_ERROR_FORMAT_NOT_SUPPORTED;
    *properties = (VkImageFormatProperties){
        .maxExtent = {side, side, side},
        .maxMipLevels = 15,
        .maxArrayLayers = config->properties.limits.maxImageArrayLayers,
        .sampleCounts = config->properties.limits.framebufferColorSampleCounts,
        .maxResourceSize = (VkDeviceSize)1 << 38,
    };
    return VK_SUCCESS;
}
