/* SPDX-License-Identifier: Apache-2.0 */
/* The first VK_ERROR_DEVICE_LOST: inputs that had been copied are validated, and one message lists
 * the builds that may not be complete. */
#include "tests/snapshots/scene.h"

#include <string.h>

enum { BUFFER_SIZE = 1 << 16 };

static VkFence fence;

static void plan(enum null_driver_event kind, enum null_driver_place at, uint32_t number,
                 bool skips_copies)
{
    PLAN_FAULT(.kind = kind, .at = at, .number = number, .skips_copies = skips_copies);
}

static void open_at(const char *level)
{
    SCENE_OPEN(.settings.level = level, .boxes_size = BUFFER_SIZE, .structure_size = BUFFER_SIZE);
    fence = fence_create(&fixture.vk, fixture.device);
    scene_invalidate_box(0);
}

static void open_scene(void)
{
    open_at(NULL);
}

static void close_scene(void)
{
    fixture.vk.DestroyFence(fixture.device, fence, NULL);
    scene_close();
    platform.null_driver.reset();
}

#define LOSS_TEST(name) TEST_BETWEEN(name, open_scene, close_scene)

/* Each build is of one box more than the one before. */
static VkCommandBuffer record(uint32_t builds)
{
    VkCommandBuffer commands = fixture_begin(&fixture, 0);
    for (uint32_t i = 0; i < builds; i++)
        scene_build_boxes(commands, 1 + i);
    GET(fixture.vk.EndCommandBuffer(commands));
    return commands;
}

static void submit_and_lose(VkCommandBuffer commands)
{
    GET(fixture_submit(&fixture, commands, fence));
    fixture_expect_silence(&fixture);
    assert_int_equal(fixture.vk.WaitForFences(fixture.device, 1, &fence, VK_TRUE, UINT64_MAX),
                     VK_ERROR_DEVICE_LOST);
}

/* Records builds, at one of which the device is lost: after its inputs were copied, or before. */
static void lose_at_build(uint32_t builds, uint32_t number, bool skips_copies)
{
    plan(NULL_DRIVER_LOSE, NULL_DRIVER_AT_BUILD, number, skips_copies);
    submit_and_lose(record(builds));
}

static const char *text_of(const char *id)
{
    const struct messages *messages = &fixture.instance.messages;
    const char *found = NULL;
    for (uint32_t i = 0; i < messages_kept(messages); i++)
        if (strstr(messages->items[i].id, id)) {
            assert_null(found);
            found = messages->items[i].text;
        }
    if (!found)
        fail_msg("no message has the id %s", id);
    return found;
}

static void expect_list(const char *part)
{
    assert_has(text_of("ASSAY-device-lost"), part);
}

static void expect_count(uint32_t count)
{
    assert_int_equal(fixture.instance.messages.count, count);
}

LOSS_TEST(test_inputs_were_copied)
{
    lose_at_build(1, 1, false);
    expect_count(2);
    assert_has(text_of("VUID"), "minX");
    assert_has(text_of("VUID"), "submission 1, read after the device was lost.");
    expect_list("The device was lost. 1 build was submitted");
    expect_list("1. build of VkAccelerationStructureKHR");
    expect_list("(65536 bytes) from 1 geometry");
    expect_list(": its inputs had been copied, and it had not finished.");
}

LOSS_TEST(test_inputs_were_not_copied)
{
    lose_at_build(1, 1, true);
    expect_count(2);
    expect_list(": the device had not reached it.");
    assert_has(text_of("ASSAY-warning"), "1 on a device that is lost");
}

/* The mark behind the first build stands, so the second one is the culprit. The third shares the
 * box that is invalid. */
LOSS_TEST(test_second_of_three)
{
    lose_at_build(3, 2, false);
    expect_count(4);
    expect_list("3 builds were submitted");
    expect_list("1. build of ");
    const char *list = text_of("ASSAY-device-lost");
    const char *second = strstr(list, "build 1"), *third = strstr(list, "build 2"),
               *first = strstr(list, "build 0");
    assert_non_null(first);
    assert_true(second < third && third < first);
    assert_has(second, "its inputs had been copied, and it had not finished");
    assert_has(third, "the device had not reached it");
    assert_has(first, "it had finished");
    assert_has(text_of("ASSAY-warning"), "1 on a device that is lost");
}

LOSS_TEST(test_complete_builds_are_not_listed)
{
    GET(fixture_submit(&fixture, record(1), fence));
    GET(fixture.vk.WaitForFences(fixture.device, 1, &fence, VK_TRUE, UINT64_MAX));
    expect_messages(1, "minX");
    GET(fixture.vk.ResetFences(fixture.device, 1, &fence));
    lose_at_build(1, 1, true);
    expect_list("1 build was submitted");
}

/* Nobody knows which of the executions has written the marks. */
LOSS_TEST(test_submitted_twice)
{
    plan(NULL_DRIVER_HANG, NULL_DRIVER_AT_BUILD, 1, false);
    VkCommandBuffer commands = record(1);
    GET(fixture_submit(&fixture, commands, VK_NULL_HANDLE));
    GET(fixture_submit(&fixture, commands, fence));
    messages_clear(&fixture.instance.messages);
    platform.null_driver.set_device_lost(true);
    assert_int_equal(fixture.vk.GetFenceStatus(fixture.device, fence), VK_ERROR_DEVICE_LOST);
    expect_list("2 builds were submitted");
    assert_lacks(text_of("ASSAY-device-lost"), "copied");
}

LOSS_TEST(test_names)
{
    plan(NULL_DRIVER_LOSE, NULL_DRIVER_AT_BUILD, 1, false);
    const VkDebugUtilsLabelEXT frame = MAKE(VkDebugUtilsLabelEXT, .pLabelName = "frame"),
                               queue = MAKE(VkDebugUtilsLabelEXT, .pLabelName = "main");
    VkCommandBuffer primary = fixture_begin(&fixture, 0),
                    secondary = fixture_begin_secondary(&fixture, 0);
    scene_set_name(VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR, (uint64_t)scene.blas, "rabbit");
    scene_set_name(VK_OBJECT_TYPE_COMMAND_BUFFER, (uint64_t)(uintptr_t)secondary, "meshes \"2\"");
    fixture.vk.CmdBeginDebugUtilsLabelEXT(secondary, &frame);
    scene_build_boxes(secondary, 1);
    GET(fixture.vk.EndCommandBuffer(secondary));
    fixture.vk.CmdExecuteCommands(primary, 1, &secondary);
    GET(fixture.vk.EndCommandBuffer(primary));
    fixture.vk.QueueBeginDebugUtilsLabelEXT(fixture.queue, &queue);
    submit_and_lose(primary);
    expect_count(2);
    expect_list("[\"rabbit\"]");
    expect_list("[\"meshes \\\"2\\\"\"], build 0, labels \"frame\", executed by VkCommandBuffer");
    expect_list("submission 1, queue labels \"main\": its inputs had been copied");
}

static void lose_at(const char *level)
{
    open_at(level);
    lose_at_build(1, 1, false);
}

TEST_CLOSED(test_level_execution, close_scene)
{
    lose_at("execution");
    expect_count(1);
    expect_list("1 build was submitted");
    expect_list("submission 1.");
    assert_lacks(text_of("ASSAY-device-lost"), "copied");
}

TEST_CLOSED(test_level_state, close_scene)
{
    lose_at("state");
    expect_count(0);
}

static uint64_t count_marks(const char *level)
{
    open_at(level);
    const uint64_t before = platform.null_driver.calls("vkCmdCopyQueryPoolResults");
    record(3);
    const uint64_t marks = platform.null_driver.calls("vkCmdCopyQueryPoolResults") - before;
    close_scene();
    return marks;
}

/* Marks are made at level content only, two for each call. */
TEST(test_commands_of_marks)
{
    assert_int_equal(count_marks("content"), 6);
    assert_int_equal(count_marks("execution"), 0);
    assert_int_equal(count_marks("state"), 0);
}

/* ---- every command reports, once */

static VkSemaphore timeline;
static VkEvent event;
static VkQueryPool queries;
static uint64_t value;

CALL_AS(submit_nothing, fixture.vk.QueueSubmit(fixture.queue, 0, NULL, VK_NULL_HANDLE))
CALL_AS(submit2_nothing, fixture.vk.QueueSubmit2(fixture.queue, 0, NULL, VK_NULL_HANDLE))
CALL_AS(bind_nothing, fixture.vk.QueueBindSparse(fixture.queue, 0, NULL, VK_NULL_HANDLE))
CALL_AS(wait_for_queue, fixture.vk.QueueWaitIdle(fixture.queue))
CALL_AS(wait_for_device, fixture.vk.DeviceWaitIdle(fixture.device))
CALL_AS(wait_for_fence, fixture.vk.WaitForFences(fixture.device, 1, &fence, VK_TRUE, 0))
CALL_AS(get_fence, fixture.vk.GetFenceStatus(fixture.device, fence))
CALL_AS(wait_for_semaphore,
        fixture.vk.WaitSemaphores(fixture.device,
                                  &MAKE(VkSemaphoreWaitInfo, .semaphoreCount = 1,
                                        .pSemaphores = &timeline, .pValues = &value),
                                  0))
CALL_AS(get_semaphore,
        fixture.vk.GetSemaphoreCounterValue(fixture.device, timeline, &(uint64_t){0}))
CALL_AS(get_event, fixture.vk.GetEventStatus(fixture.device, event))
CALL_AS(get_queries, fixture.vk.GetQueryPoolResults(fixture.device, queries, 0, 1, sizeof(value),
                                                    &value, sizeof(value), VK_QUERY_RESULT_64_BIT))
CALL_AS(map_memory, fixture.vk.MapMemory(fixture.device, scene.boxes.memory, 0, VK_WHOLE_SIZE, 0,
                                         &(void *){NULL}))

static const struct {
    const char *name;
    VkResult (*call)(void);
} lossy_commands[] = {
    {"vkQueueSubmit", submit_nothing},
    {"vkQueueSubmit2", submit2_nothing},
    {"vkQueueBindSparse", bind_nothing},
    {"vkQueueWaitIdle", wait_for_queue},
    {"vkDeviceWaitIdle", wait_for_device},
    {"vkWaitForFences", wait_for_fence},
    {"vkGetFenceStatus", get_fence},
    {"vkWaitSemaphores", wait_for_semaphore},
    {"vkGetSemaphoreCounterValue", get_semaphore},
    {"vkGetEventStatus", get_event},
    {"vkGetQueryPoolResults", get_queries},
    {"vkMapMemory", map_memory},
};

static void play(const char *name, VkResult (*call)(void))
{
    const STRUCT(VkEventCreateInfo, info);
    open_at("execution");
    timeline = timeline_create(&fixture.vk, fixture.device);
    queries = query_pool_create(&fixture.vk, fixture.device, VK_QUERY_TYPE_OCCLUSION, 1);
    GET(fixture.vk.CreateEvent(fixture.device, &info, NULL, &event));
    GET(fixture_submit(&fixture, record(1), VK_NULL_HANDLE));
    fixture_expect_silence(&fixture);
    platform.null_driver.fail_next(name, VK_ERROR_DEVICE_LOST);
    if (call() != VK_ERROR_DEVICE_LOST)
        fail_msg("%s does not return VK_ERROR_DEVICE_LOST", name);
    if (fixture.instance.messages.count != 1)
        fail_msg("%s: %u messages", name, fixture.instance.messages.count);
    expect_list("1 build was submitted");
    platform.null_driver.fail_next("vkDeviceWaitIdle", VK_ERROR_DEVICE_LOST);
    assert_int_equal(wait_for_device(), VK_ERROR_DEVICE_LOST);
    expect_count(1);
    fixture.vk.DestroySemaphore(fixture.device, timeline, NULL);
    fixture.vk.DestroyQueryPool(fixture.device, queries, NULL);
    fixture.vk.DestroyEvent(fixture.device, event, NULL);
    close_scene();
}

TEST(test_every_command)
{
    for (size_t i = 0; i < ARRAY_COUNT(lossy_commands); i++)
        play(lossy_commands[i].name, lossy_commands[i].call);
}

/* The device may have executed a part of the submission at which it is lost. */
LOSS_TEST(test_lost_when_submitted)
{
    plan(NULL_DRIVER_LOSE, NULL_DRIVER_AT_SUBMIT, 2, false);
    VkCommandBuffer first = record(1), second = record(1);
    GET(fixture_submit(&fixture, first, VK_NULL_HANDLE));
    fixture_expect_silence(&fixture);
    assert_int_equal(fixture_submit(&fixture, second, VK_NULL_HANDLE), VK_ERROR_DEVICE_LOST);
    expect_list("2 builds were submitted");
    expect_list("submission 2: the device had not reached it.");
    expect_list("submission 1: it had finished.");
}

LOSS_TEST(test_lost_while_submitting)
{
    PLAN_FAULT(.kind = NULL_DRIVER_LOSE, .at = NULL_DRIVER_AT_BUILD, .is_at_once = true);
    assert_int_equal(fixture_submit(&fixture, record(1), VK_NULL_HANDLE), VK_ERROR_DEVICE_LOST);
    expect_list(": its inputs had been copied, and it had not finished.");
    assert_has(text_of("VUID"), "submission 1, read after the device was lost.");
}

/* A submission that fails in another way, or is skipped, is not listed. */
LOSS_TEST(test_failed_submissions)
{
    VkCommandBuffer commands = record(1);
    platform.null_driver.fail_next("vkQueueSubmit", VK_ERROR_OUT_OF_HOST_MEMORY);
    assert_int_equal(fixture_submit(&fixture, commands, fence), VK_ERROR_OUT_OF_HOST_MEMORY);
    platform.null_driver.set_device_lost(true);
    assert_int_equal(fixture.vk.DeviceWaitIdle(fixture.device), VK_ERROR_DEVICE_LOST);
    expect_count(0);
}
