/* SPDX-License-Identifier: Apache-2.0 */
/* What the driver sees of descriptors, of which those of structures are refused. */
#include <string.h>

#include "below.h"
#include "layer/cpu/commands.h"
#include "tests/cpu_backend/test_between.h"
#include "tests/fixture/objects.h"

#define STRUCTURE VK_DESCRIPTOR_TYPE_ACCELERATION_STRUCTURE_KHR
#define OTHER VK_DESCRIPTOR_TYPE_STORAGE_BUFFER

/* ---- the driver */

static struct {
    unsigned calls, writes, copies;
    uint32_t bindings[8]; /* written */
} seen;

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

static void open_driver(void)
{
    VkuDeviceDispatchTable *next = &below->next;
    next->CreateDescriptorSetLayout = create_layout;
    next->GetDescriptorSetLayoutSupport = get_support;
    next->CreateDescriptorPool = create_pool;
    next->CreateDescriptorUpdateTemplate = create_template;
    next->UpdateDescriptorSets = update_sets;
    next->CmdPushDescriptorSet = push;
    next->CmdPushDescriptorSet2 = push2;
    next->GetDescriptorEXT = get_descriptor;
    memset(&seen, 0, sizeof(seen));
    refusals = 0;
    refused_command = "";
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

TEST_OPENED(test_layouts, open_driver)
{
    static const VkDescriptorType types[] = {OTHER, STRUCTURE};
    const VkMutableDescriptorTypeListEXT list = {2, types};
    const VkMutableDescriptorTypeCreateInfoEXT mutable =
        INFO(MUTABLE_DESCRIPTOR_TYPE_CREATE_INFO_EXT, .mutableDescriptorTypeListCount = 1,
             .pMutableDescriptorTypeLists = &list);
    assert_int_equal(try_layout(OTHER, NULL), VK_SUCCESS);
    assert_int_equal(refusals, 0);
    assert_int_equal(try_layout(STRUCTURE, NULL), VK_ERROR_VALIDATION_FAILED_EXT);
    assert_int_equal(refusals, 1);
    assert_string_equal(refused_command, "vkCreateDescriptorSetLayout");
    assert_int_equal(try_layout(VK_DESCRIPTOR_TYPE_MUTABLE_EXT, &mutable),
                     VK_ERROR_VALIDATION_FAILED_EXT);
    assert_int_equal(seen.calls, 1);
}

TEST_OPENED(test_pools_and_templates, open_driver)
{
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
        open_driver();
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

TEST_OPENED(test_writes, open_driver)
{
    for (unsigned structures = 0; structures < 16; structures++)
        check_writes(structures);
}

TEST_OPENED(test_descriptors_in_memory, open_driver)
{
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
