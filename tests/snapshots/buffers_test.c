/* SPDX-License-Identifier: Apache-2.0 */
/* Buffers that could not be copied from by their handles, or must not be read at all: on the null
 * driver, which takes buffers of any kind. */
#include "tests/snapshots/scene.h"

#include <string.h>

enum { BUFFER_SIZE = 1 << 16 };

static struct device_buffer data; /* whose memory the buffers are bound to */

static void open_scene(void)
{
    const VkAabbPositionsKHR box = {.minX = 1};
    SCENE_OPEN(.boxes_size = BUFFER_SIZE, .structure_size = BUFFER_SIZE);
    data = fixture_buffer(&fixture, BUFFER_SIZE, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT);
    memcpy(data.bytes, &box, sizeof(box));
}

static VkBuffer create(VkBufferCreateFlags flags, const void *next)
{
    const STRUCT(VkBufferCreateInfo, info, .pNext = next, .flags = flags, .size = BUFFER_SIZE,
                 .usage = VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR |
                          VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT);
    VkBuffer buffer;
    GET(fixture.vk.CreateBuffer(fixture.device, &info, NULL, &buffer));
    return buffer;
}

static VkBuffer create_sparse(VkDeviceSize bound)
{
    VkBuffer buffer =
        create(VK_BUFFER_CREATE_SPARSE_BINDING_BIT | VK_BUFFER_CREATE_SPARSE_RESIDENCY_BIT, NULL);
    const VkSparseMemoryBind bind = {.size = bound, .memory = data.memory};
    const VkSparseBufferMemoryBindInfo binds = {buffer, 1, &bind};
    const STRUCT(VkBindSparseInfo, info, .bufferBindCount = 1, .pBufferBinds = &binds);
    GET(fixture.vk.QueueBindSparse(fixture.queue, 1, &info, VK_NULL_HANDLE));
    GET(fixture.vk.QueueWaitIdle(fixture.queue));
    return buffer;
}

static VkCommandBuffer record(VkBuffer buffer, uint32_t count)
{
    VkCommandBuffer commands = fixture_begin(&fixture, 0);
    fixture_build_boxes(&fixture, commands, scene.blas,
                        buffer_address(&fixture.vk, fixture.device, buffer), count,
                        scene.scratch_address);
    return commands;
}

static void build_boxes(VkBuffer buffer, uint32_t count)
{
    fixture_finish(&fixture, record(buffer, count));
}

/* A buffer that is not as others, and what the message about its box says. */
static const VkExternalMemoryBufferCreateInfo external = {
    .sType = VK_STRUCTURE_TYPE_EXTERNAL_MEMORY_BUFFER_CREATE_INFO,
    .handleTypes = VK_EXTERNAL_MEMORY_HANDLE_TYPE_OPAQUE_FD_BIT};
static const struct row {
    const char *test;
    VkBufferCreateFlags flags;
    const void *chain;
    const char *says;
} rows[] = {
    {"test_imported", 0, &external, "minX"},
    {"test_replayed", VK_BUFFER_CREATE_DEVICE_ADDRESS_CAPTURE_REPLAY_BIT, NULL, "minX"},
    {"test_protected", VK_BUFFER_CREATE_PROTECTED_BIT, NULL, "a buffer that can't be read"},
};

TEST_OF_ROWS_BETWEEN(test_on_memory, rows, const struct row *row, open_scene, scene_close)
{
    VkBuffer buffer = create(row->flags, row->chain);
    GET(fixture.vk.BindBufferMemory(fixture.device, buffer, data.memory, 0));
    build_boxes(buffer, 1);
    expect_messages(1, row->says);
    fixture.vk.DestroyBuffer(fixture.device, buffer, NULL);
}

/* It has the address by the time of the submission. */
SCENE_TEST(test_replaced_by_protected)
{
    VkBuffer buffer = create(0, NULL);
    GET(fixture.vk.BindBufferMemory(fixture.device, buffer, data.memory, 0));
    VkCommandBuffer commands = record(buffer, 1);
    VkBuffer other = create(VK_BUFFER_CREATE_PROTECTED_BIT, NULL);
    GET(fixture.vk.BindBufferMemory(fixture.device, other, data.memory, 0));
    assert_int_equal(buffer_address(&fixture.vk, fixture.device, other),
                     buffer_address(&fixture.vk, fixture.device, buffer));
    fixture.vk.DestroyBuffer(fixture.device, buffer, NULL);
    fixture_finish(&fixture, commands);
    fixture_expect_silence(&fixture);
    fixture.vk.DestroyBuffer(fixture.device, other, NULL);
}

/* All that is copied has to be bound. */
SCENE_TEST(test_sparse)
{
    VkBuffer buffer = create_sparse(BUFFER_SIZE);
    build_boxes(buffer, 1);
    expect_messages(1, "minX");
    fixture.vk.DestroyBuffer(fixture.device, buffer, NULL);
}

SCENE_TEST(test_sparse_with_hole)
{
    VkBuffer buffer = create_sparse(sizeof(VkAabbPositionsKHR));
    build_boxes(buffer, 2);
    assert_int_equal(messages_count(&fixture.instance.messages, "", NULL), 0);
    for (uint32_t i = 0; i < messages_kept(&fixture.instance.messages); i++)
        assert_lacks(fixture.instance.messages.items[i].text, "minX");
    fixture.vk.DestroyBuffer(fixture.device, buffer, NULL);
}
