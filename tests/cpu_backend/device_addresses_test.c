/* SPDX-License-Identifier: Apache-2.0 */
/* Commands that name addresses, on backend cpu: the buffer that had an address when a command was
 * recorded is destroyed before the submission, and another one on the same memory has it. */
#include "device_fixture.h"

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
    GET(vk.CreateBuffer(device, &info, NULL, &alias));
    vk.GetBufferMemoryRequirements(device, alias, &requirements);
    GET(vk.BindBufferMemory(device, alias, buffer->memory, 0));
    assert_int_equal(buffer_address(&vk, device, alias), buffer->address);
    OWN(DestroyBuffer, alias);
    return alias;
}

/* Buffers that a driver may put where the destroyed one was. */
enum { LURES = 4 };
struct lures {
    struct device_buffer buffers[LURES];
};

static void replace(struct device_buffer *buffer, VkDeviceSize size, struct lures *lures)
{
    destroy((uint64_t)buffer->handle);
    for (int i = 0; i < LURES; i++)
        lures->buffers[i] = device_buffer_create(size);
    buffer->handle = create_alias(buffer, size);
}

SILENT_TEST(test_builds)
{
    struct lures lures;
    open_device_pair(COMPACTABLE);
    struct device_buffer *data = &on_device.triangles.data;
    memcpy(data->bytes, pair.triangles.data, pair.triangles.size);
    VkCommandBuffer commands = device_begin(PRIMARY);
    device_build(commands, &on_device.triangles, pair.blas.handle, VK_NULL_HANDLE);
    replace(data, pair.triangles.size, &lures);
    device_finish(commands);
    assert_true(fixture_trace(pair.blas.handle, 0.25f, 0.25f).isHit);
}

SILENT_TEST(test_serializes)
{
    struct lures lures;
    size_t size;
    open_device_pair(COMPACTABLE);
    run_blas();
    const void *expected = fixture_serialize(pair.blas.handle, &size);
    struct device_buffer buffer = device_buffer_create(size);
    VkCommandBuffer commands = device_begin(PRIMARY);
    device_save(commands, pair.blas.handle, buffer.address);
    replace(&buffer, size, &lures);
    device_finish(commands);
    assert_memory_equal(buffer.bytes, expected, size);
    for (int i = 0; i < LURES; i++)
        assert_true(((const char *)lures.buffers[i].bytes)[0] == 0);
}

SILENT_TEST(test_deserializes)
{
    struct lures lures;
    size_t size;
    open_device_pair(COMPACTABLE);
    run_blas();
    const void *bytes = fixture_serialize(pair.blas.handle, &size);
    struct device_buffer buffer = device_buffer_create(size);
    memcpy(buffer.bytes, bytes, size);
    struct fixture_structure loaded = fixture_create_blas(pair.blas.size);
    VkCommandBuffer commands = device_begin(PRIMARY);
    device_load(commands, buffer.address, loaded.handle);
    replace(&buffer, size, &lures);
    device_finish(commands);
    assert_true(fixture_trace(loaded.handle, 0.25f, 0.25f).isHit);
}
