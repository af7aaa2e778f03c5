/* SPDX-License-Identifier: Apache-2.0 */
/* What the driver sees of shaders, of which those that trace rays are refused.
 */

#include "below.h"
#include "layer/cpu/commands.h"
#include "tests/fixture/objects.h"
#include "tests/state/unit_test.h"

/* ---- the driver */

COUNTED(CreateShaderModule)
COUNTED(CreateShadersEXT)
COUNTED(CreateComputePipelines)
COUNTED(CreateGraphicsPipelines)

/* ---- tests */

#define HEADER 0x07230203, 0x00010400, 0, 1, 0
#define CAPABILITY(number) 2 << 16 | 17, number
static const uint32_t plain[] = {HEADER, CAPABILITY(1), CAPABILITY(5347), 3 << 16 | 14, 0, 1};
static const uint32_t with_queries[] = {HEADER, CAPABILITY(1), CAPABILITY(4472), 3 << 16 | 14, 0,
                                        1};
static const uint32_t with_pipelines[] = {HEADER, CAPABILITY(4479)};
/* The number is no capability here. */
static const uint32_t behind[] = {HEADER, CAPABILITY(1), 3 << 16 | 14, 0, 1, CAPABILITY(4472)};

static VkResult try_code(const uint32_t *code, size_t size)
{
    const STRUCT(VkShaderModuleCreateInfo, info, .codeSize = size, .pCode = code);
    const VkShaderCreateInfoEXT shaders[] = {
        {.codeType = VK_SHADER_CODE_TYPE_BINARY_EXT, .codeSize = size, .pCode = code},
        {.codeType = VK_SHADER_CODE_TYPE_SPIRV_EXT, .codeSize = size, .pCode = code}};
    const VkPipelineShaderStageCreateInfo stages[] = {{.module = (VkShaderModule)(uintptr_t)7},
                                                      {.pNext = &info}};
    const VkComputePipelineCreateInfo compute[] = {{.stage = stages[0]}, {.stage = stages[1]}};
    const VkGraphicsPipelineCreateInfo graphics = {.stageCount = 2, .pStages = stages};
    VkShaderModule module;
    VkShaderEXT made[2] = {(VkShaderEXT)(uintptr_t)7};
    VkPipeline pipelines[2] = {(VkPipeline)(uintptr_t)7};
    const VkResult result = cpu_CreateShaderModule(DEVICE, &info, NULL, &module);
    GET(cpu_CreateShadersEXT(DEVICE, 1, shaders, NULL, made));
    assert_int_equal(cpu_CreateShadersEXT(DEVICE, 2, shaders, NULL, made), result);
    assert_int_equal(
        cpu_CreateComputePipelines(DEVICE, VK_NULL_HANDLE, 2, compute, NULL, pipelines), result);
    if (result != VK_SUCCESS) {
        assert_true(made[0] == VK_NULL_HANDLE);
        assert_true(pipelines[0] == VK_NULL_HANDLE);
    }
    assert_int_equal(
        cpu_CreateGraphicsPipelines(DEVICE, VK_NULL_HANDLE, 1, &graphics, NULL, pipelines), result);
    return result;
}

TEST_OPENED(test_shaders, below_clear)
{
    GET(try_code(plain, sizeof(plain)));
    GET(try_code(behind, sizeof(behind)));
    GET(try_code(plain, 8));
    GET(try_code(with_queries, sizeof(with_queries) - 20)); /* cut off */
    assert_int_equal(refusals, 0);
    assert_int_equal(calls, 20);
    REFUSED(try_code(with_queries, sizeof(with_queries)));
    assert_int_equal(refusals, 4);
    REFUSED(try_code(with_pipelines, sizeof(with_pipelines)));
    assert_int_equal(refusals, 8);
    assert_int_equal(calls, 22);
}

TEST_OPENED(test_pipelines_of_nv, below_clear)
{
    VkPipeline pipelines[2] = {(VkPipeline)(uintptr_t)7, (VkPipeline)(uintptr_t)7};
    char data[16];
    REFUSED(cpu_CreateRayTracingPipelinesNV(DEVICE, VK_NULL_HANDLE, 2, NULL, NULL, pipelines));
    assert_true(pipelines[0] == VK_NULL_HANDLE && pipelines[1] == VK_NULL_HANDLE);
    assert_string_equal(refused_command, "vkCreateRayTracingPipelinesNV");
    REFUSED(cpu_CompileDeferredNV(DEVICE, VK_NULL_HANDLE, 0));
    REFUSED(
        cpu_GetRayTracingShaderGroupHandlesNV(DEVICE, VK_NULL_HANDLE, 0, 1, sizeof(data), data));
    cpu_CmdTraceRaysNV((VkCommandBuffer)DEVICE, VK_NULL_HANDLE, 0, VK_NULL_HANDLE, 0, 0,
                       VK_NULL_HANDLE, 0, 0, VK_NULL_HANDLE, 0, 0, 1, 1, 1);
    assert_string_equal(refused_command, "vkCmdTraceRaysNV");
    assert_int_equal(refusals, 4);
    assert_int_equal(calls, 0);
}
