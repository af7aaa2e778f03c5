/* SPDX-License-Identifier: Apache-2.0 */
#include "src/view/shader_code.h"

#include <stdlib.h>

#include "src/base/chain.h"
#include "src/base/readable.h"

/* From the SPIR-V specification. */
enum {
    SPIRV_MAGIC = 0x07230203,
    SPIRV_HEADER_WORDS = 5,
    SPIRV_BOUND_MAX = 1 << 22, /* the least limit of SPIR-V, 2.17 Universal Limits */
    OP_ENTRY_POINT = 15,
    OP_CAPABILITY = 17,
    OP_TYPE_POINTER = 32,
    OP_FUNCTION = 54,
    OP_FUNCTION_END = 56,
    OP_FUNCTION_CALL = 57,
    OP_LOAD = 61,
    OP_STORE = 62,
    OP_COPY_MEMORY = 63,
    OP_COPY_MEMORY_SIZED = 64,
    OP_ACCESS_CHAIN = 65,
    OP_IN_BOUNDS_ACCESS_CHAIN = 66,
    OP_PTR_ACCESS_CHAIN = 67,
    OP_ARRAY_LENGTH = 68,
    OP_IN_BOUNDS_PTR_ACCESS_CHAIN = 70,
    OP_DECORATE = 71,
    OP_GROUP_MEMBER_DECORATE = 75,
    OP_VECTOR_SHUFFLE = 79,
    OP_COMPOSITE_CONSTRUCT = 80,
    OP_COMPOSITE_EXTRACT = 81,
    OP_COMPOSITE_INSERT = 82,
    OP_COPY_OBJECT = 83,
    OP_CONVERT_PTR_TO_U = 117,
    OP_CONVERT_U_TO_PTR = 120,
    OP_BITCAST = 124,
    OP_SELECT = 169,
    OP_ATOMIC_LOAD = 227,
    OP_PHI = 245,
    OP_LOOP_MERGE = 246,
    OP_RETURN_VALUE = 254,
    OP_UNREACHABLE = 255,
    OP_NO_LINE = 317,
    STORAGE_CLASS_PHYSICAL_STORAGE_BUFFER = 5349,
    OP_CONVERT_U_TO_ACCELERATION_STRUCTURE_KHR = 4447,
    CAPABILITY_UNTYPED_POINTERS_KHR = 4473,
    CAPABILITY_PHYSICAL_STORAGE_BUFFER_ADDRESSES = 5347,
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

/* A module with several entry points declares what any of them needs. */
static bool has_one_entry(const uint32_t *code, size_t words)
{
    uint32_t count = 0;
    for (size_t i = SPIRV_HEADER_WORDS; i < words && code[i] >> 16; i += code[i] >> 16) {
        const unsigned op = code[i] & 0xffff;
        if (op == OP_FUNCTION)
            break;
        count += op == OP_ENTRY_POINT;
    }
    return count == 1;
}

bool shader_code_certainly_traces(const uint32_t *code, size_t size)
{
    return shader_code_traces(code, size) && has_one_entry(code, size / sizeof(*code));
}

/* ---- traces by address */

bool shader_code_traces_addresses(const uint32_t *code, size_t size)
{
    const size_t words = size / sizeof(*code);
    if (words < SPIRV_HEADER_WORDS || !readable(readable_cache_of_thread(), code, size) ||
        code[0] != SPIRV_MAGIC)
        return true;
    for (size_t i = SPIRV_HEADER_WORDS; i < words; i += code[i] >> 16)
        if (!(code[i] >> 16) || (code[i] & 0xffff) == OP_CONVERT_U_TO_ACCELERATION_STRUCTURE_KHR)
            return true;
    return false;
}

/* ---- stores through addresses */

/* What an id is. */
enum { IS_POINTER_TYPE = 1, IS_POINTER = 2 };

struct scan {
    unsigned char *ids; /* of pointers that are addresses, and of their types */
    uint32_t bound;     /* ids are smaller */
    bool has_addresses; /* a capability of such pointers is declared */
    bool stores;
};

static unsigned kind_of(const struct scan *scan, uint32_t id)
{
    return id < scan->bound ? scan->ids[id] : 0;
}

/* Whether the instruction only reads what a pointer among its operands leads to, or computes
 * another pointer. */
static bool only_reads(unsigned op)
{
    switch (op) {
    case OP_LOAD:
    case OP_ACCESS_CHAIN:
    case OP_IN_BOUNDS_ACCESS_CHAIN:
    case OP_PTR_ACCESS_CHAIN:
    case OP_IN_BOUNDS_PTR_ACCESS_CHAIN:
    case OP_ARRAY_LENGTH:
    case OP_FUNCTION_CALL: /* its parameters are pointers, too */
    case OP_COMPOSITE_CONSTRUCT:
    case OP_COMPOSITE_EXTRACT:
    case OP_COMPOSITE_INSERT:
    case OP_COPY_OBJECT:
    case OP_CONVERT_PTR_TO_U:
    case OP_CONVERT_U_TO_PTR:
    case OP_BITCAST:
    case OP_SELECT:
    case OP_PHI:
    case OP_RETURN_VALUE:
    case OP_ATOMIC_LOAD:
        return true;
    default: /* names, lines, types, constants and labels have numbers that are no ids */
        return op < OP_FUNCTION || (op >= OP_FUNCTION && op <= OP_FUNCTION_END) ||
               (op >= OP_DECORATE && op <= OP_GROUP_MEMBER_DECORATE) ||
               (op >= OP_LOOP_MERGE && op <= OP_UNREACHABLE) || op == OP_VECTOR_SHUFFLE ||
               op == OP_NO_LINE;
    }
}

static bool has_pointer(const struct scan *scan, const uint32_t *operands, size_t count)
{
    for (size_t i = 0; i < count; i++)
        if (kind_of(scan, operands[i]) & IS_POINTER)
            return true;
    return false;
}

/* A store may write a pointer to where no pointer leads. */
static bool stores(const struct scan *scan, unsigned op, const uint32_t *operands, size_t count)
{
    if (op == OP_STORE || op == OP_COPY_MEMORY || op == OP_COPY_MEMORY_SIZED)
        return count && kind_of(scan, operands[0]) & IS_POINTER;
    return !only_reads(op) && has_pointer(scan, operands, count);
}

static void scan_instruction(struct scan *scan, unsigned op, const uint32_t *operands, size_t count)
{
    if (op == OP_CAPABILITY && count)
        scan->has_addresses |= operands[0] == CAPABILITY_PHYSICAL_STORAGE_BUFFER_ADDRESSES;
    if (op == OP_CAPABILITY && count)
        scan->stores |= operands[0] == CAPABILITY_UNTYPED_POINTERS_KHR;
    scan->stores |= stores(scan, op, operands, count);
    if (op == OP_TYPE_POINTER && count > 1 && operands[0] < scan->bound &&
        operands[1] == STORAGE_CLASS_PHYSICAL_STORAGE_BUFFER)
        scan->ids[operands[0]] |= IS_POINTER_TYPE;
    if (count > 1 && kind_of(scan, operands[0]) & IS_POINTER_TYPE && operands[1] < scan->bound)
        scan->ids[operands[1]] |= IS_POINTER;
}

static bool scan_stores(struct scan *scan, const uint32_t *code, size_t words)
{
    for (size_t i = SPIRV_HEADER_WORDS; i < words && !scan->stores;) {
        const size_t length = code[i] >> 16;
        const unsigned op = code[i] & 0xffff;
        if (!length || length > words - i)
            return true;
        if (op == OP_FUNCTION && !scan->has_addresses)
            break;
        scan_instruction(scan, op, &code[i + 1], length - 1);
        i += length;
    }
    return scan->stores;
}

/* An instruction whose first operand is the type of a pointer has the pointer as the second one. */
bool shader_code_stores(const uint32_t *code, size_t size)
{
    const size_t words = size / sizeof(*code);
    if (words < SPIRV_HEADER_WORDS || !readable(readable_cache_of_thread(), code, size) ||
        code[0] != SPIRV_MAGIC || code[3] > SPIRV_BOUND_MAX)
        return true;
    struct scan scan = {.ids = calloc(code[3] + 1, 1), .bound = code[3]};
    const bool result = !scan.ids || scan_stores(&scan, code, words);
    free(scan.ids);
    return result;
}

/* Returns the code in the chain of a stage without a module; NULL: there is none. */
static const VkShaderModuleCreateInfo *code_of(const VkPipelineShaderStageCreateInfo *stage)
{
    return stage->module ? NULL
                         : chain_find(stage->pNext, VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO);
}

bool shader_stage_stores(const VkPipelineShaderStageCreateInfo *stage)
{
    const VkShaderModuleCreateInfo *module = code_of(stage);
    return !stage->module && (!module || shader_code_stores(module->pCode, module->codeSize));
}

/* ---- stages */

bool shader_stage_traces(const VkPipelineShaderStageCreateInfo *stage)
{
    const VkShaderModuleCreateInfo *module = code_of(stage);
    return module && shader_code_traces(module->pCode, module->codeSize);
}

bool shader_stage_certainly_traces(const VkPipelineShaderStageCreateInfo *stage)
{
    const VkShaderModuleCreateInfo *module = code_of(stage);
    return module && shader_code_certainly_traces(module->pCode, module->codeSize);
}

bool shader_stage_traces_addresses(const VkPipelineShaderStageCreateInfo *stage)
{
    const VkShaderModuleCreateInfo *module = code_of(stage);
    return module && shader_code_traces_addresses(module->pCode, module->codeSize);
}
