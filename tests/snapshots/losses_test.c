/* SPDX-License-Identifier: Apache-2.0 */
/* Executions that level content can't look at because nobody knows when they had their turn, or
 * because the device is lost: each is told. On the null driver, which waits for nothing. */
#include "tests/snapshots/scene.h"

#include <string.h>

enum { BUFFER_SIZE = 1 << 16 };

#define LEFT_OUT                                                                                   \
    "assay_validation.level = content: builds are unchecked in these executions of command "       \
    "buffers: "

#define UNORDERED "assay_validation.level = content: builds are unchecked in "

static VkSemaphore timeline; /* never signalled */
static VkFence fence;

static void open_scene(void)
{
    SCENE_OPEN(.boxes_size = BUFFER_SIZE, .structure_size = BUFFER_SIZE);
    timeline = timeline_create(&fixture.vk, fixture.device);
    fence = fence_create(&fixture.vk, fixture.device);
    scene_invalidate_box(0);
}

/* Without its semaphore, whose end ends waits for it. */
static void close_rest(void)
{
    fixture.vk.DestroyFence(fixture.device, fence, NULL);
    scene_close();
}

static void close_scene(void)
{
    fixture.vk.DestroySemaphore(fixture.device, timeline, NULL);
    close_rest();
}

static VkCommandBuffer record(void)
{
    VkCommandBuffer commands = scene_record_boxes(0, 1);
    GET(fixture.vk.EndCommandBuffer(commands));
    return commands;
}

static VkResult wait(void)
{
    return fixture.vk.WaitForFences(fixture.device, 1, &fence, VK_TRUE, UINT64_MAX);
}

/* One message, which begins so; it is forgotten. */
static void expect_told(const char *text)
{
    if (fixture.instance.messages.count != 1)
        fail_msg("%u messages: %s", fixture.instance.messages.count,
                 fixture.instance.messages.items[0].text);
    if (strncmp(fixture.instance.messages.items[0].text, text, strlen(text)) != 0)
        fail_msg("\"%s\" is not how this begins: %s", text,
                 fixture.instance.messages.items[0].text);
    messages_clear(&fixture.instance.messages);
}

static void expect_in_message(uint32_t i, const char *text)
{
    assert_true(i < messages_kept(&fixture.instance.messages));
    assert_has(fixture.instance.messages.items[i].text, text);
}

TEST(test_complete_for_no_known_reason)
{
    open_scene();
    VkCommandBuffer first = record(), second = record();
    fixture_submit_waiting(&fixture, first, timeline, fence);
    fixture_expect_silence(&fixture);
    GET(wait());
    expect_told(UNORDERED
                "1 execution of command buffers, and in all from now on, because their "
                "order is unknown (a submission completed although nothing known ended "
                "its wait).");
    GET(fixture_submit(&fixture, second, VK_NULL_HANDLE));
    GET(fixture.vk.DeviceWaitIdle(fixture.device));
    fixture_expect_silence(&fixture);
    close_scene();
    fixture_expect_silence(&fixture);
}

/* What is submitted first after the loss is what there is to tell of. */
TEST(test_nothing_left_out_until_later)
{
    open_scene();
    VkCommandBuffer nothing = fixture_begin(&fixture, 0), commands = record();
    GET(fixture.vk.EndCommandBuffer(nothing));
    fixture_submit_waiting(&fixture, nothing, timeline, fence);
    GET(wait());
    fixture_expect_silence(&fixture);
    GET(fixture_submit(&fixture, commands, VK_NULL_HANDLE));
    expect_told(UNORDERED "1 execution of command buffers, and in all from now on,");
    close_scene();
    fixture_expect_silence(&fixture);
}

TEST(test_device_lost)
{
    open_scene();
    GET(fixture_submit(&fixture, record(), fence));
    fixture_expect_silence(&fixture);
    platform.null_driver.set_device_lost(true);
    assert_int_equal(wait(), VK_ERROR_DEVICE_LOST);
    expect_in_message(0, ", read after the device was lost.");
    expect_in_message(1, "1 build was submitted");
    assert_int_equal(fixture.instance.messages.count, 2);
    messages_clear(&fixture.instance.messages);
    close_scene();
    platform.null_driver.set_device_lost(false);
    fixture_expect_silence(&fixture);
}

/* Its copies are not complete. tests/programs/postmortem has the other cases. */
TEST(test_device_lost_before_the_copies)
{
    open_scene();
    PLAN_FAULT(.kind = NULL_DRIVER_LOSE, .at = NULL_DRIVER_AT_BUILD, .skips_copies = true);
    GET(fixture_submit(&fixture, record(), fence));
    assert_int_equal(wait(), VK_ERROR_DEVICE_LOST);
    expect_in_message(0, LEFT_OUT "1 on a device that is lost.");
    close_scene();
    platform.null_driver.reset();
}

/* The structure and two buffers are destroyed too early. */
TEST(test_held_to_the_end)
{
    enum { DESTROYED = 3 };
    open_scene();
    fixture_submit_waiting(&fixture, record(), timeline, fence);
    fixture_expect_silence(&fixture);
    close_rest();
    assert_int_equal(fixture.instance.messages.count, DESTROYED + 1);
    for (uint32_t i = 0; i < DESTROYED; i++)
        expect_in_message(i, "has not completed as far as the application has observed");
    expect_in_message(DESTROYED, LEFT_OUT "1 behind waits for signals that were not submitted.");
}
