/* SPDX-License-Identifier: Apache-2.0 */
/* What command buffers write of structures to buffers on backend cpu, through the loader: it is
 * there once the application knows that the submission is complete. */
#include "result_scene.h"

#include <stdlib.h>

static const VkQueryType SERIALIZATION_SIZE =
    VK_QUERY_TYPE_ACCELERATION_STRUCTURE_SERIALIZATION_SIZE_KHR;

TEST_CLOSED(test_compaction, result_scene_close)
{
    result_scene_open(COMPACTED_SIZE);
    VkCommandBuffer commands = device_begin(&device, PRIMARY);
    result_scene_record_build(commands);
    result_scene_record_queries(commands, COMPACTED_SIZE);
    device_finish(&device, commands);
    const uint64_t size = device_query(&device, scene.pool, 0);
    struct fixture_structure compacted = fixture_create_blas(fixture, size);
    commands = device_begin(&device, PRIMARY);
    device_copy(&device, commands, scene.blas.handle, compacted.handle,
                VK_COPY_ACCELERATION_STRUCTURE_MODE_COMPACT_KHR);
    device_finish(&device, commands);
    assert_true(fixture_trace(fixture, compacted.handle, 0.25f, 0.25f).isHit);
    fixture_destroy(fixture, &compacted);
}

/* How an application may learn that a submission is complete. */
enum learning { BY_FENCE, BY_FENCE_STATUS, BY_SEMAPHORE, BY_SEMAPHORE_VALUE, BY_QUEUE, BY_DEVICE };

static void learn(enum learning learning, VkFence fence, VkSemaphore semaphore)
{
    const VkuDeviceDispatchTable *vk = &fixture->vk;
    const uint64_t one = 1;
    const STRUCT(VkSemaphoreWaitInfo, wait, .semaphoreCount = 1, .pSemaphores = &semaphore,
                 .pValues = &one);
    uint64_t value = 0;
    switch (learning) {
    case BY_FENCE:
        GET(vk->WaitForFences(fixture->device, 1, &fence, VK_TRUE, UINT64_MAX));
        break;
    case BY_FENCE_STATUS:
        while (vk->GetFenceStatus(fixture->device, fence) == VK_NOT_READY)
            continue;
        break;
    case BY_SEMAPHORE:
        GET(vk->WaitSemaphores(fixture->device, &wait, UINT64_MAX));
        break;
    case BY_SEMAPHORE_VALUE:
        while (value < one)
            GET(vk->GetSemaphoreCounterValue(fixture->device, semaphore, &value));
        break;
    case BY_QUEUE:
        GET(vk->QueueWaitIdle(device.queue));
        break;
    case BY_DEVICE:
        GET(vk->DeviceWaitIdle(fixture->device));
        break;
    }
}

/* A submission whose objects are kept until the test has looked at what it knows of it. */
struct submission {
    VkFence fence;
    VkSemaphore semaphore;
};

static void end_submission(const struct submission *submission)
{
    GET(fixture->vk.DeviceWaitIdle(fixture->device));
    fixture->vk.DestroyFence(fixture->device, submission->fence, NULL);
    fixture->vk.DestroySemaphore(fixture->device, submission->semaphore, NULL);
}

static struct submission run_and_learn(VkCommandBuffer commands, enum learning learning)
{
    const VkuDeviceDispatchTable *vk = &fixture->vk;
    const uint64_t one = 1;
    const STRUCT(VkTimelineSemaphoreSubmitInfo, values, .signalSemaphoreValueCount = 1,
                 .pSignalSemaphoreValues = &one);
    const struct submission submission = {fence_create(vk, fixture->device),
                                          timeline_create(vk, fixture->device)};
    const STRUCT(VkSubmitInfo, submit, .pNext = &values, .commandBufferCount = 1,
                 .pCommandBuffers = &commands, .signalSemaphoreCount = 1,
                 .pSignalSemaphores = &submission.semaphore);
    device_end(&device, commands);
    GET(vk->QueueSubmit(device.queue, 1, &submit, submission.fence));
    learn(learning, submission.fence, submission.semaphore);
    return submission;
}

/* Serialized to a buffer, and from there into another structure; with the fence and the semaphore
 * left for the end. */
TEST(test_serialization)
{
    for (enum learning learning = BY_FENCE; learning <= BY_DEVICE; learning++) {
        result_scene_open(SERIALIZATION_SIZE);
        VkCommandBuffer commands = device_begin(&device, PRIMARY);
        result_scene_record_build(commands);
        device_finish(&device, commands);
        const VkDeviceSize size = result_scene_property(scene.blas.handle, SERIALIZATION_SIZE);
        struct device_buffer buffer = device_buffer_create(&device, size + 256);
        const VkDeviceAddress address = (buffer.address + 255) / 256 * 256;
        commands = device_begin(&device, PRIMARY);
        device_save(&device, commands, scene.blas.handle, address);
        const struct submission submission = run_and_learn(commands, learning);
        size_t expected_size;
        void *expected = device_serialize(&device, scene.blas.handle, &expected_size);
        assert_int_equal(expected_size, size);
        assert_memory_equal(buffer.bytes + (address - buffer.address), expected, size);
        free(expected);
        end_submission(&submission);

        struct fixture_structure loaded = fixture_create_blas(fixture, scene.blas.size);
        commands = device_begin(&device, PRIMARY);
        device_load(&device, commands, address, loaded.handle);
        device_finish(&device, commands);
        assert_true(fixture_trace(fixture, loaded.handle, 0.25f, 0.25f).isHit);
        fixture_destroy(fixture, &loaded);
        device_buffer_destroy(&device, &buffer);
        result_scene_close();
    }
}

/* One batch of a submission is seen complete, while another waits for the host. */
TEST_CLOSED(test_batch_that_waits_for_the_host, result_scene_close)
{
    const VkuDeviceDispatchTable *vk = &fixture->vk;
    result_scene_open(COMPACTED_SIZE);
    struct device_buffer buffer = device_buffer_create(&device, 256);
    VkCommandBuffer commands = device_begin(&device, PRIMARY);
    result_scene_record_build(commands);
    result_scene_record_queries(commands, COMPACTED_SIZE);
    vk->CmdCopyQueryPoolResults(commands, scene.pool, 0, 1, buffer.handle, 0, 8,
                                VK_QUERY_RESULT_64_BIT);
    const struct submission submission = {.semaphore =
                                              timeline_create(&fixture->vk, fixture->device)};
    const uint64_t one = 1, two = 2;
    const STRUCT(VkTimelineSemaphoreSubmitInfo, values, .waitSemaphoreValueCount = 1,
                 .pWaitSemaphoreValues = &two, .signalSemaphoreValueCount = 1,
                 .pSignalSemaphoreValues = &one);
    const VkPipelineStageFlags stages = VK_PIPELINE_STAGE_ALL_COMMANDS_BIT;
    const VkSubmitInfo submits[] = {
        {VK_STRUCTURE_TYPE_SUBMIT_INFO, &values, 0, NULL, NULL, 1, &commands, 1,
         &submission.semaphore},
        {VK_STRUCTURE_TYPE_SUBMIT_INFO, &values, 1, &submission.semaphore, &stages, 0, NULL, 0,
         NULL},
    };
    device_end(&device, commands);
    GET(vk->QueueSubmit(device.queue, 2, submits, VK_NULL_HANDLE));
    learn(BY_SEMAPHORE, VK_NULL_HANDLE, submission.semaphore);
    const VkSemaphoreSignalInfo signal = {VK_STRUCTURE_TYPE_SEMAPHORE_SIGNAL_INFO, NULL,
                                          submission.semaphore, two};
    GET(vk->SignalSemaphore(fixture->device, &signal));
    end_submission(&submission);
    const uint64_t *words = (uint64_t *)buffer.bytes;
    assert_int_equal(words[0], result_scene_property(scene.blas.handle, COMPACTED_SIZE));
    device_buffer_destroy(&device, &buffer);
}
