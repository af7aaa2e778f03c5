/* SPDX-License-Identifier: Apache-2.0 */
/* Commands of backend cpu: shaders. Shaders that trace rays cannot work. */
#include "layer/cpu/overlay.h"
#include "layer/cpu/unsupported.h"
#include "observers.h"
#include "src/base/chain.h"
#include "src/base/readable.h"

/* From the SPIR-V specification. */
enum {
    SPIRV_MAGIC = 0x07230203,
    SPIRV_HEADER_WORDS = 5,
    OP_CAPABILITY = 17,
    CAPABILITY_RAY_QUERY_PROVISIONAL_KHR = 4471,
    CAPABILITY_RAY_QUERY_KHR = 4472,
    CAPABILITY_RAY_TRAVERSAL_PRIMITIVE_CULLING_KHR = 4478,
    CAPABILITY_RAY_TRACING_KHR = 4479,
    CAPABILITY_RAY_TRACING_NV = 5340,
    CAPABILITY_RAY_TRACING_PROVISIONAL_KHR = 5353,
};

static bool capability_traces(uint32_t capability)
{
    switch (capability) {
    case CAPABILITY_RAY_QUERY_PROVISIONAL_KHR:
    case CAPABILITY_RAY_QUERY_KHR:
    case CAPABILITY_RAY_TRAVERSAL_PRIMITIVE_CULLING_KHR:
    case CAPABILITY_RAY_TRACING_KHR:
    case CAPABILITY_RAY_TRACING_NV:
    case CAPABILITY_RAY_TRACING_PROVISIONAL_KHR:
        return true;
    default:
        return false;
    }
}

/* Whether a module has a capability of ray tracing. Capabilities come first in a module, two words
 * each. `size` is in bytes. */
static bool code_traces(const uint32_t *code, size_t size)
{
    const size_t words = size / sizeof(*code);
    if (words < SPIRV_HEADER_WORDS || !readable(readable_cache_of_thread(), code, size) ||
        code[0] != SPIRV_MAGIC)
        return false;
    for (size_t i = SPIRV_HEADER_WORDS; i + 1 < words; i += 2) {
        if (code[i] != (2 << 16 | OP_CAPABILITY))
            return false;
        if (capability_traces(code[i + 1]))
            return true;
    }
    return false;
}

static const char *const what_is_unsupported = "a shader that traces rays";

static VkResult report_unsupported(VkDevice device, const char *command)
{
    cpu_report_unsupported(layer_find_device(device)->instance, command, what_is_unsupported);
    return VK_ERROR_VALIDATION_FAILED_EXT;
}

VKAPI_ATTR VkResult VKAPI_CALL cpu_CreateShaderModule(VkDevice device,
                                                      const VkShaderModuleCreateInfo *pCreateInfo,
                                                      const VkAllocationCallbacks *pAllocator,
                                                      VkShaderModule *pShaderModule)
{
    if (code_traces(pCreateInfo->pCode, pCreateInfo->codeSize))
        return report_unsupported(device, "vkCreateShaderModule");
    return cpu_next(device)->CreateShaderModule(device, pCreateInfo, pAllocator, pShaderModule);
}

VKAPI_ATTR VkResult VKAPI_CALL cpu_CreateShadersEXT(VkDevice device, uint32_t createInfoCount,
                                                    const VkShaderCreateInfoEXT *pCreateInfos,
                                                    const VkAllocationCallbacks *pAllocator,
                                                    VkShaderEXT *pShaders)
{
    for (uint32_t i = 0; i < createInfoCount; i++) {
        if (pCreateInfos[i].codeType != VK_SHADER_CODE_TYPE_SPIRV_EXT ||
            !code_traces(pCreateInfos[i].pCode, pCreateInfos[i].codeSize))
            continue;
        for (uint32_t j = 0; j < createInfoCount; j++)
            pShaders[j] = VK_NULL_HANDLE;
        return report_unsupported(device, "vkCreateShadersEXT");
    }
    return cpu_next(device)->CreateShadersEXT(device, createInfoCount, pCreateInfos, pAllocator,
                                              pShaders);
}

/* ---- pipeline stages with inline shader code */

static bool stage_traces(const VkPipelineShaderStageCreateInfo *stage)
{
    const VkShaderModuleCreateInfo *module =
        stage->module ? NULL
                      : chain_find(stage->pNext, VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO);
    return module && code_traces(module->pCode, module->codeSize);
}

/* A pipeline library may ignore its stages, which then need not be readable. */
static bool a_stage_traces(const VkGraphicsPipelineCreateInfo *info)
{
    struct readable_cache *cache = readable_cache_of_thread();
    for (uint32_t i = 0; i < info->stageCount; i++) {
        if (!readable(cache, &info->pStages[i], sizeof(info->pStages[i])))
            return false;
        if (stage_traces(&info->pStages[i]))
            return true;
    }
    return false;
}

static VkResult report_unsupported_pipelines(VkDevice device, const char *command, uint32_t count,
                                             VkPipeline *pipelines)
{
    for (uint32_t i = 0; i < count; i++)
        pipelines[i] = VK_NULL_HANDLE;
    return report_unsupported(device, command);
}

VKAPI_ATTR VkResult VKAPI_CALL
cpu_CreateComputePipelines(VkDevice device, VkPipelineCache pipelineCache, uint32_t createInfoCount,
                           const VkComputePipelineCreateInfo *pCreateInfos,
                           const VkAllocationCallbacks *pAllocator, VkPipeline *pPipelines)
{
    for (uint32_t i = 0; i < createInfoCount; i++)
        if (stage_traces(&pCreateInfos[i].stage))
            return report_unsupported_pipelines(device, "vkCreateComputePipelines", createInfoCount,
                                                pPipelines);
    return cpu_next(device)->CreateComputePipelines(device, pipelineCache, createInfoCount,
                                                    pCreateInfos, pAllocator, pPipelines);
}

VKAPI_ATTR VkResult VKAPI_CALL cpu_CreateGraphicsPipelines(
    VkDevice device, VkPipelineCache pipelineCache, uint32_t createInfoCount,
    const VkGraphicsPipelineCreateInfo *pCreateInfos, const VkAllocationCallbacks *pAllocator,
    VkPipeline *pPipelines)
{
    for (uint32_t i = 0; i < createInfoCount; i++)
        if (a_stage_traces(&pCreateInfos[i]))
            return report_unsupported_pipelines(device, "vkCreateGraphicsPipelines",
                                                createInfoCount, pPipelines);
    return cpu_next(device)->CreateGraphicsPipelines(device, pipelineCache, createInfoCount,
                                                     pCreateInfos, pAllocator, pPipelines);
}

/* ---- the shader side of VK_NV_ray_tracing */

VKAPI_ATTR VkResult VKAPI_CALL cpu_CreateRayTracingPipelinesNV(
    VkDevice device, VkPipelineCache pipelineCache, uint32_t createInfoCount,
    const VkRayTracingPipelineCreateInfoNV *pCreateInfos, const VkAllocationCallbacks *pAllocator,
    VkPipeline *pPipelines)
{
    (void)pipelineCache;
    (void)pCreateInfos;
    (void)pAllocator;
    return report_unsupported_pipelines(device, "vkCreateRayTracingPipelinesNV", createInfoCount,
                                        pPipelines);
}

VKAPI_ATTR VkResult VKAPI_CALL cpu_CompileDeferredNV(VkDevice device, VkPipeline pipeline,
                                                     uint32_t shader)
{
    (void)pipeline;
    (void)shader;
    return report_unsupported(device, "vkCompileDeferredNV");
}

VKAPI_ATTR VkResult VKAPI_CALL cpu_GetRayTracingShaderGroupHandlesNV(VkDevice device,
                                                                     VkPipeline pipeline,
                                                                     uint32_t firstGroup,
                                                                     uint32_t groupCount,
                                                                     size_t dataSize, void *pData)
{
    (void)pipeline;
    (void)firstGroup;
    (void)groupCount;
    (void)dataSize;
    (void)pData;
    return report_unsupported(device, "vkGetRayTracingShaderGroupHandlesNV");
}

VKAPI_ATTR void VKAPI_CALL cpu_CmdTraceRaysNV(
    VkCommandBuffer commandBuffer, VkBuffer raygenShaderBindingTableBuffer,
    VkDeviceSize raygenShaderBindingOffset, VkBuffer missShaderBindingTableBuffer,
    VkDeviceSize missShaderBindingOffset, VkDeviceSize missShaderBindingStride,
    VkBuffer hitShaderBindingTableBuffer, VkDeviceSize hitShaderBindingOffset,
    VkDeviceSize hitShaderBindingStride, VkBuffer callableShaderBindingTableBuffer,
    VkDeviceSize callableShaderBindingOffset, VkDeviceSize callableShaderBindingStride,
    uint32_t width, uint32_t height, uint32_t depth)
{
    (void)raygenShaderBindingTableBuffer;
    (void)raygenShaderBindingOffset;
    (void)missShaderBindingTableBuffer;
    (void)missShaderBindingOffset;
    (void)missShaderBindingStride;
    (void)hitShaderBindingTableBuffer;
    (void)hitShaderBindingOffset;
    (void)hitShaderBindingStride;
    (void)callableShaderBindingTableBuffer;
    (void)callableShaderBindingOffset;
    (void)callableShaderBindingStride;
    (void)width;
    (void)height;
    (void)depth;
    const struct layer_device *device = layer_find_recording_device(commandBuffer);
    if (device)
        cpu_report_unsupported(device->instance, "vkCmdTraceRaysNV", what_is_unsupported);
}
