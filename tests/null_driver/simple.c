/* SPDX-License-Identifier: Apache-2.0 */
/* Render areas, pipelines and descriptors: what is more than created and destroyed. */
#include "internal.h"

void null_GetRenderAreaGranularity(VkDevice device, VkRenderPass renderPass,
                                   VkExtent2D *pGranularity)
{
    *pGranularity = (VkExtent2D){1, 1};
}

void null_GetRenderingAreaGranularity(VkDevice device, const VkRenderingAreaInfo *pInfo,
                                      VkExtent2D *pGranularity)
{
    *pGranularity = (VkExtent2D){1, 1};
}

/* ---- pipelines */

VkResult null_GetRayTracingShaderGroupHandlesKHR(VkDevice device, VkPipeline pipeline,
                                                 uint32_t firstGroup, uint32_t groupCount,
                                                 size_t dataSize, void *pData)
{
    memset(pData, 0, dataSize);
    return VK_SUCCESS;
}

VkResult null_GetRayTracingCaptureReplayShaderGroupHandlesKHR(VkDevice device, VkPipeline pipeline,
                                                              uint32_t firstGroup,
                                                              uint32_t groupCount, size_t dataSize,
                                                              void *pData)
{
    memset(pData, 0, dataSize);
    return VK_SUCCESS;
}

VkDeviceSize null_GetRayTracingShaderGroupStackSizeKHR(VkDevice device, VkPipeline pipeline,
                                                       uint32_t group,
                                                       VkShaderGroupShaderKHR groupShader)
{
    return 64;
}

/* ---- descriptors */

void null_GetDescriptorSetLayoutSupport(VkDevice device,
                                        const VkDescriptorSetLayoutCreateInfo *pCreateInfo,
                                        VkDescriptorSetLayoutSupport *pSupport)
{
    pSupport->supported = VK_TRUE;
}

VkResult null_ResetDescriptorPool(VkDevice device, VkDescriptorPool descriptorPool,
                                  VkDescriptorPoolResetFlags flags)
{
    struct object *pool = FIND(DESCRIPTOR_POOL, descriptorPool);
    if (pool != NULL)
        object_destroy_children(pool, VK_OBJECT_TYPE_DESCRIPTOR_SET);
    return VK_SUCCESS;
}

VkResult null_AllocateDescriptorSets(VkDevice device,
                                     const VkDescriptorSetAllocateInfo *pAllocateInfo,
                                     VkDescriptorSet *pDescriptorSets)
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

VkResult null_FreeDescriptorSets(VkDevice device, VkDescriptorPool descriptorPool,
                                 uint32_t descriptorSetCount,
                                 const VkDescriptorSet *pDescriptorSets)
{
    for (uint32_t i = 0; i < descriptorSetCount; i++)
        object_destroy(RAW(pDescriptorSets[i]), VK_OBJECT_TYPE_DESCRIPTOR_SET);
    return VK_SUCCESS;
}

/* ---- video decoding, as much as it takes to begin a coding scope */

VkResult null_GetPhysicalDeviceVideoCapabilitiesKHR(VkPhysicalDevice physicalDevice,
                                                    const VkVideoProfileInfoKHR *pVideoProfile,
                                                    VkVideoCapabilitiesKHR *pCapabilities)
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

VkResult null_GetPhysicalDeviceVideoFormatPropertiesKHR(
    VkPhysicalDevice physicalDevice, const VkPhysicalDeviceVideoFormatInfoKHR *pVideoFormatInfo,
    uint32_t *pVideoFormatPropertyCount, VkVideoFormatPropertiesKHR *pVideoFormatProperties)
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
