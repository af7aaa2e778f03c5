/* SPDX-License-Identifier: Apache-2.0 */
/* What the driver sees of buffers' usage. */
#include <string.h>

#include "backend.h"
#include "below.h"
#include "tests/fixture/objects.h"
#include "tests/fixture/scarce_memory.h"
#include "tests/unit/unit_test.h"

enum {
    STORAGE = VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_STORAGE_BIT_KHR,
    BUILD_INPUT = VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR,
    ADDRESS = VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT,
    VERTEX = VK_BUFFER_USAGE_VERTEX_BUFFER_BIT,
    COPIES = VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT,
};

/* ---- the driver */

static struct {
    VkBufferUsageFlags usage;
    VkBufferUsageFlags2 usage2; /* of a structure in the chain */
    const void *array;          /* only to compare */
    struct {
        VkBufferUsageFlags usage;
        VkBufferUsageFlags2 usage2;
    } bound[MANY];
} seen;

static void see_usage(VkBufferUsageFlags usage, const void *chain)
{
    calls++;
    seen.usage = usage;
    seen.usage2 = 0;
    for (const VkBaseInStructure *in = chain; in; in = in->pNext)
        if (in->sType == VK_STRUCTURE_TYPE_BUFFER_USAGE_FLAGS_2_CREATE_INFO)
            seen.usage2 = ((const VkBufferUsageFlags2CreateInfo *)in)->usage;
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
    seen.array = pBindingInfos;
    for (uint32_t i = 0; i < bufferCount; i++) {
        see_usage(pBindingInfos[i].usage, pBindingInfos[i].pNext);
        seen.bound[i].usage = seen.usage;
        seen.bound[i].usage2 = seen.usage2;
    }
}

static void clear(void)
{
    memset(&seen, 0, sizeof(seen));
    below_clear();
}

/* ---- tests */

static VkBufferUsageFlags create(VkBufferUsageFlags usage, const void *chain)
{
    const VkBufferCreateInfo info = {.pNext = chain, .usage = usage};
    VkBuffer buffer;
    GET(cpu_CreateBuffer(DEVICE, &info, NULL, &buffer));
    return seen.usage;
}

TEST_OPENED(test_usage, clear)
{
    assert_int_equal(create(VERTEX, NULL), VERTEX);
    assert_int_equal(create(STORAGE, NULL), COPIES);
    assert_int_equal(create(BUILD_INPUT | VERTEX | ADDRESS, NULL), VERTEX | ADDRESS | COPIES);
    assert_int_equal(create(ADDRESS, NULL), ADDRESS | COPIES);
    assert_int_equal(create(VK_BUFFER_USAGE_SHADER_BINDING_TABLE_BIT_KHR, NULL), COPIES);
}

TEST_OPENED(test_usage_in_the_chain, clear)
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
    assert_int_equal(seen.usage2, VK_BUFFER_USAGE_2_PREPROCESS_BUFFER_BIT_EXT | COPIES);
    assert_int_equal(flags2.usage, STORAGE | VK_BUFFER_USAGE_2_PREPROCESS_BUFFER_BIT_EXT);

    const VkDeviceBufferMemoryRequirements asked = {.pCreateInfo = &info};
    VkMemoryRequirements2 requirements;
    cpu_GetDeviceBufferMemoryRequirements(DEVICE, &asked, &requirements);
    assert_int_equal(seen.usage2, VK_BUFFER_USAGE_2_PREPROCESS_BUFFER_BIT_EXT | COPIES);

    const VkPhysicalDeviceExternalBufferInfo external = {.pNext = &flags2, .usage = STORAGE};
    VkExternalBufferProperties properties;
    layer_find_instance(NULL)->down.GetPhysicalDeviceExternalBufferProperties = get_external;
    cpu_GetPhysicalDeviceExternalBufferProperties(VK_NULL_HANDLE, &external, &properties);
    assert_int_equal(seen.usage, COPIES);
    assert_int_equal(seen.usage2, VK_BUFFER_USAGE_2_PREPROCESS_BUFFER_BIT_EXT | COPIES);
}

/* The usage that the driver knows the buffer by. */
TEST_OPENED(test_descriptor_buffers, clear)
{
    enum { SAMPLERS = VK_BUFFER_USAGE_SAMPLER_DESCRIPTOR_BUFFER_BIT_EXT };
    const STRUCT(VkBufferUsageFlags2CreateInfo, flags2, .usage = SAMPLERS | STORAGE | ADDRESS);
    static VkDescriptorBufferBindingInfoEXT infos[MANY];
    infos[0].usage = SAMPLERS;
    infos[1].usage = SAMPLERS | BUILD_INPUT | ADDRESS;
    infos[MANY - 1].pNext = infos[2].pNext = &flags2;
    cpu_CmdBindDescriptorBuffersEXT(COMMAND_BUFFER, 3, infos);
    assert_int_equal(calls, 3);
    assert_int_equal(seen.bound[0].usage, SAMPLERS);
    assert_int_equal(seen.bound[1].usage, SAMPLERS | ADDRESS | COPIES);
    assert_int_equal(seen.bound[2].usage2, SAMPLERS | ADDRESS | COPIES);
    assert_int_equal(infos[1].usage, SAMPLERS | BUILD_INPUT | ADDRESS);

    cpu_CmdBindDescriptorBuffersEXT(COMMAND_BUFFER, MANY, infos);
    assert_int_equal(seen.bound[MANY - 1].usage2, SAMPLERS | ADDRESS | COPIES);
    memory_fail_after(0);
    cpu_CmdBindDescriptorBuffersEXT(COMMAND_BUFFER, MANY, infos);
    assert_true(memory_fail_no_more());
    assert_ptr_equal(seen.array, infos);
}
