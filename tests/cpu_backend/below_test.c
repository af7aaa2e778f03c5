/* SPDX-License-Identifier: Apache-2.0 */
/* What the driver sees of descriptors and shaders, of which those of structures and those that
 * trace rays are refused, and of buffers' usage: commands of backend cpu are called directly, and
 * their next layer is the test. tests/programs/backend/masks.cases has the stages and accesses. */
#include <string.h>

#include "backend.h"
#include "layer/cpu/overlay.h"
#include "tests/fixture/make.h"
#include "tests/fixture/objects.h"
#include "tests/fixture/scarce_memory.h"
#include "tests/unit/unit_test.h"
#include "vulkan_commands.h"

/* ---- the device, in place of the registry and of the reporter */

static struct cpu_overlay overlay;
static struct layer_instance own_instance;
static struct layer_device own_device = {.instance = &own_instance, .cpu = &overlay};
/* The last command that cpu_report_unsupported() got, and the number of calls. */
static const char *refused_command;
static unsigned calls, refusals;

static void below_clear(void)
{
    calls = refusals = 0;
    refused_command = "";
}

struct layer_device *layer_find_device(const void *dispatchable)
{
    return &own_device;
}

struct layer_device *layer_find_recording_device(VkCommandBuffer handle)
{
    return &own_device;
}

struct layer_instance *layer_find_instance(const void *dispatchable)
{
    return &own_instance;
}

bool cpu_advertises(struct layer_instance *of, VkPhysicalDevice physical_device)
{
    return true;
}

void cpu_report_unsupported(const struct layer_instance *of_instance, const char *command,
                            const char *what)
{
    refused_command = command;
    refusals++;
}

#define PLAYED_COMMANDS overlay.down

/* One that is only counted, and succeeds. */
#define COUNTED(name)                                                                              \
    PLAYED(name)                                                                                   \
    {                                                                                              \
        calls++;                                                                                   \
        return VK_SUCCESS;                                                                         \
    }

/* Any dispatchable handle of the device. */
#define DEVICE ((VkDevice)(uintptr_t)1)
#define COMMAND_BUFFER ((VkCommandBuffer)(uintptr_t)3)

enum { MANY = 500 }; /* more than fit on the stack */

/* A call that the backend refuses. */
#define REFUSED(call) assert_int_equal(call, VK_ERROR_VALIDATION_FAILED_EXT)

#define STRUCTURE VK_DESCRIPTOR_TYPE_ACCELERATION_STRUCTURE_KHR
#define OTHER VK_DESCRIPTOR_TYPE_STORAGE_BUFFER

/* ---- descriptors: the driver */

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

static void clear_descriptors(void)
{
    memset(&seen, 0, sizeof(seen));
    below_clear();
}

/* ---- descriptors: tests */

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

TEST_OPENED(test_layouts, clear_descriptors)
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

TEST_OPENED(test_pools_and_templates, clear_descriptors)
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
        clear_descriptors();
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

TEST_OPENED(test_writes, clear_descriptors)
{
    for (unsigned structures = 0; structures < 16; structures++)
        check_writes(structures);
}

TEST_OPENED(test_descriptors_in_memory, clear_descriptors)
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

/* ---- shaders: the driver */

COUNTED(CreateShaderModule)
COUNTED(CreateShadersEXT)
COUNTED(CreateComputePipelines)
COUNTED(CreateGraphicsPipelines)

/* ---- shaders: tests */

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

/* ---- usage */

enum {
    STORAGE = VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_STORAGE_BIT_KHR,
    BUILD_INPUT = VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR,
    ADDRESS = VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT,
    VERTEX = VK_BUFFER_USAGE_VERTEX_BUFFER_BIT,
    COPIES = VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT,
};

/* ---- usage: the driver */

static struct {
    VkBufferUsageFlags usage;
    VkBufferUsageFlags2 usage2; /* of a structure in the chain */
    const void *array;          /* only to compare */
    struct {
        VkBufferUsageFlags usage;
        VkBufferUsageFlags2 usage2;
    } bound[MANY];
} used;

static void see_usage(VkBufferUsageFlags usage, const void *chain)
{
    calls++;
    used.usage = usage;
    used.usage2 = 0;
    for (const VkBaseInStructure *in = chain; in; in = in->pNext)
        if (in->sType == VK_STRUCTURE_TYPE_BUFFER_USAGE_FLAGS_2_CREATE_INFO)
            used.usage2 = ((const VkBufferUsageFlags2CreateInfo *)in)->usage;
}

PLAYED(CreateBuffer)
{
    see_usage(pCreateInfo->usage, pCreateInfo->pNext);
    return VK_SUCCESS;
}

PLAYED(GetDeviceBufferMemoryRequirements)
{
    see_usage(pInfo->pCreateInfo->usage, pInfo->pCreateInfo->pNext);
}

static VKAPI_ATTR void VKAPI_CALL get_external(VkPhysicalDevice device,
                                               const VkPhysicalDeviceExternalBufferInfo *info,
                                               VkExternalBufferProperties *properties)
{
    see_usage(info->usage, info->pNext);
}

PLAYED(CmdBindDescriptorBuffersEXT)
{
    used.array = pBindingInfos;
    for (uint32_t i = 0; i < bufferCount; i++) {
        see_usage(pBindingInfos[i].usage, pBindingInfos[i].pNext);
        used.bound[i].usage = used.usage;
        used.bound[i].usage2 = used.usage2;
    }
}

static void clear_usage(void)
{
    memset(&used, 0, sizeof(used));
    below_clear();
}

/* ---- usage: tests */

static VkBufferUsageFlags create(VkBufferUsageFlags usage, const void *chain)
{
    const VkBufferCreateInfo info = {.pNext = chain, .usage = usage};
    VkBuffer buffer;
    GET(cpu_CreateBuffer(DEVICE, &info, NULL, &buffer));
    return used.usage;
}

TEST_OPENED(test_usage, clear_usage)
{
    assert_int_equal(create(VERTEX, NULL), VERTEX);
    assert_int_equal(create(STORAGE, NULL), COPIES);
    assert_int_equal(create(BUILD_INPUT | VERTEX | ADDRESS, NULL), VERTEX | ADDRESS | COPIES);
    assert_int_equal(create(ADDRESS, NULL), ADDRESS | COPIES);
    assert_int_equal(create(VK_BUFFER_USAGE_SHADER_BINDING_TABLE_BIT_KHR, NULL), COPIES);
}

TEST_OPENED(test_usage_in_the_chain, clear_usage)
{
    const STRUCT(VkExternalMemoryBufferCreateInfo, last);
    const STRUCT(VkBufferUsageFlags2CreateInfo, flags2, .pNext = &last,
                 .usage = STORAGE | VK_BUFFER_USAGE_2_PREPROCESS_BUFFER_BIT_EXT);
    const STRUCT(VkBufferOpaqueCaptureAddressCreateInfo, first, .pNext = &flags2);
    const VkBufferCreateInfo info = {.pNext = &first};
    VkBuffer buffer;
    VkResult result = VK_ERROR_OUT_OF_HOST_MEMORY;
    for (int failing = 0; result != VK_SUCCESS; failing++) {
        memory_fail_after(failing);
        result = cpu_CreateBuffer(DEVICE, &info, NULL, &buffer);
        assert_int_equal(result, memory_fail_no_more() ? VK_ERROR_OUT_OF_HOST_MEMORY : VK_SUCCESS);
    }
    assert_int_equal(calls, 1);
    assert_int_equal(used.usage2, VK_BUFFER_USAGE_2_PREPROCESS_BUFFER_BIT_EXT | COPIES);
    assert_int_equal(flags2.usage, STORAGE | VK_BUFFER_USAGE_2_PREPROCESS_BUFFER_BIT_EXT);

    const VkDeviceBufferMemoryRequirements asked = {.pCreateInfo = &info};
    VkMemoryRequirements2 requirements;
    cpu_GetDeviceBufferMemoryRequirements(DEVICE, &asked, &requirements);
    assert_int_equal(used.usage2, VK_BUFFER_USAGE_2_PREPROCESS_BUFFER_BIT_EXT | COPIES);

    const VkPhysicalDeviceExternalBufferInfo external = {.pNext = &flags2, .usage = STORAGE};
    VkExternalBufferProperties properties;
    layer_find_instance(NULL)->down.GetPhysicalDeviceExternalBufferProperties = get_external;
    cpu_GetPhysicalDeviceExternalBufferProperties(VK_NULL_HANDLE, &external, &properties);
    assert_int_equal(used.usage, COPIES);
    assert_int_equal(used.usage2, VK_BUFFER_USAGE_2_PREPROCESS_BUFFER_BIT_EXT | COPIES);
}

/* The usage that the driver knows the buffer by. */
TEST_OPENED(test_descriptor_buffers, clear_usage)
{
    enum { SAMPLERS = VK_BUFFER_USAGE_SAMPLER_DESCRIPTOR_BUFFER_BIT_EXT };
    const STRUCT(VkBufferUsageFlags2CreateInfo, flags2, .usage = SAMPLERS | STORAGE | ADDRESS);
    static VkDescriptorBufferBindingInfoEXT infos[MANY];
    infos[0].usage = SAMPLERS;
    infos[1].usage = SAMPLERS | BUILD_INPUT | ADDRESS;
    infos[MANY - 1].pNext = infos[2].pNext = &flags2;
    cpu_CmdBindDescriptorBuffersEXT(COMMAND_BUFFER, 3, infos);
    assert_int_equal(calls, 3);
    assert_int_equal(used.bound[0].usage, SAMPLERS);
    assert_int_equal(used.bound[1].usage, SAMPLERS | ADDRESS | COPIES);
    assert_int_equal(used.bound[2].usage2, SAMPLERS | ADDRESS | COPIES);
    assert_int_equal(infos[1].usage, SAMPLERS | BUILD_INPUT | ADDRESS);

    cpu_CmdBindDescriptorBuffersEXT(COMMAND_BUFFER, MANY, infos);
    assert_int_equal(used.bound[MANY - 1].usage2, SAMPLERS | ADDRESS | COPIES);
    memory_fail_after(0);
    cpu_CmdBindDescriptorBuffersEXT(COMMAND_BUFFER, MANY, infos);
    assert_true(memory_fail_no_more());
    assert_ptr_equal(used.array, infos);
}
