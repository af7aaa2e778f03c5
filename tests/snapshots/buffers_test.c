/* SPDX-License-Identifier: Apache-2.0 */
/* Buffers that could not be copied from by their handles, or must not be read at all: on the null
 * driver, which takes buffers of any kind. */
#include "tests/snapshots/fixture.h"

#include <stdio.h>
#include <string.h>

enum { BUFFER_SIZE = 1 << 16 };

static struct platform platform;
static struct fixture fixture;
static struct fixture_buffer structures, scratch, data; /* whose memory the buffers are bound to */
static VkAccelerationStructureKHR blas;

static int open_fixture(void **state)
{
    const VkAabbPositionsKHR box = {.minX = 1};
    (void)state;
    fixture_open(&fixture, &platform, &(struct fixture_setup){.has_layer = true});
    structures = fixture_buffer(&fixture, BUFFER_SIZE,
                                VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_STORAGE_BIT_KHR);
    scratch = fixture_buffer(&fixture, BUFFER_SIZE, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT);
    data = fixture_buffer(&fixture, BUFFER_SIZE, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT);
    memcpy(data.bytes, &box, sizeof(box));
    blas = fixture_structure(&fixture, &structures, 0, BUFFER_SIZE,
                             VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR);
    return 0;
}

static int close_fixture(void **state)
{
    (void)state;
    fixture.vk.DestroyAccelerationStructureKHR(fixture.device, blas, NULL);
    fixture_destroy_buffer(&fixture, &structures);
    fixture_destroy_buffer(&fixture, &scratch);
    fixture_destroy_buffer(&fixture, &data);
    fixture_close(&fixture);
    return 0;
}

static VkBuffer create(VkBufferCreateFlags flags, const void *next)
{
    const VkBufferCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO,
        .pNext = next,
        .flags = flags,
        .size = BUFFER_SIZE,
        .usage = VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR |
                 VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT,
    };
    VkBuffer buffer;
    GET(fixture.vk.CreateBuffer(fixture.device, &info, NULL, &buffer));
    return buffer;
}

static void bind_sparse(VkBuffer buffer, VkDeviceSize size)
{
    const VkSparseMemoryBind bind = {.size = size, .memory = data.memory};
    const VkSparseBufferMemoryBindInfo binds = {buffer, 1, &bind};
    const VkBindSparseInfo info = {
        .sType = VK_STRUCTURE_TYPE_BIND_SPARSE_INFO, .bufferBindCount = 1, .pBufferBinds = &binds};
    GET(fixture.vk.QueueBindSparse(fixture.queue, 1, &info, VK_NULL_HANDLE));
    GET(fixture.vk.QueueWaitIdle(fixture.queue));
}

static VkDeviceAddress address_of(VkBuffer buffer)
{
    const VkBufferDeviceAddressInfo info = {.sType = VK_STRUCTURE_TYPE_BUFFER_DEVICE_ADDRESS_INFO,
                                            .buffer = buffer};
    return fixture.vk.GetBufferDeviceAddress(fixture.device, &info);
}

static VkCommandBuffer record(VkBuffer buffer, uint32_t count)
{
    VkCommandBuffer commands = fixture_begin(&fixture, 0);
    fixture_build_boxes(&fixture, commands, blas, address_of(buffer), count,
                        (scratch.address + 255) & ~(VkDeviceAddress)255);
    return commands;
}

static void build_boxes(VkBuffer buffer, uint32_t count)
{
    fixture_finish(&fixture, record(buffer, count));
}

/* One message with the text; it is forgotten. */
static void expect_told(const char *text)
{
    if (fixture.messages.count != 1)
        fail_msg("%u messages: %s", fixture.messages.count, fixture.messages.items[0].text);
    if (!strstr(fixture.messages.items[0].text, text))
        fail_msg("\"%s\" is not in: %s", text, fixture.messages.items[0].text);
    messages_clear(&fixture.messages);
}

static void build_on_memory(VkBuffer buffer, const char *text)
{
    GET(fixture.vk.BindBufferMemory(fixture.device, buffer, data.memory, 0));
    build_boxes(buffer, 1);
    expect_told(text);
    fixture.vk.DestroyBuffer(fixture.device, buffer, NULL);
}

/* ---- tests */

static void test_imported(void **state)
{
    const VkExternalMemoryBufferCreateInfo external = {
        .sType = VK_STRUCTURE_TYPE_EXTERNAL_MEMORY_BUFFER_CREATE_INFO,
        .handleTypes = VK_EXTERNAL_MEMORY_HANDLE_TYPE_OPAQUE_FD_BIT,
    };
    (void)state;
    build_on_memory(create(0, &external), "minX");
}

static void test_replayed(void **state)
{
    (void)state;
    build_on_memory(create(VK_BUFFER_CREATE_DEVICE_ADDRESS_CAPTURE_REPLAY_BIT, NULL), "minX");
}

static void test_protected(void **state)
{
    (void)state;
    build_on_memory(create(VK_BUFFER_CREATE_PROTECTED_BIT, NULL), "a buffer that can't be read");
}

/* It has the address by the time of the submission. */
static void test_replaced_by_protected(void **state)
{
    VkBuffer buffer = create(0, NULL);
    (void)state;
    GET(fixture.vk.BindBufferMemory(fixture.device, buffer, data.memory, 0));
    VkCommandBuffer commands = record(buffer, 1);
    VkBuffer other = create(VK_BUFFER_CREATE_PROTECTED_BIT, NULL);
    GET(fixture.vk.BindBufferMemory(fixture.device, other, data.memory, 0));
    assert_int_equal(address_of(other), address_of(buffer));
    fixture.vk.DestroyBuffer(fixture.device, buffer, NULL);
    fixture_finish(&fixture, commands);
    fixture_expect_silence(&fixture);
    fixture.vk.DestroyBuffer(fixture.device, other, NULL);
}

/* All that is copied has to be bound. */
static void test_sparse(void **state)
{
    VkBuffer buffer =
        create(VK_BUFFER_CREATE_SPARSE_BINDING_BIT | VK_BUFFER_CREATE_SPARSE_RESIDENCY_BIT, NULL);
    (void)state;
    bind_sparse(buffer, BUFFER_SIZE);
    build_boxes(buffer, 1);
    expect_told("minX");
    fixture.vk.DestroyBuffer(fixture.device, buffer, NULL);
}

static void test_sparse_with_hole(void **state)
{
    VkBuffer buffer =
        create(VK_BUFFER_CREATE_SPARSE_BINDING_BIT | VK_BUFFER_CREATE_SPARSE_RESIDENCY_BIT, NULL);
    (void)state;
    bind_sparse(buffer, sizeof(VkAabbPositionsKHR));
    build_boxes(buffer, 2);
    assert_int_equal(messages_count(&fixture.messages, "", NULL), 0);
    for (uint32_t i = 0; i < messages_kept(&fixture.messages); i++)
        assert_null(strstr(fixture.messages.items[i].text, "minX"));
    fixture.vk.DestroyBuffer(fixture.device, buffer, NULL);
}

int main(void)
{
    const char *reason = platform_open(&platform, "null");
    if (reason) {
        puts(reason);
        return 77;
    }
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_imported, open_fixture, close_fixture),
        cmocka_unit_test_setup_teardown(test_replayed, open_fixture, close_fixture),
        cmocka_unit_test_setup_teardown(test_protected, open_fixture, close_fixture),
        cmocka_unit_test_setup_teardown(test_replaced_by_protected, open_fixture, close_fixture),
        cmocka_unit_test_setup_teardown(test_sparse, open_fixture, close_fixture),
        cmocka_unit_test_setup_teardown(test_sparse_with_hole, open_fixture, close_fixture),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
