/* SPDX-License-Identifier: Apache-2.0 */
/* The layer's own fences at level content while the driver fails: a command that fails once says
 * nothing about the device, and nothing is lost by it. On the null driver. */
#include "tests/snapshots/scene.h"

enum { BUFFER_SIZE = 1 << 16 };

static VkSemaphore timeline;
static VkFence fence;

static void open_scene(void)
{
    SCENE_OPEN(.boxes_size = BUFFER_SIZE, .structure_size = BUFFER_SIZE);
    timeline = timeline_create(&fixture.vk, fixture.device);
    fence = fence_create(&fixture.vk, fixture.device);
    scene_invalidate_box(0);
}

static void close_scene(void)
{
    fixture.vk.DestroySemaphore(fixture.device, timeline, NULL);
    fixture.vk.DestroyFence(fixture.device, fence, NULL);
    scene_close();
    platform.null_driver.reset();
}

/* A call with which the layer looks for complete submissions, and which uses no fence. */
static void look(void)
{
    uint64_t value;
    GET(fixture.vk.GetSemaphoreCounterValue(fixture.device, timeline, &value));
}

static uint64_t count_destroyed(void)
{
    return platform.null_driver.calls("vkDestroyFence");
}

static void wait(void)
{
    GET(fixture.vk.WaitForFences(fixture.device, 1, &fence, VK_TRUE, UINT64_MAX));
}

/* The application has observed the end of the submission, and all that the layer asks about its own
 * fence fails. */
static void fail_after_wait(VkResult result)
{
    VkCommandBuffer commands = scene_record_boxes(0, 1);
    GET(fixture.vk.EndCommandBuffer(commands));
    GET(fixture_submit(&fixture, commands, fence));
    platform.null_driver.fail_next("vkGetFenceStatus", VK_ERROR_OUT_OF_HOST_MEMORY);
    platform.null_driver.fail_at("vkWaitForFences", 2, result); /* 1: the application's */
    wait();
    assert_int_equal(count_destroyed(), 0);
    fixture_expect_silence(&fixture);
    platform.null_driver.fail_next("vkGetFenceStatus", VK_SUCCESS);
    look();
    expect_messages(1, "pInfos[0].pGeometries[0]");
}

TEST_BETWEEN(test_failed_wait, open_scene, close_scene)
{
    fail_after_wait(VK_ERROR_OUT_OF_HOST_MEMORY);
}

TEST_BETWEEN(test_failed_wait_without_device_memory, open_scene, close_scene)
{
    fail_after_wait(VK_ERROR_OUT_OF_DEVICE_MEMORY);
}

TEST_BETWEEN(test_timeout, open_scene, close_scene)
{
    fail_after_wait(VK_TIMEOUT);
}

#define LEFT_OUT                                                                                   \
    "assay_validation.level = content: builds are unchecked in these executions of command "       \
    "buffers: 1 for lack of memory."

/* Nothing shows when the device has ended, so nothing is read, then and later. */
TEST_BETWEEN(test_fence_that_is_not_submitted, open_scene, close_scene)
{
    VkCommandBuffer commands = scene_record_boxes(0, 1);
    GET(fixture.vk.EndCommandBuffer(commands));
    platform.null_driver.fail_at("vkQueueSubmit", 2, VK_ERROR_OUT_OF_HOST_MEMORY);
    GET(fixture_submit(&fixture, commands, fence));
    expect_messages(1, LEFT_OUT);
    wait();
    GET(fixture.vk.ResetFences(fixture.device, 1, &fence));
    GET(fixture_submit(&fixture, commands, fence));
    wait();
    fixture_expect_silence(&fixture);

    commands = scene_record_boxes(0, 1);
    GET(fixture.vk.EndCommandBuffer(commands));
    GET(fixture.vk.ResetFences(fixture.device, 1, &fence));
    GET(fixture_submit(&fixture, commands, fence));
    wait();
    expect_messages(1, "pInfos[0].pGeometries[0]");
}

/* Nor is a secondary read that another primary executes later. */
TEST_BETWEEN(test_fence_of_a_secondary_that_is_not_submitted, open_scene, close_scene)
{
    VkCommandBuffer secondary =
        fixture_begin_secondary(&fixture, VK_COMMAND_BUFFER_USAGE_SIMULTANEOUS_USE_BIT);
    scene_build_boxes(secondary, 1);
    GET(fixture.vk.EndCommandBuffer(secondary));
    for (int i = 0; i < 2; i++) {
        VkCommandBuffer primary = fixture_begin(&fixture, 0);
        fixture.vk.CmdExecuteCommands(primary, 1, &secondary);
        GET(fixture.vk.EndCommandBuffer(primary));
        if (i == 0)
            platform.null_driver.fail_at("vkQueueSubmit", 2, VK_ERROR_OUT_OF_HOST_MEMORY);
        GET(fixture_submit(&fixture, primary, fence));
        wait();
        GET(fixture.vk.ResetFences(fixture.device, 1, &fence));
    }
    expect_messages(1, LEFT_OUT);
}

/* The layer's fence is refused because the device is lost. */
TEST_BETWEEN(test_lost_before_the_fence, open_scene, close_scene)
{
    VkCommandBuffer commands = scene_record_boxes(0, 1);
    GET(fixture.vk.EndCommandBuffer(commands));
    platform.null_driver.fail_at("vkQueueSubmit", 2, VK_ERROR_DEVICE_LOST);
    GET(fixture_submit(&fixture, commands, VK_NULL_HANDLE));
    platform.null_driver.set_device_lost(true);
    assert_int_equal(fixture.vk.DeviceWaitIdle(fixture.device), VK_ERROR_DEVICE_LOST);
    messages_clear(&fixture.instance.messages);
}
