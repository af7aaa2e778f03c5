/* SPDX-License-Identifier: Apache-2.0 */
/* What command buffers write of structures on backend cpu, through the loader: queries; and
 * buffers, which have the data once the application knows that the submission is complete, also if
 * another buffer has got an address since a command named it. */
#include <stdlib.h>
#include <string.h>

#include "device_fixture.h"

/* ---- queries */

#define NOT_READY(call) assert_int_equal(call, VK_NOT_READY)

/* Begins commands that build the BLAS and write its queries. */
static VkCommandBuffer begin_queried(void)
{
    open_queried_pair(COMPACTED_SIZE);
    VkCommandBuffer commands = device_begin(PRIMARY);
    record_blas(commands);
    record_queries(commands, COMPACTED_SIZE);
    return commands;
}

SILENT_TEST(test_queries)
{
    VkCommandBuffer commands = begin_queried();
    device_finish(commands);

    const VkDeviceSize expected = fixture_property(pair.blas.handle, COMPACTED_SIZE);
    assert_in_range(expected, 1, pair.blas.size - 1);
    uint64_t wide[2][2];
    GET(vk.GetQueryPoolResults(device, on_device.pool, 0, 2, sizeof(wide), wide, sizeof(wide[0]),
                               VK_QUERY_RESULT_64_BIT | VK_QUERY_RESULT_WAIT_BIT |
                                   VK_QUERY_RESULT_WITH_AVAILABILITY_BIT));
    for (int i = 0; i < 2; i++) {
        assert_int_equal(wide[i][0], expected);
        assert_int_equal(wide[i][1], 1);
    }
    uint32_t narrow[QUERIES] = {7, 7, 7};
    NOT_READY(vk.GetQueryPoolResults(device, on_device.pool, 0, QUERIES, sizeof(narrow), narrow,
                                     sizeof(narrow[0]), 0));
    assert_int_equal(narrow[1], expected);
    assert_int_equal(narrow[2], 7);
    uint32_t partial[2] = {7, 7};
    NOT_READY(vk.GetQueryPoolResults(
        device, on_device.pool, 2, 1, sizeof(partial), partial, sizeof(partial),
        VK_QUERY_RESULT_PARTIAL_BIT | VK_QUERY_RESULT_WITH_AVAILABILITY_BIT));
    assert_int_equal(partial[0], 0);
    assert_int_equal(partial[1], 0);
}

/* A query keeps the result that it was written with, although the structure changes later. */
SILENT_TEST(test_query_keeps_its_timestamp)
{
    open_queried_pair(SERIALIZATION_SIZE);
    VkCommandBuffer commands = device_begin(PRIMARY);
    record_blas(commands);
    record_queries(commands, SERIALIZATION_SIZE);
    pair.triangles.range.primitiveCount = 1;
    record_blas(commands);
    device_finish(commands);
    const uint64_t value = device_query(on_device.pool, 1);
    assert_in_range(value, fixture_property(pair.blas.handle, SERIALIZATION_SIZE) + 1, UINT64_MAX);
}

SILENT_TEST(test_other_queries)
{
    VkQueryPool pool = query_pool_create(&vk, device, VK_QUERY_TYPE_OCCLUSION, 1);
    OWN(DestroyQueryPool, pool);
    VkCommandBuffer commands = device_begin(PRIMARY);
    vk.CmdResetQueryPool(commands, pool, 0, 1);
    device_finish(commands);
    uint32_t value;
    NOT_READY(vk.GetQueryPoolResults(device, pool, 0, 1, sizeof(value), &value, sizeof(value), 0));
}

static const uint64_t untouched = ~0ull / 255 * 0xee;

static struct device_buffer create_untouched(void)
{
    struct device_buffer buffer = device_buffer_create(256);
    memset(buffer.bytes, 0xee, 256);
    return buffer;
}

SILENT_TEST(test_copied_queries)
{
    VkCommandBuffer commands = begin_queried();
    struct device_buffer buffer = create_untouched();
    vk.CmdCopyQueryPoolResults(commands, on_device.pool, 0, QUERIES, buffer.handle, 32, 32,
                               VK_QUERY_RESULT_64_BIT | VK_QUERY_RESULT_WITH_AVAILABILITY_BIT);
    vk.CmdResetQueryPool(commands, on_device.pool, 0, QUERIES);
    device_finish(commands);
    const uint64_t expected = fixture_property(pair.blas.handle, COMPACTED_SIZE);
    const uint64_t *words = (uint64_t *)buffer.bytes;
    const uint64_t found[] = {words[4], words[5],  words[6], words[8],
                              words[9], words[12], words[13]};
    const uint64_t wanted[] = {expected, 1, untouched, expected, 1, untouched, 0};
    assert_memory_equal(found, wanted, sizeof(found));
}

/* Counts beyond the end of the pool mean no more than up to there, take no time, and nothing is
 * written for queries that there aren't. */
SILENT_TEST(test_wild_counts)
{
    VkCommandBuffer commands = begin_queried();
    struct device_buffer buffer = create_untouched();
    vk.CmdCopyQueryPoolResults(commands, on_device.pool, 1, QUERIES, buffer.handle, 0, 8,
                               VK_QUERY_RESULT_64_BIT);
    vk.CmdResetQueryPool(commands, on_device.pool, 1, UINT32_MAX);
    device_finish(commands);
    const uint64_t expected = fixture_property(pair.blas.handle, COMPACTED_SIZE);
    const uint64_t wanted[] = {expected, untouched, untouched};
    assert_memory_equal(buffer.bytes, wanted, sizeof(wanted));
    uint64_t values[2] = {0};
    NOT_READY(vk.GetQueryPoolResults(device, on_device.pool, 0, 2, sizeof(values), values, 8,
                                     VK_QUERY_RESULT_64_BIT));
    assert_int_equal(values[0], expected);
    vk.ResetQueryPool(device, on_device.pool, 1, UINT32_MAX);
    GET(vk.GetQueryPoolResults(device, on_device.pool, 0, 1, sizeof(values), values, 8,
                               VK_QUERY_RESULT_64_BIT));
    vk.ResetQueryPool(device, on_device.pool, 0, UINT32_MAX);
    NOT_READY(vk.GetQueryPoolResults(device, on_device.pool, 0, 1, sizeof(values), values, 8,
                                     VK_QUERY_RESULT_64_BIT));
}

/* ---- buffers */

SILENT_TEST(test_compaction)
{
    VkCommandBuffer commands = begin_queried();
    device_finish(commands);
    const uint64_t size = device_query(on_device.pool, 0);
    struct fixture_structure compacted = fixture_create_blas(size);
    commands = device_begin(PRIMARY);
    device_copy(commands, pair.blas.handle, compacted.handle, COMPACT);
    device_finish(commands);
    assert_true(fixture_trace(compacted.handle, 0.25f, 0.25f).isHit);
}

/* How an application may learn that a submission is complete. */
enum learning { BY_FENCE, BY_FENCE_STATUS, BY_SEMAPHORE, BY_SEMAPHORE_VALUE, BY_QUEUE, BY_DEVICE };

static void learn(enum learning learning, VkFence fence, VkSemaphore semaphore)
{
    const uint64_t one = 1;
    const STRUCT(VkSemaphoreWaitInfo, wait, .semaphoreCount = 1, .pSemaphores = &semaphore,
                 .pValues = &one);
    uint64_t value = 0;
    switch (learning) {
    case BY_FENCE:
        GET(vk.WaitForFences(device, 1, &fence, VK_TRUE, UINT64_MAX));
        break;
    case BY_FENCE_STATUS:
        while (vk.GetFenceStatus(device, fence) == VK_NOT_READY)
            continue;
        break;
    case BY_SEMAPHORE:
        GET(vk.WaitSemaphores(device, &wait, UINT64_MAX));
        break;
    case BY_SEMAPHORE_VALUE:
        while (value < one)
            GET(vk.GetSemaphoreCounterValue(device, semaphore, &value));
        break;
    case BY_QUEUE:
        GET(vk.QueueWaitIdle(queue));
        break;
    case BY_DEVICE:
        GET(vk.DeviceWaitIdle(device));
        break;
    }
}

static void run_and_learn(VkCommandBuffer commands, enum learning learning)
{
    const uint64_t one = 1;
    const STRUCT(VkTimelineSemaphoreSubmitInfo, values, .signalSemaphoreValueCount = 1,
                 .pSignalSemaphoreValues = &one);
    const VkFence fence = fence_create(&vk, device);
    const VkSemaphore semaphore = timeline_create(&vk, device);
    OWN(DestroyFence, fence);
    OWN(DestroySemaphore, semaphore);
    const STRUCT(VkSubmitInfo, submit, .pNext = &values, .commandBufferCount = 1,
                 .pCommandBuffers = &commands, .signalSemaphoreCount = 1,
                 .pSignalSemaphores = &semaphore);
    device_end(commands);
    GET(vk.QueueSubmit(queue, 1, &submit, fence));
    learn(learning, fence, semaphore);
}

/* Serialized to a buffer, and from there into another structure; with the fence and the semaphore
 * left for the end. */
SILENT_TEST(test_serialization)
{
    for (enum learning learning = BY_FENCE; learning <= BY_DEVICE; learning++) {
        open_device_pair(0);
        run_blas();
        const VkDeviceSize size = fixture_property(pair.blas.handle, SERIALIZATION_SIZE);
        struct device_buffer buffer = device_buffer_create(size + 256);
        const VkDeviceAddress address = (buffer.address + 255) / 256 * 256;
        VkCommandBuffer commands = device_begin(PRIMARY);
        device_save(commands, pair.blas.handle, address);
        run_and_learn(commands, learning);
        size_t expected_size;
        const void *expected = fixture_serialize(pair.blas.handle, &expected_size);
        assert_int_equal(expected_size, size);
        assert_memory_equal(buffer.bytes + (address - buffer.address), expected, size);
        GET(vk.DeviceWaitIdle(device));

        struct fixture_structure loaded = fixture_create_blas(pair.blas.size);
        commands = device_begin(PRIMARY);
        device_load(commands, address, loaded.handle);
        device_finish(commands);
        assert_true(fixture_trace(loaded.handle, 0.25f, 0.25f).isHit);
    }
}

/* One batch of a submission is seen complete, while another waits for the host. */
SILENT_TEST(test_batch_that_waits_for_the_host)
{
    VkCommandBuffer commands = begin_queried();
    struct device_buffer buffer = device_buffer_create(256);
    vk.CmdCopyQueryPoolResults(commands, on_device.pool, 0, 1, buffer.handle, 0, 8,
                               VK_QUERY_RESULT_64_BIT);
    const VkSemaphore semaphore = timeline_create(&vk, device);
    OWN(DestroySemaphore, semaphore);
    const uint64_t one = 1, two = 2;
    const STRUCT(VkTimelineSemaphoreSubmitInfo, values, .waitSemaphoreValueCount = 1,
                 .pWaitSemaphoreValues = &two, .signalSemaphoreValueCount = 1,
                 .pSignalSemaphoreValues = &one);
    const VkPipelineStageFlags stages = VK_PIPELINE_STAGE_ALL_COMMANDS_BIT;
    const VkSubmitInfo submits[] = {
        {VK_STRUCTURE_TYPE_SUBMIT_INFO, &values, 0, NULL, NULL, 1, &commands, 1, &semaphore},
        {VK_STRUCTURE_TYPE_SUBMIT_INFO, &values, 1, &semaphore, &stages, 0, NULL, 0, NULL},
    };
    device_end(commands);
    GET(vk.QueueSubmit(queue, 2, submits, VK_NULL_HANDLE));
    learn(BY_SEMAPHORE, VK_NULL_HANDLE, semaphore);
    const VkSemaphoreSignalInfo signal = {VK_STRUCTURE_TYPE_SEMAPHORE_SIGNAL_INFO, NULL, semaphore,
                                          two};
    GET(vk.SignalSemaphore(device, &signal));
    GET(vk.DeviceWaitIdle(device));
    const uint64_t *words = (uint64_t *)buffer.bytes;
    assert_int_equal(words[0], fixture_property(pair.blas.handle, COMPACTED_SIZE));
}

/* ---- addresses */

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
