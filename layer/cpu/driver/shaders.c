/* SPDX-License-Identifier: Apache-2.0 */
/* Backend cpu: shaders. Shaders that trace rays cannot work. */
#include <string.h>

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
bool cpu_code_traces(const uint32_t *code, size_t size)
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

void cpu_report_shader(struct layer_device *device, const char *command)
{
    cpu_report_unsupported(device->instance, command, "a shader that traces rays");
}

VkResult cpu_refuse_shader(struct layer_device *device, const char *command)
{
    cpu_report_shader(device, command);
    return VK_ERROR_VALIDATION_FAILED_EXT;
}

/* `handles`: of the shaders or pipelines that are not created. */
VkResult cpu_refuse_shaders(struct layer_device *device, const char *command, uint32_t count,
                            void *handles)
{
    if (count)
        memset(handles, 0, count * sizeof(VkPipeline));
    return cpu_refuse_shader(device, command);
}

bool cpu_shaders_trace(uint32_t count, const VkShaderCreateInfoEXT *infos)
{
    bool found = false;
    for (uint32_t i = 0; i < count && !found; i++)
        found = infos[i].codeType == VK_SHADER_CODE_TYPE_SPIRV_EXT &&
                cpu_code_traces(infos[i].pCode, infos[i].codeSize);
    return found;
}

/* ---- pipeline stages with inline shader code */

static bool stage_traces(const VkPipelineShaderStageCreateInfo *stage)
{
    const VkShaderModuleCreateInfo *module =
        stage->module ? NULL
                      : chain_find(stage->pNext, VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO);
    return module && cpu_code_traces(module->pCode, module->codeSize);
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

bool cpu_compute_pipelines_trace(uint32_t count, const VkComputePipelineCreateInfo *infos)
{
    bool found = false;
    for (uint32_t i = 0; i < count && !found; i++)
        found = stage_traces(&infos[i].stage);
    return found;
}

bool cpu_graphics_pipelines_trace(uint32_t count, const VkGraphicsPipelineCreateInfo *infos)
{
    bool found = false;
    for (uint32_t i = 0; i < count && !found; i++)
        found = a_stage_traces(&infos[i]);
    return found;
}
