/* SPDX-License-Identifier: Apache-2.0 */
/* Commands that name addresses, on backend cpu: the buffer that had an address when a command was
 * recorded is destroyed before the submission, and another one on the same memory has it. */
#include "result_scene.h"

#include <stdlib.h>
#include <string.h>

/* A buffer on the memory of another one. */
static VkBuffer create_alias(const struct device_buffer *buffer, VkDeviceSize size)
{
    const STRUCT(VkBufferCreateInfo, info, .size = size,
                 .usage = VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR |
                          VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT |
                          VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT);
    VkBuffer alias;
    VkMemoryRequirements requirements;
    GET(fixture->vk.CreateBuffer(fixture->device, &info, NULL, &alias));
    fixture->vk.GetBufferMemoryRequirements(fixture->device, alias, &requirements);
    GET(fixture->vk.BindBufferMemory(fixture->device, alias, buffer->memory, 0));
    const STRUCT(VkBufferDeviceAddressInfo, address, .buffer = alias);
    assert_int_equal(fixture->vk.GetBufferDeviceAddress(fixture->device, &address),
                     buffer->address);
    return alias;
}

/* Buffers that a driver may put where the destroyed one was. */
enum { LURES = 4 };
struct lures {
    struct device_buffer buffers[LURES];
};

static void replace(struct device_buffer *buffer, VkDeviceSize size, struct lures *lures)
{
    fixture->vk.DestroyBuffer(fixture->device, buffer->handle, NULL);
    for (int i = 0; i < LURES; i++)
        lures->buffers[i] = device_buffer_create(&device, size);
    buffer->handle = create_alias(buffer, size);
}

static void free_lures(struct lures *lures)
{
    for (int i = 0; i < LURES; i++)
        device_buffer_destroy(&device, &lures->buffers[i]);
}

TEST_CLOSED(test_builds, result_scene_close)
{
    struct lures lures;
    result_scene_open(COMPACTED_SIZE);
    struct device_buffer *data = &scene.build.data;
    memcpy(data->bytes, scene.host.data, scene.build.size);
    VkCommandBuffer commands = device_begin(&device, PRIMARY);
    device_build(&device, commands, &scene.build, scene.blas.handle, VK_NULL_HANDLE);
    replace(data, scene.build.size, &lures);
    device_finish(&device, commands);
    assert_true(fixture_trace(fixture, scene.blas.handle, 0.25f, 0.25f).isHit);
    free_lures(&lures);
}

TEST_CLOSED(test_serializes, result_scene_close)
{
    struct lures lures;
    size_t size;
    result_scene_open(COMPACTED_SIZE);
    VkCommandBuffer commands = device_begin(&device, PRIMARY);
    result_scene_record_build(commands);
    device_finish(&device, commands);
    void *expected = device_serialize(&device, scene.blas.handle, &size);
    struct device_buffer buffer = device_buffer_create(&device, size);
    commands = device_begin(&device, PRIMARY);
    device_save(&device, commands, scene.blas.handle, buffer.address);
    replace(&buffer, size, &lures);
    device_finish(&device, commands);
    assert_memory_equal(buffer.bytes, expected, size);
    for (int i = 0; i < LURES; i++)
        assert_true(((const char *)lures.buffers[i].bytes)[0] == 0);
    free(expected);
    free_lures(&lures);
    device_buffer_destroy(&device, &buffer);
}

TEST_CLOSED(test_deserializes, result_scene_close)
{
    struct lures lures;
    size_t size;
    result_scene_open(COMPACTED_SIZE);
    VkCommandBuffer commands = device_begin(&device, PRIMARY);
    result_scene_record_build(commands);
    device_finish(&device, commands);
    void *bytes = device_serialize(&device, scene.blas.handle, &size);
    struct device_buffer buffer = device_buffer_create(&device, size);
    memcpy(buffer.bytes, bytes, size);
    struct fixture_structure loaded = fixture_create_blas(fixture, scene.blas.size);
    commands = device_begin(&device, PRIMARY);
    device_load(&device, commands, buffer.address, loaded.handle);
    replace(&buffer, size, &lures);
    device_finish(&device, commands);
    assert_true(fixture_trace(fixture, loaded.handle, 0.25f, 0.25f).isHit);
    free(bytes);
    free_lures(&lures);
    fixture_destroy(fixture, &loaded);
    device_buffer_destroy(&device, &buffer);
}
