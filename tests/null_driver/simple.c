/* SPDX-License-Identifier: Apache-2.0 */
/* Objects that are only created and destroyed: shaders, pipelines, descriptors, render passes. */
#include "internal.h"

#define CREATE(name, handle_type, info_type, type)                                                 \
    VkResult null_Create##name(VkDevice device, const info_type *pCreateInfo,                      \
                               const VkAllocationCallbacks *pAllocator, handle_type *pHandle)      \
    {                                                                                              \
        ENTER_OR_FAIL(Create##name);                                                               \
        (void)pCreateInfo;                                                                         \
        (void)pAllocator;                                                                          \
        const struct object *object = object_create(OBJECT(device), type, NULL);                   \
        if (object == NULL)                                                                        \
            return VK_ERROR_OUT_OF_HOST_MEMORY;                                                    \
        *pHandle = HANDLE(handle_type, object->handle);                                            \
        return VK_SUCCESS;                                                                         \
    }

#define DESTROY(name, type)                                                                        \
    void null_Destroy##name(VkDevice device, Vk##name handle,                                      \
                            const VkAllocationCallbacks *pAllocator)                               \
    {                                                                                              \
        ENTER(Destroy##name);                                                                      \
        (void)device;                                                                              \
        (void)pAllocator;                                                                          \
        object_destroy(RAW(handle), type);                                                         \
    }

#define SIMPLE(name, suffix)                                                                       \
    CREATE(name##suffix, Vk##name##suffix, Vk##name##CreateInfo##suffix, TYPE_SIMPLE)              \
    DESTROY(name##suffix, TYPE_SIMPLE)

SIMPLE(BufferView, )
SIMPLE(DescriptorSetLayout, )
SIMPLE(DescriptorUpdateTemplate, )
SIMPLE(Framebuffer, )
SIMPLE(ImageView, )
SIMPLE(PipelineCache, )
SIMPLE(PipelineLayout, )
SIMPLE(RenderPass, )
SIMPLE(Sampler, )
SIMPLE(SamplerYcbcrConversion, )
SIMPLE(VideoSession, KHR)
SIMPLE(VideoSessionParameters, KHR)
CREATE(RenderPass2, VkRenderPass, VkRenderPassCreateInfo2, TYPE_SIMPLE)
CREATE(DescriptorPool, VkDescriptorPool, VkDescriptorPoolCreateInfo, TYPE_DESCRIPTOR_POOL)
DESTROY(DescriptorPool, TYPE_DESCRIPTOR_POOL)
DESTROY(Pipeline, TYPE_SIMPLE)

void null_GetRenderAreaGranularity(VkDevice device, VkRenderPass renderPass,
                                   VkExtent2D *pGranularity)
{
    ENTER(GetRenderAreaGranularity);
    (void)device;
    (void)renderPass;
    *pGranularity = (VkExtent2D){1, 1};
}

void null_GetRenderingAreaGranularity(VkDevice device, const VkRenderingAreaInfo *pInfo,
                                      VkExtent2D *pGranularity)
{
    ENTER(GetRenderingAreaGranularity);
    (void)device;
    (void)pInfo;
    *pGranularity = (VkExtent2D){1, 1};
}

/* ---- pipelines */

static VkResult create_pipelines(VkDevice device, uint32_t count, VkPipeline *pipelines)
{
    VkResult result = VK_SUCCESS;
    for (uint32_t i = 0; i < count; i++) {
        const struct object *object = object_create(OBJECT(device), TYPE_SIMPLE, NULL);
        pipelines[i] = object != NULL ? HANDLE(VkPipeline, object->handle) : VK_NULL_HANDLE;
        if (object == NULL)
            result = VK_ERROR_OUT_OF_HOST_MEMORY;
    }
    return result;
}

#define PIPELINES(name, info_type)                                                                 \
    VkResult null_Create##name(VkDevice device, VkPipelineCache pipelineCache,                     \
                               uint32_t createInfoCount, const info_type *pCreateInfos,            \
                               const VkAllocationCallbacks *pAllocator, VkPipeline *pPipelines)    \
    {                                                                                              \
        ENTER_OR_FAIL(Create##name);                                                               \
        (void)pipelineCache;                                                                       \
        (void)pCreateInfos;                                                                        \
        (void)pAllocator;                                                                          \
        return create_pipelines(device, createInfoCount, pPipelines);                              \
    }

PIPELINES(GraphicsPipelines, VkGraphicsPipelineCreateInfo)
PIPELINES(RayTracingPipelinesNV, VkRayTracingPipelineCreateInfoNV)

VkResult null_CreateRayTracingPipelinesKHR(VkDevice device,
                                           VkDeferredOperationKHR deferredOperation,
                                           VkPipelineCache pipelineCache, uint32_t createInfoCount,
                                           const VkRayTracingPipelineCreateInfoKHR *pCreateInfos,
                                           const VkAllocationCallbacks *pAllocator,
                                           VkPipeline *pPipelines)
{
    ENTER_OR_FAIL(CreateRayTracingPipelinesKHR);
    (void)pipelineCache;
    (void)pCreateInfos;
    (void)pAllocator;
    const VkResult result = create_pipelines(device, createInfoCount, pPipelines);
    return result == VK_SUCCESS ? deferred_start(device, deferredOperation) : result;
}

VkResult null_GetRayTracingShaderGroupHandlesKHR(VkDevice device, VkPipeline pipeline,
                                                 uint32_t firstGroup, uint32_t groupCount,
                                                 size_t dataSize, void *pData)
{
    ENTER_OR_FAIL(GetRayTracingShaderGroupHandlesKHR);
    (void)device;
    (void)pipeline;
    (void)firstGroup;
    (void)groupCount;
    memset(pData, 0, dataSize);
    return VK_SUCCESS;
}

VkResult null_GetRayTracingCaptureReplayShaderGroupHandlesKHR(VkDevice device, VkPipeline pipeline,
                                                              uint32_t firstGroup,
                                                              uint32_t groupCount, size_t dataSize,
                                                              void *pData)
{
    ENTER_OR_FAIL(GetRayTracingCaptureReplayShaderGroupHandlesKHR);
    (void)device;
    (void)pipeline;
    (void)firstGroup;
    (void)groupCount;
    memset(pData, 0, dataSize);
    return VK_SUCCESS;
}

VkDeviceSize null_GetRayTracingShaderGroupStackSizeKHR(VkDevice device, VkPipeline pipeline,
                                                       uint32_t group,
                                                       VkShaderGroupShaderKHR groupShader)
{
    ENTER(GetRayTracingShaderGroupStackSizeKHR);
    (void)device;
    (void)pipeline;
    (void)group;
    (void)groupShader;
    return 64;
}

VkResult null_GetPipelineCacheData(VkDevice device, VkPipelineCache pipelineCache,
                                   size_t *pDataSize, void *pData)
{
    ENTER_OR_FAIL(GetPipelineCacheData);
    (void)device;
    (void)pipelineCache;
    (void)pData;
    *pDataSize = 0;
    return VK_SUCCESS;
}

/* ---- descriptors */

void null_GetDescriptorSetLayoutSupport(VkDevice device,
                                        const VkDescriptorSetLayoutCreateInfo *pCreateInfo,
                                        VkDescriptorSetLayoutSupport *pSupport)
{
    ENTER(GetDescriptorSetLayoutSupport);
    (void)device;
    (void)pCreateInfo;
    pSupport->supported = VK_TRUE;
}

VkResult null_ResetDescriptorPool(VkDevice device, VkDescriptorPool descriptorPool,
                                  VkDescriptorPoolResetFlags flags)
{
    ENTER_OR_FAIL(ResetDescriptorPool);
    (void)device;
    (void)flags;
    struct object *pool = object_find(RAW(descriptorPool), TYPE_DESCRIPTOR_POOL);
    if (pool != NULL)
        object_destroy_children(pool, TYPE_DESCRIPTOR_SET);
    return VK_SUCCESS;
}

static void free_sets(uint32_t count, const VkDescriptorSet *sets)
{
    for (uint32_t i = 0; i < count; i++)
        object_destroy(RAW(sets[i]), TYPE_DESCRIPTOR_SET);
}

VkResult null_AllocateDescriptorSets(VkDevice device,
                                     const VkDescriptorSetAllocateInfo *pAllocateInfo,
                                     VkDescriptorSet *pDescriptorSets)
{
    ENTER_OR_FAIL(AllocateDescriptorSets);
    (void)device;
    struct object *pool = object_find(RAW(pAllocateInfo->descriptorPool), TYPE_DESCRIPTOR_POOL);
    if (pool == NULL)
        return VK_ERROR_OUT_OF_POOL_MEMORY;
    for (uint32_t i = 0; i < pAllocateInfo->descriptorSetCount; i++) {
        const struct object *set = object_create(pool, TYPE_DESCRIPTOR_SET, NULL);
        if (set == NULL) {
            free_sets(i, pDescriptorSets);
            return VK_ERROR_OUT_OF_POOL_MEMORY;
        }
        pDescriptorSets[i] = HANDLE(VkDescriptorSet, set->handle);
    }
    return VK_SUCCESS;
}

VkResult null_FreeDescriptorSets(VkDevice device, VkDescriptorPool descriptorPool,
                                 uint32_t descriptorSetCount,
                                 const VkDescriptorSet *pDescriptorSets)
{
    ENTER_OR_FAIL(FreeDescriptorSets);
    (void)device;
    (void)descriptorPool;
    free_sets(descriptorSetCount, pDescriptorSets);
    return VK_SUCCESS;
}
