/* SPDX-License-Identifier: Apache-2.0 */
/* Images: created, measured, bound; they have no contents. */
#include "tests/null_driver/internal.h"

static VkMemoryRequirements requirements(const struct null_driver_config *config,
                                         const VkImageCreateInfo *info)
{
    const VkExtent3D *extent = &info->extent;
    /* 16 bytes a texel and twice the first level are enough for any format with all its levels. */
    const VkDeviceSize texels =
        (VkDeviceSize)extent->width * extent->height * extent->depth * info->arrayLayers;
    const bool protected = info->flags & VK_IMAGE_CREATE_PROTECTED_BIT;
    const bool transient = info->usage & VK_IMAGE_USAGE_TRANSIENT_ATTACHMENT_BIT;
    const VkMemoryPropertyFlags required = protected ? VK_MEMORY_PROPERTY_PROTECTED_BIT : 0;
    const VkMemoryPropertyFlags refused = (protected ? 0 : VK_MEMORY_PROPERTY_PROTECTED_BIT) |
                                          (transient ? 0 : VK_MEMORY_PROPERTY_LAZILY_ALLOCATED_BIT);
    return (VkMemoryRequirements){
        .size = align_up(texels * 32 * (info->samples != 0 ? info->samples : 1), 65536),
        .alignment = 65536,
        .memoryTypeBits = requirements_types(config, required, refused),
    };
}

ON_CREATION(CreateImage)
{
    object->image = requirements(object->config, pCreateInfo);
}

static VkMemoryRequirements requirements_of(VkImage image)
{
    const struct object *object = FIND(IMAGE, image);
    return object != NULL ? object->image : (VkMemoryRequirements){0};
}

COMMAND(GetImageMemoryRequirements2)
{
    pMemoryRequirements->memoryRequirements = requirements_of(pInfo->image);
}
