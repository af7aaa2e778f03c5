/* SPDX-License-Identifier: Apache-2.0 */
/* What the driver sees of descriptors and shaders, of which those of structures and those that
 * trace rays are refused. */
#include <string.h>

#include "backend.h"
#include "below.h"
#include "tests/fixture/objects.h"
#include "tests/unit/unit_test.h"

#define STRUCTURE VK_DESCRIPTOR_TYPE_ACCELERATION_STRUCTURE_KHR
#define OTHER VK_DESCRIPTOR_TYPE_STORAGE_BUFFER

/* ---- the driver */

static struct {
    unsigned writes, copies;
    uint32_t bindings[8]; /* written */
} seen;

COUNTED(CreateDescriptorSetLayout)
COUNTED(CreateDescriptorPool)
COUNTED(CreateDescriptorUpdateTemplate)

PLAYED(GetDescriptorSetLayoutSupport)
{
    pSupport->supported = VK_TRUE;
}

static void see_writes(uint32_t count, const VkWriteDescriptorSet *writes)
{
    calls++;
    for (uint32_t i = 0; i < count; i++)
        seen.bindings[seen.writes++] = writes[i].dstBinding;
}

PLAYED(UpdateDescriptorSets)
{
    see_writes(descriptorWriteCount, pDescriptorWrites);
    seen.copies += descriptorCopyCount;
}

PLAYED(CmdPushDescriptorSet)
{
    assert_int_equal(set, 5);
    see_writes(descriptorWriteCount, pDescriptorWrites);
}

PLAYED(CmdPushDescriptorSet2)
{
    assert_int_equal(pPushDescriptorSetInfo->set, 5);
    see_writes(pPushDescriptorSetInfo->descriptorWriteCount,
               pPushDescriptorSetInfo->pDescriptorWrites);
}

PLAYED(GetDescriptorEXT)
{
    calls++;
}

static void clear(void)
{
    memset(&seen, 0, sizeof(seen));
    below_clear();
}

/* ---- tests */

static VkResult try_layout(VkDescriptorType type, const void *chain)
{
    const VkDescriptorSetLayoutBinding bindings[] = {{.descriptorType = OTHER},
                                                     {.descriptorType = type}};
    const VkDescriptorSetLayoutCreateInfo info = {
        .pNext = chain, .bindingCount = 2, .pBindings = bindings};
    VkDescriptorSetLayoutSupport support;
    VkDescriptorSetLayout layout;
    const unsigned before = refusals;
    cpu_GetDescriptorSetLayoutSupport(DEVICE, &info, &support);
    assert_int_equal(refusals, before);
    const VkResult result = cpu_CreateDescriptorSetLayout(DEVICE, &info, NULL, &layout);
    assert_int_equal(support.supported, result == VK_SUCCESS);
    return result;
}

TEST_OPENED(test_layouts, clear)
{
    static const VkDescriptorType types[] = {OTHER, STRUCTURE};
    const VkMutableDescriptorTypeListEXT list = {2, types};
    const STRUCT(VkMutableDescriptorTypeCreateInfoEXT, mutable, .mutableDescriptorTypeListCount = 1,
                 .pMutableDescriptorTypeLists = &list);
    GET(try_layout(OTHER, NULL));
    assert_int_equal(refusals, 0);
    REFUSED(try_layout(STRUCTURE, NULL));
    assert_int_equal(refusals, 1);
    assert_string_equal(refused_command, "vkCreateDescriptorSetLayout");
    REFUSED(try_layout(VK_DESCRIPTOR_TYPE_MUTABLE_EXT, &mutable));
    assert_int_equal(calls, 1);
}

TEST_OPENED(test_pools_and_templates, clear)
{
    VkDescriptorPoolSize size = {OTHER, 1};
    const VkDescriptorPoolCreateInfo info = {.poolSizeCount = 1, .pPoolSizes = &size};
    VkDescriptorUpdateTemplateEntry entry = {.descriptorType = OTHER};
    const VkDescriptorUpdateTemplateCreateInfo template_info = {.descriptorUpdateEntryCount = 1,
                                                                .pDescriptorUpdateEntries = &entry};
    VkDescriptorPool pool;
    VkDescriptorUpdateTemplate template;
    GET(cpu_CreateDescriptorPool(DEVICE, &info, NULL, &pool));
    GET(cpu_CreateDescriptorUpdateTemplate(DEVICE, &template_info, NULL, &template));
    size.type = STRUCTURE;
    entry.descriptorType = STRUCTURE;
    REFUSED(cpu_CreateDescriptorPool(DEVICE, &info, NULL, &pool));
    REFUSED(cpu_CreateDescriptorUpdateTemplate(DEVICE, &template_info, NULL, &template));
    assert_int_equal(refusals, 2);
    assert_int_equal(calls, 2);
}

/* What the four bits of `structures` name are structures; the rest has to arrive, in order. */
static void check_writes(unsigned structures)
{
    VkWriteDescriptorSet writes[4];
    uint32_t expected[4], count = 0;
    for (uint32_t i = 0; i < 4; i++) {
        writes[i] = (VkWriteDescriptorSet){
            .dstBinding = i, .descriptorType = structures >> i & 1 ? STRUCTURE : OTHER};
        if (!(structures >> i & 1))
            expected[count++] = i;
    }
    const VkCopyDescriptorSet copy = {.dstBinding = 9};
    const VkPushDescriptorSetInfo info = {
        .set = 5, .descriptorWriteCount = 4, .pDescriptorWrites = writes};
    for (int command = 0; command < 3; command++) {
        clear();
        if (command == 0)
            cpu_UpdateDescriptorSets(DEVICE, 4, writes, 1, &copy);
        else if (command == 1)
            cpu_CmdPushDescriptorSet(COMMAND_BUFFER, VK_PIPELINE_BIND_POINT_COMPUTE, VK_NULL_HANDLE,
                                     5, 4, writes);
        else
            cpu_CmdPushDescriptorSet2(COMMAND_BUFFER, &info);
        assert_int_equal(refusals, structures != 0);
        assert_int_equal(seen.writes, count);
        assert_memory_equal(seen.bindings, expected, count * sizeof(*expected));
        assert_int_equal(seen.copies, command == 0);
        if (!structures)
            assert_int_equal(calls, 1);
    }
}

TEST_OPENED(test_writes, clear)
{
    for (unsigned structures = 0; structures < 16; structures++)
        check_writes(structures);
}

TEST_OPENED(test_descriptors_in_memory, clear)
{
    VkDescriptorGetInfoEXT info = {.type = OTHER};
    char data[16];
    cpu_GetDescriptorEXT(DEVICE, &info, sizeof(data), data);
    assert_int_equal(calls, 1);
    info.type = STRUCTURE;
    cpu_GetDescriptorEXT(DEVICE, &info, sizeof(data), data);
    assert_int_equal(calls, 1);
    assert_string_equal(refused_command, "vkGetDescriptorEXT");
    REFUSED(cpu_GetAccelerationStructureOpaqueCaptureDescriptorDataEXT(DEVICE, NULL, data));
    assert_int_equal(refusals, 2);
}

/* ---- shaders */

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
