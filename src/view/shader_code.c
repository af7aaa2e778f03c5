/* SPDX-License-Identifier: Apache-2.0 */
#include "src/view/shader_code.h"

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

/* Capabilities come first in a module, two words each. */
bool shader_code_traces(const uint32_t *code, size_t size)
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

/* Returns the code in the chain of a stage without a module; NULL: there is none. */
static const VkShaderModuleCreateInfo *code_of(const VkPipelineShaderStageCreateInfo *stage)
{
    return stage->module ? NULL
                         : chain_find(stage->pNext, VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO);
}

bool shader_stage_traces(const VkPipelineShaderStageCreateInfo *stage)
{
    const VkShaderModuleCreateInfo *module = code_of(stage);
    return module && shader_code_traces(module->pCode, module->codeSize);
}
