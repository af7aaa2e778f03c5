/* SPDX-License-Identifier: Apache-2.0 */
/* Guarded builds in command buffers that execute several times at once
 * (VK_COMMAND_BUFFER_USAGE_SIMULTANEOUS_USE_BIT): all executions read one limit. */
#include "tests/fixture/copies.h"
#include "tests/snapshots/guard_scene.h"

#include <pthread.h>

static const char NEVER_BUILT[] = "That structure was ";

/* A build that waits for all earlier commands, and is waited for. */
static VkCommandBuffer record(uint32_t count)
{
    VkCommandBuffer commands =
        fixture_begin(&fixture, VK_COMMAND_BUFFER_USAGE_SIMULTANEOUS_USE_BIT);
    fixture_barrier(&fixture, commands);
    guard_build(commands, count);
    fixture_barrier(&fixture, commands);
    GET(fixture.vk.EndCommandBuffer(commands));
    return commands;
}

static VkCommandBuffer record_boxes(VkAccelerationStructureKHR structure)
{
    VkCommandBuffer commands = fixture_begin(&fixture, 0);
    guard_build_boxes(commands, structure);
    GET(fixture.vk.EndCommandBuffer(commands));
    return commands;
}

static void submit(VkCommandBuffer commands)
{
    GET(fixture_submit(&fixture, commands, VK_NULL_HANDLE));
}

GUARD_TEST(test_never_built)
{
    const uint64_t references[] = {guard_address(scene.blas),
                                   guard_address(guard_make(&guard_scene.spare))};
    guard_write(references, 2);
    VkCommandBuffer commands = record(2);
    submit(commands);
    submit(commands);
    GET(fixture.vk.DeviceWaitIdle(fixture.device));
    guard_expect_read((uint64_t[]){references[0], 0, references[0], 0}, 4);
    if (platform.is_null)
        assert_int_equal(fixture.instance.messages.count, 2);
    guard_expect(NEVER_BUILT, "replaced 1 reference");
}

GUARD_TEST(test_built_between_submissions)
{
    VkAccelerationStructureKHR later = guard_make(&guard_scene.spare);
    const uint64_t references[] = {guard_address(scene.blas), guard_address(later)};
    guard_write(references, 2);
    VkCommandBuffer commands = record(2), between = record_boxes(later);
    submit(commands);
    submit(between);
    submit(commands);
    GET(fixture.vk.DeviceWaitIdle(fixture.device));
    guard_expect_read((uint64_t[]){references[0], 0, references[0], references[1]}, 4);
    if (platform.is_null)
        assert_int_equal(fixture.instance.messages.count, 1);
    guard_expect(NEVER_BUILT, "replaced 1 reference");
}

/* Two submissions in flight of one command buffer, the second with a structure that the first has
 * not known. */
GUARD_TEST(test_in_flight)
{
    uint64_t reference = guard_address(scene.blas);
    VkAccelerationStructureKHR later = guard_make(&guard_scene.spare);
    guard_write(&reference, 1);
    VkCommandBuffer commands = record(1), between = fixture_begin(&fixture, 0);
    guard_build_boxes(between, later);
    uint64_t next = guard_address(later);
    guard_change_reference(between, next);
    GET(fixture.vk.EndCommandBuffer(between));
    submit(commands);
    submit(between);
    submit(commands);
    GET(fixture.vk.DeviceWaitIdle(fixture.device));
    guard_expect_read((uint64_t[]){reference, next}, 2);
    messages_clear(&fixture.instance.messages); /* of snapshots that were overwritten */
}

/* ---- while the device still executes an earlier submission */

static void hang(void)
{
    PLAN_FAULT(.kind = NULL_DRIVER_HANG, .at = NULL_DRIVER_AT_SUBMIT);
}

static void end_hang(void)
{
    platform.null_driver.end_hang();
    GET(fixture.vk.DeviceWaitIdle(fixture.device));
}

/* The limit of the second submission counts for both. */
NULL_TEST(test_two_limits_at_once)
{
    struct device_buffer buffer = guard_buffer();
    VkAccelerationStructureKHR later = guard_make(&guard_scene.spare);
    const uint64_t references[] = {guard_address(scene.blas), guard_address(later),
                                   guard_address(guard_make(&buffer))};
    guard_write(references, 3);
    hang();
    VkCommandBuffer commands = record(3), between = record_boxes(later);
    submit(commands);
    submit(between);
    submit(commands);
    end_hang();
    guard_expect_read(
        (uint64_t[]){references[0], references[1], 0, references[0], references[1], 0}, 6);
    messages_clear(&fixture.instance.messages);
}

/* The first submission has no place in execution order, so each live structure counts as built for
 * all that the device executes at once with it; and no longer for those after it. */
NULL_TEST(test_without_a_limit_at_once)
{
    const uint64_t reference = guard_refer_to(guard_make(&guard_scene.spare));
    VkSemaphore timeline = timeline_create(&fixture.vk, fixture.device);
    const STRUCT(VkSemaphoreSignalInfo, signal, .semaphore = timeline, .value = 1);
    hang();
    VkCommandBuffer commands = record(1);
    fixture_submit_waiting(&fixture, commands, timeline, VK_NULL_HANDLE);
    fixture.vk.GetDeviceQueue(fixture.device, 0, 1, &fixture.queue);
    submit(commands);
    GET(fixture.vk.SignalSemaphore(fixture.device, &signal));
    end_hang();
    guard_expect_read((uint64_t[]){reference, reference}, 2);
    messages_clear(&fixture.instance.messages);
    guard_run(commands, 0);
    guard_expect(NEVER_BUILT, "replaced 1 reference");
    fixture.vk.DestroySemaphore(fixture.device, timeline, NULL);
}

/* ---- a secondary that two threads submit */

enum { ROUNDS = 40 };

static VkCommandBuffer secondary;

static void *submit_secondary(void *argument)
{
    const uint32_t *index = argument;
    struct fixture own = {.device = fixture.device, .vk = fixture.vk};
    VkFence fence = fence_create(&own.vk, own.device);
    own.vk.GetDeviceQueue(own.device, 0, *index, &own.queue);
    own.pool = command_pool_create(&own.vk, own.device);
    VkCommandBuffer commands = fixture_begin(&own, 0);
    own.vk.CmdExecuteCommands(commands, 1, &secondary);
    GET(own.vk.EndCommandBuffer(commands));
    for (int round = 0; round < ROUNDS; round++) {
        GET(fixture_submit(&own, commands, fence));
        GET(own.vk.WaitForFences(own.device, 1, &fence, VK_TRUE, UINT64_MAX));
        GET(own.vk.ResetFences(own.device, 1, &fence));
    }
    own.vk.DestroyCommandPool(own.device, own.pool, NULL);
    own.vk.DestroyFence(own.device, fence, NULL);
    return NULL;
}

/* If both threads submit at the same time, the order is unknown to one of them, which lets each
 * live structure count as built. */
NULL_TEST(test_shared_secondary)
{
    pthread_t thread;
    uint64_t read[4 * ROUNDS];
    const uint64_t references[] = {guard_address(scene.blas),
                                   guard_address(guard_make(&guard_scene.spare))};
    guard_write(references, 2);
    secondary = fixture_begin_secondary(&fixture, VK_COMMAND_BUFFER_USAGE_SIMULTANEOUS_USE_BIT);
    guard_build(secondary, 2);
    GET(fixture.vk.EndCommandBuffer(secondary));
    assert_int_equal(pthread_create(&thread, NULL, submit_secondary, &(uint32_t){1}), 0);
    submit_secondary(&(uint32_t){0});
    pthread_join(thread, NULL);
    assert_int_equal(platform.null_driver.take_references(read, 4 * ROUNDS), 4 * ROUNDS);
    for (int i = 0; i < 4 * ROUNDS; i += 2) {
        assert_int_equal(read[i], references[0]);
        assert_true(read[i + 1] == references[1] || !read[i + 1]);
    }
    messages_clear(&fixture.instance.messages);
}
