/* SPDX-License-Identifier: Apache-2.0 */
/* Where level content ends: its budget, what it can't read in time, and places where it adds
 * nothing; each is told, and none disturbs the application. */
#include "tests/snapshots/scene.h"

#include <string.h>
#include <time.h>

#include "layer/assay.h"

enum {
    BOXES = 40000, /* close to a MiB */
    BUILDS = 4,
    SMALL_RECORDINGS = 1100,
    STRUCTURE_SIZE = 16 << 20,
};

static void open_scene_with(struct instance_settings settings)
{
    SCENE_OPEN(.settings = settings, .boxes_size = BOXES * sizeof(VkAabbPositionsKHR),
               .structure_size = STRUCTURE_SIZE);
}

static void open_scene(void)
{
    open_scene_with((struct instance_settings){0});
}

static uint64_t bytes_copied(void)
{
    PFN_vkGetCountersASSAY get = (PFN_vkGetCountersASSAY)fixture.instance.get_device_proc_addr(
        fixture.device, "vkGetCountersASSAY");
    AssayCounters counters;
    assert_non_null(get);
    get(fixture.device, sizeof(counters), &counters);
    return counters.bytesSnapshot;
}

SCENE_TEST(test_only_builds_cost)
{
    VkCommandBuffer commands = fixture_begin(&fixture, 0);
    fixture_barrier(&fixture, commands);
    fixture_finish(&fixture, commands);
    assert_int_equal(bytes_copied(), 0);
    commands = scene_record_boxes(0, 3);
    scene_build_boxes(commands, 0);
    fixture_finish(&fixture, commands);
    assert_int_equal(bytes_copied(), 3 * sizeof(VkAabbPositionsKHR));
    fixture_expect_silence(&fixture);
}

/* Beyond the budget builds are left out, by position; those before are looked at. */
TEST(test_skipped_beyond_budget)
{
    open_scene_with((struct instance_settings){.budget_mib = "2", .when_full = "skip"});
    VkCommandBuffer commands = fixture_begin(&fixture, 0);
    for (int i = 0; i < BUILDS; i++)
        scene_build_boxes(commands, BOXES);
    fixture_finish(&fixture, commands);
    assert_int_equal(bytes_copied(), 2 * BOXES * sizeof(VkAabbPositionsKHR));
    expect_messages(1, "build 2 (beyond content_budget_mib), build 3 (beyond content_budget_mib)");
    commands = scene_record_boxes(0, BOXES);
    fixture_finish(&fixture, commands);
    assert_int_equal(bytes_copied(), 3 * BOXES * sizeof(VkAabbPositionsKHR));
    fixture_expect_silence(&fixture);
    scene_close();
}

/* A recording takes as much of the budget as it needs, not an allocation of its own. */
TEST(test_small_recordings_take_little_of_the_budget)
{
    open_scene_with((struct instance_settings){.budget_mib = "8", .when_full = "skip"});
    static VkCommandBuffer commands[SMALL_RECORDINGS];
    for (int i = 0; i < SMALL_RECORDINGS; i++)
        commands[i] = scene_record_boxes(0, 3);
    for (int i = 0; i < SMALL_RECORDINGS; i++)
        fixture_finish(&fixture, commands[i]);
    assert_int_equal(bytes_copied(), SMALL_RECORDINGS * 3 * sizeof(VkAabbPositionsKHR));
    fixture_expect_silence(&fixture);
    scene_close();
}

/* What executes once gives its memory back once it is complete, without the application's help. */
TEST(test_waits_for_budget)
{
    open_scene_with((struct instance_settings){.budget_mib = "2", .when_full = "wait"});
    VkCommandBuffer commands[BUILDS];
    for (int i = 0; i < BUILDS; i++) {
        commands[i] = fixture_begin(&fixture, VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT);
        scene_build_boxes(commands[i], BOXES);
        scene_submit(commands[i]);
    }
    GET(fixture.vk.DeviceWaitIdle(fixture.device));
    assert_int_equal(bytes_copied(), BUILDS * BOXES * sizeof(VkAabbPositionsKHR));
    fixture_expect_silence(&fixture);
    scene_close();
}

/* A command buffer that may be pending twice, and waits for the host: to wait for its first
 * execution would be for ever. */
SCENE_TEST(test_submits_again_while_pending)
{
    VkSemaphore semaphore = timeline_create(&fixture.vk, fixture.device);
    scene_invalidate_box(0);
    VkCommandBuffer commands = scene_record_boxes(VK_COMMAND_BUFFER_USAGE_SIMULTANEOUS_USE_BIT, 1);
    GET(fixture.vk.EndCommandBuffer(commands));
    fixture_submit_waiting(&fixture, commands, semaphore, VK_NULL_HANDLE);
    fixture_expect_silence(&fixture);
    fixture_submit_waiting(&fixture, commands, semaphore, VK_NULL_HANDLE);
    expect_messages(1, "1 of command buffers that are submitted again before they are complete");
    const STRUCT(VkSemaphoreSignalInfo, signal, .semaphore = semaphore, .value = 1);
    GET(fixture.vk.SignalSemaphore(fixture.device, &signal));
    GET(fixture.vk.DeviceWaitIdle(fixture.device));
    expect_messages(1, "minX");
    fixture.vk.DestroySemaphore(fixture.device, semaphore, NULL);
}

SCENE_TEST(test_twice_in_a_submission)
{
    scene_invalidate_box(0);
    VkCommandBuffer commands = scene_record_boxes(VK_COMMAND_BUFFER_USAGE_SIMULTANEOUS_USE_BIT, 1);
    GET(fixture.vk.EndCommandBuffer(commands));
    const VkCommandBuffer twice[] = {commands, commands};
    const STRUCT(VkSubmitInfo, info, .commandBufferCount = 2, .pCommandBuffers = twice);
    GET(fixture.vk.QueueSubmit(fixture.queue, 1, &info, VK_NULL_HANDLE));
    expect_messages(1, "1 followed by another of the same command buffer in the submission");
    GET(fixture.vk.QueueWaitIdle(fixture.queue));
    expect_messages(1, "minX");
}

/* Resubmitted when it is complete, each execution is looked at by itself. */
SCENE_TEST(test_submits_again)
{
    VkCommandBuffer commands = scene_record_boxes(0, 2);
    GET(fixture.vk.EndCommandBuffer(commands));
    VkFence fence = fence_create(&fixture.vk, fixture.device);
    for (uint32_t i = 0; i < 2; i++) {
        scene_invalidate_box(i);
        GET(fixture_submit(&fixture, commands, fence));
        GET(fixture.vk.WaitForFences(fixture.device, 1, &fence, VK_TRUE, UINT64_MAX));
        GET(fixture.vk.ResetFences(fixture.device, 1, &fence));
        expect_messages(1, "minX");
        memset(scene.boxes.bytes, 0, 2 * sizeof(VkAabbPositionsKHR));
    }
    GET(fixture_submit(&fixture, commands, fence));
    GET(fixture.vk.WaitForFences(fixture.device, 1, &fence, VK_TRUE, UINT64_MAX));
    fixture_expect_silence(&fixture);
    fixture.vk.DestroyFence(fixture.device, fence, NULL);
}

/* The layer doesn't see that the application knows the end of its work, as it doesn't see events.
 * The device's destruction brings what is left. */
TEST(test_tells_at_destruction)
{
    const STRUCT(VkEventCreateInfo, info);
    VkEvent event;
    open_scene_with((struct instance_settings){0});
    GET(fixture.vk.CreateEvent(fixture.device, &info, NULL, &event));
    scene_invalidate_box(0);
    VkCommandBuffer commands = scene_record_boxes(0, 1);
    fixture.vk.CmdSetEvent(commands, event, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT);
    scene_submit(commands);
    while (fixture.vk.GetEventStatus(fixture.device, event) != VK_EVENT_SET)
        continue;
    nanosleep(&(struct timespec){.tv_nsec = 100 * 1000 * 1000}, NULL);
    fixture_expect_silence(&fixture);
    fixture.vk.DestroyEvent(fixture.device, event, NULL);
    scene_close();
    expect_messages(1, "minX");
}

TEST(test_not_without_its_level)
{
    open_scene_with((struct instance_settings){.without_layer = true});
    assert_null(fixture.instance.get_device_proc_addr(fixture.device, "vkGetCountersASSAY"));
    scene_close();
}
