/* SPDX-License-Identifier: Apache-2.0 */
/* Command buffers that the application goes on using while the layer still reads what they copied:
 * submitted again after ONE_TIME_SUBMIT, recorded further after their submission, reset or executed
 * by others meanwhile. All of it is a mistake of the application, which the layer survives. */
#include "tests/snapshots/scene.h"

enum {
    BOXES = 20000, /* more than half of a chunk of staging memory */
    BUILDS = 12,
    STRUCTURE_SIZE = 16 << 20,
};

static void open_scene(void)
{
    SCENE_OPEN(.boxes_size = BOXES * sizeof(VkAabbPositionsKHR), .structure_size = STRUCTURE_SIZE);
}

#define LIFETIME_TEST(name) TEST_BETWEEN_IF(name, open_scene, scene_wait_and_close, true)

static void submit(VkCommandBuffer commands)
{
    GET(fixture_submit(&fixture, commands, VK_NULL_HANDLE));
}

static void wait(void)
{
    GET(fixture.vk.DeviceWaitIdle(fixture.device));
}

/* Backend cpu makes the structure now, of what the command buffer copied. */
static void read_structure(void)
{
    VkDeviceSize size;
    if (platform.is_cpu)
        fixture.vk.WriteAccelerationStructuresPropertiesKHR(
            fixture.device, 1, &scene.blas,
            VK_QUERY_TYPE_ACCELERATION_STRUCTURE_SERIALIZATION_SIZE_KHR, sizeof(size), &size,
            sizeof(size));
}

static void wait_and_read_structure(void)
{
    wait();
    read_structure();
}

static VkCommandBuffer record_secondary(VkCommandBufferUsageFlags flags)
{
    VkCommandBuffer secondary = fixture_begin_secondary(&fixture, flags);
    scene_build_boxes(secondary, 1);
    GET(fixture.vk.EndCommandBuffer(secondary));
    return secondary;
}

/* Its memory for copies went to the next command buffer when it was complete. */
LIFETIME_TEST(test_one_time_submitted_twice)
{
    scene_invalidate_box(BOXES - 1);
    VkCommandBuffer commands =
        scene_record_boxes(VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT, BOXES);
    scene_submit(commands);
    wait();
    expect_messages(1, "minX");
    read_structure();
    for (int i = 0; i < 2; i++) {
        submit(commands);
        expect_messages(
            1,
            "assay_validation.level = content: builds are unchecked in these executions "
            "of command buffers: 1 of command buffers that were begun with "
            "VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT and are submitted again.");
        wait_and_read_structure();
        fixture_expect_silence(&fixture);
    }
}

/* When the first command buffer is submitted again, the memory of its copies belongs to the second.
 * It must not write there any more. */
LIFETIME_TEST(test_one_time_memory_of_another)
{
    struct device_buffer others = scene_input(scene.boxes.size);
    VkCommandBuffer commands[2];
    commands[1] = fixture_begin(&fixture, VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT);
    scene_build_boxes(commands[1], BOXES);
    scene_submit(commands[1]);
    wait_and_read_structure();
    fixture_expect_silence(&fixture);
    scene_invalidate_box(0);
    commands[0] = fixture_begin(&fixture, VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT);
    fixture_build_boxes(&fixture, commands[0], scene.blas, others.address, BOXES,
                        scene.scratch_address);
    fixture_barrier(&fixture, commands[0]);
    GET(fixture.vk.EndCommandBuffer(commands[0]));
    const STRUCT(VkSubmitInfo, both, .commandBufferCount = 2, .pCommandBuffers = commands);
    GET(fixture.vk.QueueSubmit(fixture.queue, 1, &both, VK_NULL_HANDLE));
    wait_and_read_structure();
    expect_messages(1, "submitted again");
    fixture_destroy_buffer(&fixture, &others);
}

/* The second execution is looked at if the layer still has the copies: on backend cpu they belong
 * to the structure. */
LIFETIME_TEST(test_one_time_submitted_twice_at_once)
{
    scene_invalidate_box(0);
    VkCommandBuffer commands = scene_record_boxes(VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT, 1);
    scene_submit(commands);
    submit(commands);
    wait();
    expect_messages(2, platform.is_cpu ? "minX" : "");
    read_structure();
}

LIFETIME_TEST(test_secondary_one_time_submitted_twice)
{
    VkCommandBuffer primary = fixture_begin(&fixture, 0);
    scene_invalidate_box(0);
    VkCommandBuffer secondary = record_secondary(VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT);
    fixture.vk.CmdExecuteCommands(primary, 1, &secondary);
    scene_build_boxes(primary, 1);
    scene_submit(primary);
    wait();
    expect_messages(2, "minX");
    submit(primary);
    wait();
    expect_messages(2, platform.is_cpu ? "minX" : "");
    read_structure();
}

/* What is recorded further finds the old copies gone, and does not take their place. */
LIFETIME_TEST(test_one_time_recorded_further)
{
    VkCommandBuffer commands =
        scene_record_boxes(VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT, BOXES);
    scene_submit(commands);
    wait_and_read_structure();
    fixture_expect_silence(&fixture);
    scene_build_boxes(commands, BOXES);
    messages_clear(&fixture.instance.messages); /* it isn't in the recording state */
    submit(commands);
    expect_messages(platform.is_cpu ? 1 : 2, "unchecked");
    wait_and_read_structure();
    fixture_expect_silence(&fixture);
}

/* The execution has the copies of the first build alone; those of the others take chunks of their
 * own. */
LIFETIME_TEST(test_recorded_further_after_submission)
{
    scene_invalidate_box(0);
    VkCommandBuffer commands = scene_record_boxes(0, BOXES);
    submit(commands);
    for (int i = 1; i < BUILDS; i++)
        scene_build_boxes(commands, BOXES);
    read_structure();
    wait();
    expect_messages(1, "minX");
    scene_submit(commands);
    wait_and_read_structure();
    expect_messages(9, "minX"); /* the tenth and last that duplicate_message_limit allows */
}

/* The first execution is copied to make room for the second, while the recording has more. */
LIFETIME_TEST(test_recorded_further_and_submitted_again)
{
    VkCommandBuffer commands = scene_record_boxes(0, BOXES);
    submit(commands);
    for (int i = 1; i < BUILDS; i++)
        scene_build_boxes(commands, BOXES);
    scene_submit(commands);
    wait_and_read_structure();
    fixture_expect_silence(&fixture);
}

/* More secondaries than the execution has children. */
LIFETIME_TEST(test_secondaries_executed_after_submission)
{
    VkCommandBuffer primary = fixture_begin(&fixture, 0), secondaries[BUILDS];
    scene_invalidate_box(0);
    for (int i = 0; i < BUILDS; i++)
        secondaries[i] = record_secondary(VK_COMMAND_BUFFER_USAGE_SIMULTANEOUS_USE_BIT);
    fixture.vk.CmdExecuteCommands(primary, 1, secondaries);
    submit(primary);
    fixture.vk.CmdExecuteCommands(primary, BUILDS - 1, secondaries + 1);
    wait();
    expect_messages(1, "minX");
    read_structure();
    GET(fixture.vk.EndCommandBuffer(primary));
}

/* A secondary is recorded further after the primary that executes it was recorded, and again after
 * that was submitted. */
LIFETIME_TEST(test_secondary_recorded_further)
{
    VkCommandBuffer primary = fixture_begin(&fixture, 0);
    VkCommandBuffer secondary =
        fixture_begin_secondary(&fixture, VK_COMMAND_BUFFER_USAGE_SIMULTANEOUS_USE_BIT);
    scene_build_boxes(secondary, BOXES);
    fixture.vk.CmdExecuteCommands(primary, 1, &secondary);
    GET(fixture.vk.EndCommandBuffer(primary));
    for (int round = 0; round < 2; round++) {
        for (int i = 0; i < BUILDS; i++)
            scene_build_boxes(secondary, BOXES);
        if (round != 0)
            GET(fixture.vk.QueueWaitIdle(fixture.queue));
        submit(primary);
    }
    for (int i = 0; i < BUILDS; i++)
        scene_build_boxes(secondary, BOXES);
    wait_and_read_structure();
    GET(fixture.vk.EndCommandBuffer(secondary));
    fixture_expect_silence(&fixture);
}

/* What other drivers need not bear. */
#define NULL_DRIVER_TEST(name)                                                                     \
    TEST_BETWEEN_IF(name, open_scene, scene_wait_and_close, platform.is_null)

/* What was copied is still looked at. */
NULL_DRIVER_TEST(test_reset_before_the_wait)
{
    const STRUCT(VkCommandBufferBeginInfo, begin);
    VkCommandBuffer primary = fixture_begin(&fixture, 0);
    scene_invalidate_box(0);
    VkCommandBuffer secondary = record_secondary(VK_COMMAND_BUFFER_USAGE_SIMULTANEOUS_USE_BIT);
    fixture.vk.CmdExecuteCommands(primary, 1, &secondary);
    scene_build_boxes(primary, 1);
    scene_submit(primary);
    GET(fixture.vk.ResetCommandBuffer(secondary, 0));
    GET(fixture.vk.BeginCommandBuffer(primary, &begin));
    for (int i = 0; i < BUILDS; i++)
        scene_build_boxes(primary, BOXES);
    wait();
    expect_messages(2, "minX");
    read_structure();
    GET(fixture.vk.EndCommandBuffer(primary));
    fixture.vk.FreeCommandBuffers(fixture.device, fixture.pool, 1, &secondary);
    fixture_expect_silence(&fixture);
}

/* Command buffers that execute themselves, or each other, have no end. */
NULL_DRIVER_TEST(test_executed_in_circles)
{
    VkCommandBuffer primary = fixture_begin(&fixture, 0), secondaries[2];
    for (int i = 0; i < 2; i++) {
        secondaries[i] =
            fixture_begin_secondary(&fixture, VK_COMMAND_BUFFER_USAGE_SIMULTANEOUS_USE_BIT);
        scene_build_boxes(secondaries[i], 1);
    }
    scene_build_boxes(primary, 1);
    fixture.vk.CmdExecuteCommands(secondaries[0], 1, &secondaries[0]);
    fixture.vk.CmdExecuteCommands(secondaries[0], 1, &secondaries[1]);
    fixture.vk.CmdExecuteCommands(secondaries[1], 1, &secondaries[0]);
    fixture.vk.CmdExecuteCommands(primary, 2, secondaries);
    fixture.vk.CmdExecuteCommands(primary, 1, &primary);
    submit(primary);
    wait_and_read_structure();
}
