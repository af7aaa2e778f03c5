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
