/* SPDX-License-Identifier: Apache-2.0 */
/* What the driver sees of buffers' usage, descriptors and shaders. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "../report/scarce_memory.h"
#include "below.h"
#include "cpu/commands.h"

#pragma GCC diagnostic ignored "-Wunused-parameter"

enum {
    STORAGE = VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_STORAGE_BIT_KHR,
    INPUT = VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR,
    ADDRESS = VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT,
    VERTEX = VK_BUFFER_USAGE_VERTEX_BUFFER_BIT,
    COPIES = VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT,
};

#define STRUCTURE VK_DESCRIPTOR_TYPE_ACCELERATION_STRUCTURE_KHR
#define OTHER VK_DESCRIPTOR_TYPE_STORAGE_BUFFER

/* ---- the driver */

static struct {
    unsigned calls, writes, copies;
    VkBufferUsageFlags usage;
    VkBufferUsageFlags2 usage2; /* of a structure in the chain */
    uint32_t bindings[8];       /* written */
} seen;

static int clear(void **state)
{
    (void)state;
    memset(&seen, 0, sizeof(seen));
    refusals = 0;
    refused_command = "";
    return 0;
}

static void see_usage(VkBufferUsageFlags usage, const void *chain)
{
    seen.calls++;
    seen.usage = usage;
    seen.usage2 = 0;
    for (const VkBaseInStructure *in = chain; in; in = in->pNext)
        if (in->sType == VK_STRUCTURE_TYPE_BUFFER_USAGE_FLAGS_2_CREATE_INFO)
            seen.usage2 = ((const VkBufferUsageFlags2CreateInfo *)in)->usage;
}

static VKAPI_ATTR VkResult VKAPI_CALL create_buffer(VkDevice device, const VkBufferCreateInfo *info,
                                                    const VkAllocationCallbacks *allocator,
                                                    VkBuffer *buffer)
{
    see_usage(info->usage, info->pNext);
    return VK_SUCCESS;
}

static VKAPI_ATTR void VKAPI_CALL get_requirements(VkDevice device,
                                                   const VkDeviceBufferMemoryRequirements *info,
                                                   VkMemoryRequirements2 *requirements)
{
    see_usage(info->pCreateInfo->usage, info->pCreateInfo->pNext);
}

static VKAPI_ATTR void VKAPI_CALL get_external(VkPhysicalDevice device,
                                               const VkPhysicalDeviceExternalBufferInfo *info,
                                               VkExternalBufferProperties *properties)
{
    see_usage(info->usage, info->pNext);
}

static VKAPI_ATTR VkResult VKAPI_CALL create_layout(VkDevice device,
                                                    const VkDescriptorSetLayoutCreateInfo *info,
                                                    const VkAllocationCallbacks *allocator,
                                                    VkDescriptorSetLayout *layout)
{
    seen.calls++;
    return VK_SUCCESS;
}

static VKAPI_ATTR void VKAPI_CALL get_support(VkDevice device,
                                              const VkDescriptorSetLayoutCreateInfo *info,
                                              VkDescriptorSetLayoutSupport *support)
{
    support->supported = VK_TRUE;
}

static VKAPI_ATTR VkResult VKAPI_CALL create_pool(VkDevice device,
                                                  const VkDescriptorPoolCreateInfo *info,
                                                  const VkAllocationCallbacks *allocator,
                                                  VkDescriptorPool *pool)
{
    seen.calls++;
    return VK_SUCCESS;
}

static VKAPI_ATTR VkResult VKAPI_CALL
create_template(VkDevice device, const VkDescriptorUpdateTemplateCreateInfo *info,
                const VkAllocationCallbacks *allocator, VkDescriptorUpdateTemplate *template)
{
    seen.calls++;
    return VK_SUCCESS;
}

static void see_writes(uint32_t count, const VkWriteDescriptorSet *writes)
{
    seen.calls++;
    for (uint32_t i = 0; i < count; i++)
        seen.bindings[seen.writes++] = writes[i].dstBinding;
}

static VKAPI_ATTR void VKAPI_CALL update_sets(VkDevice device, uint32_t count,
                                              const VkWriteDescriptorSet *writes,
                                              uint32_t copy_count,
                                              const VkCopyDescriptorSet *copies)
{
    see_writes(count, writes);
    seen.copies += copy_count;
}

static VKAPI_ATTR void VKAPI_CALL push(VkCommandBuffer command_buffer, VkPipelineBindPoint point,
                                       VkPipelineLayout layout, uint32_t set, uint32_t count,
                                       const VkWriteDescriptorSet *writes)
{
    assert_int_equal(set, 5);
    see_writes(count, writes);
}

static VKAPI_ATTR void VKAPI_CALL push2(VkCommandBuffer command_buffer,
                                        const VkPushDescriptorSetInfo *info)
{
    assert_int_equal(info->set, 5);
    see_writes(info->descriptorWriteCount, info->pDescriptorWrites);
}

static VKAPI_ATTR void VKAPI_CALL get_descriptor(VkDevice device,
                                                 const VkDescriptorGetInfoEXT *info, size_t size,
                                                 void *data)
{
    seen.calls++;
}

static VKAPI_ATTR VkResult VKAPI_CALL create_module(VkDevice device,
                                                    const VkShaderModuleCreateInfo *info,
                                                    const VkAllocationCallbacks *allocator,
                                                    VkShaderModule *module)
{
    seen.calls++;
    return VK_SUCCESS;
}

static VKAPI_ATTR VkResult VKAPI_CALL create_shaders(VkDevice device, uint32_t count,
                                                     const VkShaderCreateInfoEXT *infos,
                                                     const VkAllocationCallbacks *allocator,
                                                     VkShaderEXT *shaders)
{
    seen.calls++;
    return VK_SUCCESS;
}

static VKAPI_ATTR VkResult VKAPI_CALL create_compute(VkDevice device, VkPipelineCache cache,
                                                     uint32_t count,
                                                     const VkComputePipelineCreateInfo *infos,
                                                     const VkAllocationCallbacks *allocator,
                                                     VkPipeline *pipelines)
{
    seen.calls++;
    return VK_SUCCESS;
}

static VKAPI_ATTR VkResult VKAPI_CALL create_graphics(VkDevice device, VkPipelineCache cache,
                                                      uint32_t count,
                                                      const VkGraphicsPipelineCreateInfo *infos,
                                                      const VkAllocationCallbacks *allocator,
                                                      VkPipeline *pipelines)
{
    seen.calls++;
    return VK_SUCCESS;
}

/* ---- buffers */

static VkBufferUsageFlags create(VkBufferUsageFlags usage, const void *chain)
{
    const VkBufferCreateInfo info = {.pNext = chain, .usage = usage};
    VkBuffer buffer;
    assert_int_equal(cpu_CreateBuffer(DEVICE, &info, NULL, &buffer), VK_SUCCESS);
    return seen.usage;
}

static void test_usage(void **state)
{
    (void)state;
    assert_int_equal(create(VERTEX, NULL), VERTEX);
    assert_int_equal(create(STORAGE, NULL), COPIES);
    assert_int_equal(create(INPUT | VERTEX | ADDRESS, NULL), VERTEX | ADDRESS | COPIES);
    assert_int_equal(create(ADDRESS, NULL), ADDRESS | COPIES);
    assert_int_equal(create(VK_BUFFER_USAGE_SHADER_BINDING_TABLE_BIT_KHR, NULL), COPIES);
}

static void test_usage_in_the_chain(void **state)
{
    (void)state;
    const VkExternalMemoryBufferCreateInfo last = {
        .sType = VK_STRUCTURE_TYPE_EXTERNAL_MEMORY_BUFFER_CREATE_INFO};
    const VkBufferUsageFlags2CreateInfo flags2 = {
        .sType = VK_STRUCTURE_TYPE_BUFFER_USAGE_FLAGS_2_CREATE_INFO,
        .pNext = &last,
        .usage = STORAGE | VK_BUFFER_USAGE_2_PREPROCESS_BUFFER_BIT_EXT};
    const VkBufferOpaqueCaptureAddressCreateInfo first = {
        .sType = VK_STRUCTURE_TYPE_BUFFER_OPAQUE_CAPTURE_ADDRESS_CREATE_INFO, .pNext = &flags2};
    const VkBufferCreateInfo info = {.pNext = &first};
    VkBuffer buffer;
    for (int failing = 0;; failing++) {
        memory_fail_after(failing);
        const VkResult result = cpu_CreateBuffer(DEVICE, &info, NULL, &buffer);
        const bool failed = memory_fail_no_more();
        assert_int_equal(result, failed ? VK_ERROR_OUT_OF_HOST_MEMORY : VK_SUCCESS);
        if (!failed)
            break;
    }
    assert_int_equal(seen.calls, 1);
    assert_int_equal(seen.usage2, VK_BUFFER_USAGE_2_PREPROCESS_BUFFER_BIT_EXT | COPIES);
    assert_int_equal(flags2.usage, STORAGE | VK_BUFFER_USAGE_2_PREPROCESS_BUFFER_BIT_EXT);

    const VkDeviceBufferMemoryRequirements asked = {.pCreateInfo = &info};
    VkMemoryRequirements2 requirements;
    cpu_GetDeviceBufferMemoryRequirements(DEVICE, &asked, &requirements);
    assert_int_equal(seen.usage2, VK_BUFFER_USAGE_2_PREPROCESS_BUFFER_BIT_EXT | COPIES);

    const VkPhysicalDeviceExternalBufferInfo external = {.pNext = &flags2, .usage = STORAGE};
    VkExternalBufferProperties properties;
    layer_find_instance(NULL)->next.GetPhysicalDeviceExternalBufferProperties = get_external;
    cpu_GetPhysicalDeviceExternalBufferProperties(VK_NULL_HANDLE, &external, &properties);
    assert_int_equal(seen.usage, COPIES);
    assert_int_equal(seen.usage2, VK_BUFFER_USAGE_2_PREPROCESS_BUFFER_BIT_EXT | COPIES);
}

/* ---- descriptors */

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

static void test_layouts(void **state)
{
    (void)state;
    static const VkDescriptorType types[] = {OTHER, STRUCTURE};
    const VkMutableDescriptorTypeListEXT list = {2, types};
    const VkMutableDescriptorTypeCreateInfoEXT mutable = {
        .sType = VK_STRUCTURE_TYPE_MUTABLE_DESCRIPTOR_TYPE_CREATE_INFO_EXT,
        .mutableDescriptorTypeListCount = 1,
        .pMutableDescriptorTypeLists = &list};
    assert_int_equal(try_layout(OTHER, NULL), VK_SUCCESS);
    assert_int_equal(refusals, 0);
    assert_int_equal(try_layout(STRUCTURE, NULL), VK_ERROR_VALIDATION_FAILED_EXT);
    assert_int_equal(refusals, 1);
    assert_string_equal(refused_command, "vkCreateDescriptorSetLayout");
    assert_int_equal(try_layout(VK_DESCRIPTOR_TYPE_MUTABLE_EXT, &mutable),
                     VK_ERROR_VALIDATION_FAILED_EXT);
    assert_int_equal(seen.calls, 1);
}

static void test_pools_and_templates(void **state)
{
    (void)state;
    VkDescriptorPoolSize size = {OTHER, 1};
    const VkDescriptorPoolCreateInfo info = {.poolSizeCount = 1, .pPoolSizes = &size};
    VkDescriptorUpdateTemplateEntry entry = {.descriptorType = OTHER};
    const VkDescriptorUpdateTemplateCreateInfo template_info = {.descriptorUpdateEntryCount = 1,
                                                                .pDescriptorUpdateEntries = &entry};
    VkDescriptorPool pool;
    VkDescriptorUpdateTemplate template;
    assert_int_equal(cpu_CreateDescriptorPool(DEVICE, &info, NULL, &pool), VK_SUCCESS);
    assert_int_equal(cpu_CreateDescriptorUpdateTemplate(DEVICE, &template_info, NULL, &template),
                     VK_SUCCESS);
    size.type = STRUCTURE;
    entry.descriptorType = STRUCTURE;
    assert_int_equal(cpu_CreateDescriptorPool(DEVICE, &info, NULL, &pool),
                     VK_ERROR_VALIDATION_FAILED_EXT);
    assert_int_equal(cpu_CreateDescriptorUpdateTemplate(DEVICE, &template_info, NULL, &template),
                     VK_ERROR_VALIDATION_FAILED_EXT);
    assert_int_equal(refusals, 2);
    assert_int_equal(seen.calls, 2);
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
        clear(NULL);
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
            assert_int_equal(seen.calls, 1);
    }
}

static void test_writes(void **state)
{
    (void)state;
    for (unsigned structures = 0; structures < 16; structures++)
        check_writes(structures);
}

static void test_descriptors_in_memory(void **state)
{
    (void)state;
    VkDescriptorGetInfoEXT info = {.type = OTHER};
    char data[16];
    cpu_GetDescriptorEXT(DEVICE, &info, sizeof(data), data);
    assert_int_equal(seen.calls, 1);
    info.type = STRUCTURE;
    cpu_GetDescriptorEXT(DEVICE, &info, sizeof(data), data);
    assert_int_equal(seen.calls, 1);
    assert_string_equal(refused_command, "vkGetDescriptorEXT");
    assert_int_equal(cpu_GetAccelerationStructureOpaqueCaptureDescriptorDataEXT(DEVICE, NULL, data),
                     VK_ERROR_VALIDATION_FAILED_EXT);
    assert_int_equal(refusals, 2);
}

/* ---- shaders */

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
    const VkShaderModuleCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO, .codeSize = size, .pCode = code};
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
    assert_int_equal(cpu_CreateShadersEXT(DEVICE, 1, shaders, NULL, made), VK_SUCCESS);
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

static void test_shaders(void **state)
{
    (void)state;
    assert_int_equal(try_code(plain, sizeof(plain)), VK_SUCCESS);
    assert_int_equal(try_code(behind, sizeof(behind)), VK_SUCCESS);
    assert_int_equal(try_code(plain, 8), VK_SUCCESS);
    assert_int_equal(try_code(with_queries, sizeof(with_queries) - 20), VK_SUCCESS); /* cut off */
    assert_int_equal(refusals, 0);
    assert_int_equal(seen.calls, 20);
    assert_int_equal(try_code(with_queries, sizeof(with_queries)), VK_ERROR_VALIDATION_FAILED_EXT);
    assert_int_equal(refusals, 4);
    assert_int_equal(try_code(with_pipelines, sizeof(with_pipelines)),
                     VK_ERROR_VALIDATION_FAILED_EXT);
    assert_int_equal(refusals, 8);
    assert_int_equal(seen.calls, 22);
}

static void test_pipelines_of_nv(void **state)
{
    (void)state;
    VkPipeline pipelines[2] = {(VkPipeline)(uintptr_t)7, (VkPipeline)(uintptr_t)7};
    char data[16];
    assert_int_equal(
        cpu_CreateRayTracingPipelinesNV(DEVICE, VK_NULL_HANDLE, 2, NULL, NULL, pipelines),
        VK_ERROR_VALIDATION_FAILED_EXT);
    assert_true(pipelines[0] == VK_NULL_HANDLE && pipelines[1] == VK_NULL_HANDLE);
    assert_string_equal(refused_command, "vkCreateRayTracingPipelinesNV");
    assert_int_equal(cpu_CompileDeferredNV(DEVICE, VK_NULL_HANDLE, 0),
                     VK_ERROR_VALIDATION_FAILED_EXT);
    assert_int_equal(
        cpu_GetRayTracingShaderGroupHandlesNV(DEVICE, VK_NULL_HANDLE, 0, 1, sizeof(data), data),
        VK_ERROR_VALIDATION_FAILED_EXT);
    cpu_CmdTraceRaysNV((VkCommandBuffer)DEVICE, VK_NULL_HANDLE, 0, VK_NULL_HANDLE, 0, 0,
                       VK_NULL_HANDLE, 0, 0, VK_NULL_HANDLE, 0, 0, 1, 1, 1);
    assert_string_equal(refused_command, "vkCmdTraceRaysNV");
    assert_int_equal(refusals, 4);
    assert_int_equal(seen.calls, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(test_usage, clear),
        cmocka_unit_test_setup(test_usage_in_the_chain, clear),
        cmocka_unit_test_setup(test_layouts, clear),
        cmocka_unit_test_setup(test_pools_and_templates, clear),
        cmocka_unit_test_setup(test_writes, clear),
        cmocka_unit_test_setup(test_descriptors_in_memory, clear),
        cmocka_unit_test_setup(test_shaders, clear),
        cmocka_unit_test_setup(test_pipelines_of_nv, clear),
    };
    VkuDeviceDispatchTable *next = &below->next;
    next->CreateBuffer = create_buffer;
    next->GetDeviceBufferMemoryRequirements = get_requirements;
    next->CreateDescriptorSetLayout = create_layout;
    next->GetDescriptorSetLayoutSupport = get_support;
    next->CreateDescriptorPool = create_pool;
    next->CreateDescriptorUpdateTemplate = create_template;
    next->UpdateDescriptorSets = update_sets;
    next->CmdPushDescriptorSet = push;
    next->CmdPushDescriptorSet2 = push2;
    next->GetDescriptorEXT = get_descriptor;
    next->CreateShaderModule = create_module;
    next->CreateShadersEXT = create_shaders;
    next->CreateComputePipelines = create_compute;
    next->CreateGraphicsPipelines = create_graphics;
    return cmocka_run_group_tests(tests, NULL, NULL);
}
