/* SPDX-License-Identifier: Apache-2.0 */
/* Descriptors, and video decoding as far as it takes to begin a coding scope. */
#include "tests/null_driver/internal.h"

COMMAND(ResetDescriptorPool)
{
    struct object *pool = FIND(DESCRIPTOR_POOL, descriptorPool);
    if (pool != NULL)
        object_destroy_children(pool, VK_OBJECT_TYPE_DESCRIPTOR_SET);
    return VK_SUCCESS;
}

COMMAND(AllocateDescriptorSets)
{
    const uint32_t count = pAllocateInfo->descriptorSetCount;
    struct object *pool = FIND(DESCRIPTOR_POOL, pAllocateInfo->descriptorPool);
    if (pool != NULL &&
        objects_create(pool, VK_OBJECT_TYPE_DESCRIPTOR_SET, count, pDescriptorSets) == VK_SUCCESS)
        return VK_SUCCESS;
    for (uint32_t i = 0; pool != NULL && i < count; i++)
        object_destroy(RAW(pDescriptorSets[i]), VK_OBJECT_TYPE_DESCRIPTOR_SET);
    return VK_ERROR_OUT_OF_POOL_MEMORY;
}

COMMAND(FreeDescriptorSets)
{
    for (uint32_t i = 0; i < descriptorSetCount; i++)
        object_destroy(RAW(pDescriptorSets[i]), VK_OBJECT_TYPE_DESCRIPTOR_SET);
    return VK_SUCCESS;
}

/* ---- video decoding */

COMMAND(GetPhysicalDeviceVideoCapabilitiesKHR)
{
    if (pVideoProfile->videoCodecOperation != VK_VIDEO_CODEC_OPERATION_DECODE_H264_BIT_KHR)
        return VK_ERROR_VIDEO_PROFILE_CODEC_NOT_SUPPORTED_KHR;
    pCapabilities->flags = 0;
    pCapabilities->minBitstreamBufferOffsetAlignment = 16;
    pCapabilities->minBitstreamBufferSizeAlignment = 16;
    pCapabilities->pictureAccessGranularity = (VkExtent2D){16, 16};
    pCapabilities->minCodedExtent = (VkExtent2D){16, 16};
    pCapabilities->maxCodedExtent = (VkExtent2D){4096, 4096};
    pCapabilities->maxDpbSlots = 16;
    pCapabilities->maxActiveReferencePictures = 16;
    pCapabilities->stdHeaderVersion =
        (VkExtensionProperties){VK_STD_VULKAN_VIDEO_CODEC_H264_DECODE_EXTENSION_NAME,
                                VK_STD_VULKAN_VIDEO_CODEC_H264_DECODE_SPEC_VERSION};
    return VK_SUCCESS;
}

COMMAND(GetPhysicalDeviceVideoFormatPropertiesKHR)
{
    if (pVideoFormatProperties != NULL && *pVideoFormatPropertyCount > 0) {
        pVideoFormatProperties->format = VK_FORMAT_G8_B8R8_2PLANE_420_UNORM;
        pVideoFormatProperties->imageCreateFlags = 0;
        pVideoFormatProperties->imageType = VK_IMAGE_TYPE_2D;
        pVideoFormatProperties->imageTiling = VK_IMAGE_TILING_OPTIMAL;
        pVideoFormatProperties->imageUsageFlags = pVideoFormatInfo->imageUsage;
    }
    const bool short_of_room = pVideoFormatProperties != NULL && *pVideoFormatPropertyCount == 0;
    *pVideoFormatPropertyCount = short_of_room ? 0 : 1;
    return short_of_room ? VK_INCOMPLETE : VK_SUCCESS;
}
