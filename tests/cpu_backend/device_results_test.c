/* SPDX-License-Identifier: Apache-2.0 */
/* What command buffers write of structures to buffers on backend cpu, through the loader: it is
 * there once the application knows that the submission is complete. */
#include "device_fixture.h"

#include <stdlib.h>

SILENT_TEST(test_compaction)
{
    open_queried_pair(COMPACTED_SIZE);
    VkCommandBuffer commands = device_begin(PRIMARY);
    record_blas(commands);
    record_queries(commands, COMPACTED_SIZE);
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

/* One batch of a submission is seen complete, while another waits for the host.
 */
SILENT_TEST(test_batch_that_waits_for_the_host)
{
    open_queried_pair(COMPACTED_SIZE);
    struct device_buffer buffer = device_buffer_create(256);
    VkCommandBuffer commands = device_begin(PRIMARY);
    record_blas(commands);
    record_queries(commands, COMPACTED_SIZE);
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
