/* SPDX-License-Identifier: Apache-2.0 */
/* Command buffers that the application goes on using while the layer still reads what they copied:
 * submitted again after ONE_TIME_SUBMIT, recorded further after their submission, reset or executed
 * by others meanwhile. All of it is a mistake of the application, which the layer survives. */
#include "tests/snapshots/fixture.h"

#include <stdio.h>
#include <string.h>

enum {
    BOXES = 20000, /* more than half of a chunk of staging memory */
    BUILDS = 12,
    STRUCTURE_SIZE = 16 << 20,
};

static struct platform platform;
static struct fixture fixture;
static struct fixture_buffer boxes, structures, scratch;
static VkAccelerationStructureKHR blas;

/* ---- the stage */

static void open_fixture(void)
{
    fixture_open(&fixture, &platform, &(struct fixture_setup){.has_layer = true});
    boxes = fixture_buffer(&fixture, BOXES * sizeof(VkAabbPositionsKHR),
                           VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR);
    structures = fixture_buffer(&fixture, STRUCTURE_SIZE,
                                VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_STORAGE_BIT_KHR);
    scratch = fixture_buffer(&fixture, STRUCTURE_SIZE, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT);
    blas = fixture_structure(&fixture, &structures, 0, STRUCTURE_SIZE,
                             VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR);
}

static void close_fixture(void)
{
    GET(fixture.vk.DeviceWaitIdle(fixture.device));
    fixture.vk.DestroyAccelerationStructureKHR(fixture.device, blas, NULL);
    fixture_destroy_buffer(&fixture, &boxes);
    fixture_destroy_buffer(&fixture, &structures);
    fixture_destroy_buffer(&fixture, &scratch);
    fixture_close(&fixture);
}

static void build(VkCommandBuffer commands, uint32_t count)
{
    fixture_build_boxes(&fixture, commands, blas, boxes.address, count,
                        (scratch.address + 255) & ~(VkDeviceAddress)255);
    fixture_barrier(&fixture, commands);
}

static VkCommandBuffer begin_secondary(VkCommandBufferUsageFlags flags)
{
    const VkCommandBufferAllocateInfo allocate = {
        .sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
        .commandPool = fixture.pool,
        .level = VK_COMMAND_BUFFER_LEVEL_SECONDARY,
        .commandBufferCount = 1,
    };
    const VkCommandBufferInheritanceInfo inheritance = {
        .sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_INHERITANCE_INFO};
    const VkCommandBufferBeginInfo begin = {
        .sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO,
        .flags = flags,
        .pInheritanceInfo = &inheritance,
    };
    VkCommandBuffer commands;
    GET(fixture.vk.AllocateCommandBuffers(fixture.device, &allocate, &commands));
    GET(fixture.vk.BeginCommandBuffer(commands, &begin));
    return commands;
}

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
            fixture.device, 1, &blas, VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_KHR,
            sizeof(size), &size, sizeof(size));
}

/* A box upside down, which level content finds if it looks. */
static void spoil_box(uint32_t i)
{
    ((VkAabbPositionsKHR *)boxes.bytes)[i] = (VkAabbPositionsKHR){.minX = 1, .maxX = -1};
}

/* So many messages, each of which says this; they are forgotten. */
static void expect_told(uint32_t count, const char *text)
{
    for (uint32_t i = 0; i < messages_kept(&fixture.messages); i++)
        if (!strstr(fixture.messages.items[i].text, text))
            fail_msg("\"%s\" is not in: %s", text, fixture.messages.items[i].text);
    assert_int_equal(fixture.messages.count, count);
    messages_clear(&fixture.messages);
}

/* ---- tests */

/* Its memory for copies went to the next command buffer when it was complete. */
static void test_one_time_submitted_twice(void **state)
{
    (void)state;
    open_fixture();
    VkCommandBuffer commands = fixture_begin(&fixture, VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT);
    spoil_box(BOXES - 1);
    build(commands, BOXES);
    GET(fixture.vk.EndCommandBuffer(commands));
    submit(commands);
    wait();
    expect_told(1, "minX");
    read_structure();
    for (int i = 0; i < 2; i++) {
        submit(commands);
        expect_told(1,
                    "assay_validation.level = content: builds are not looked at, of executions "
                    "of command buffers: 1 of command buffers that were begun with "
                    "VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT and are submitted again.");
        wait();
        read_structure();
        fixture_expect_silence(&fixture);
    }
    close_fixture();
}

/* When the first command buffer is submitted again, the memory of its copies belongs to the second.
 * It must not write there any more. */
static void test_one_time_memory_of_another(void **state)
{
    (void)state;
    open_fixture();
    struct fixture_buffer others = fixture_buffer(
        &fixture, boxes.size, VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR);
    VkCommandBuffer commands[2];
    commands[1] = fixture_begin(&fixture, VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT);
    build(commands[1], BOXES);
    GET(fixture.vk.EndCommandBuffer(commands[1]));
    submit(commands[1]);
    wait();
    read_structure();
    fixture_expect_silence(&fixture);
    spoil_box(0);
    commands[0] = fixture_begin(&fixture, VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT);
    fixture_build_boxes(&fixture, commands[0], blas, others.address, BOXES,
                        (scratch.address + 255) & ~(VkDeviceAddress)255);
    fixture_barrier(&fixture, commands[0]);
    GET(fixture.vk.EndCommandBuffer(commands[0]));
    const VkSubmitInfo both = {.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO,
                               .commandBufferCount = 2,
                               .pCommandBuffers = commands};
    GET(fixture.vk.QueueSubmit(fixture.queue, 1, &both, VK_NULL_HANDLE));
    wait();
    read_structure();
    expect_told(1, "submitted again");
    fixture_destroy_buffer(&fixture, &others);
    close_fixture();
}

/* The second execution is looked at if the layer still has the copies: on backend cpu they belong
 * to the structure. */
static void test_one_time_submitted_twice_at_once(void **state)
{
    (void)state;
    open_fixture();
    VkCommandBuffer commands = fixture_begin(&fixture, VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT);
    spoil_box(0);
    build(commands, 1);
    GET(fixture.vk.EndCommandBuffer(commands));
    submit(commands);
    submit(commands);
    wait();
    expect_told(2, platform.is_cpu ? "minX" : "");
    read_structure();
    close_fixture();
}

static void test_secondary_one_time_submitted_twice(void **state)
{
    (void)state;
    open_fixture();
    VkCommandBuffer primary = fixture_begin(&fixture, 0);
    VkCommandBuffer secondary = begin_secondary(VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT);
    spoil_box(0);
    build(secondary, 1);
    GET(fixture.vk.EndCommandBuffer(secondary));
    fixture.vk.CmdExecuteCommands(primary, 1, &secondary);
    build(primary, 1);
    GET(fixture.vk.EndCommandBuffer(primary));
    submit(primary);
    wait();
    expect_told(2, "minX");
    submit(primary);
    wait();
    expect_told(2, platform.is_cpu ? "minX" : "");
    read_structure();
    close_fixture();
}

/* What is recorded further finds the old copies gone, and does not take their place. */
static void test_one_time_recorded_further(void **state)
{
    (void)state;
    open_fixture();
    VkCommandBuffer commands = fixture_begin(&fixture, VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT);
    build(commands, BOXES);
    GET(fixture.vk.EndCommandBuffer(commands));
    submit(commands);
    wait();
    read_structure();
    fixture_expect_silence(&fixture);
    build(commands, BOXES);
    messages_clear(&fixture.messages); /* it isn't in the recording state */
    submit(commands);
    expect_told(platform.is_cpu ? 1 : 2, "looked at");
    wait();
    read_structure();
    fixture_expect_silence(&fixture);
    close_fixture();
}

/* The execution has the copies of the first build alone; those of the others take chunks of their
 * own. */
static void test_recorded_further_after_submission(void **state)
{
    (void)state;
    open_fixture();
    VkCommandBuffer commands = fixture_begin(&fixture, 0);
    spoil_box(0);
    build(commands, BOXES);
    submit(commands);
    for (int i = 1; i < BUILDS; i++)
        build(commands, BOXES);
    read_structure();
    wait();
    expect_told(1, "minX");
    GET(fixture.vk.EndCommandBuffer(commands));
    submit(commands);
    wait();
    read_structure();
    expect_told(9, "minX"); /* the tenth and last that duplicate_message_limit allows */
    close_fixture();
}

/* The first execution is copied to make room for the second, while the recording has more. */
static void test_recorded_further_and_submitted_again(void **state)
{
    (void)state;
    open_fixture();
    VkCommandBuffer commands = fixture_begin(&fixture, 0);
    build(commands, BOXES);
    submit(commands);
    for (int i = 1; i < BUILDS; i++)
        build(commands, BOXES);
    GET(fixture.vk.EndCommandBuffer(commands));
    submit(commands);
    wait();
    read_structure();
    fixture_expect_silence(&fixture);
    close_fixture();
}

/* More secondaries than the execution has children. */
static void test_secondaries_executed_after_submission(void **state)
{
    (void)state;
    open_fixture();
    VkCommandBuffer primary = fixture_begin(&fixture, 0), secondaries[BUILDS];
    spoil_box(0);
    for (int i = 0; i < BUILDS; i++) {
        secondaries[i] = begin_secondary(VK_COMMAND_BUFFER_USAGE_SIMULTANEOUS_USE_BIT);
        build(secondaries[i], 1);
        GET(fixture.vk.EndCommandBuffer(secondaries[i]));
    }
    fixture.vk.CmdExecuteCommands(primary, 1, secondaries);
    submit(primary);
    fixture.vk.CmdExecuteCommands(primary, BUILDS - 1, secondaries + 1);
    wait();
    expect_told(1, "minX");
    read_structure();
    GET(fixture.vk.EndCommandBuffer(primary));
    close_fixture();
}

/* A secondary is recorded further after the primary that executes it was recorded, and again after
 * that was submitted. */
static void test_secondary_recorded_further(void **state)
{
    (void)state;
    open_fixture();
    VkCommandBuffer primary = fixture_begin(&fixture, 0);
    VkCommandBuffer secondary = begin_secondary(VK_COMMAND_BUFFER_USAGE_SIMULTANEOUS_USE_BIT);
    build(secondary, BOXES);
    fixture.vk.CmdExecuteCommands(primary, 1, &secondary);
    GET(fixture.vk.EndCommandBuffer(primary));
    for (int round = 0; round < 2; round++) {
        for (int i = 0; i < BUILDS; i++)
            build(secondary, BOXES);
        submit(primary);
    }
    for (int i = 0; i < BUILDS; i++)
        build(secondary, BOXES);
    wait();
    read_structure();
    GET(fixture.vk.EndCommandBuffer(secondary));
    fixture_expect_silence(&fixture);
    close_fixture();
}

/* What was copied is still looked at. */
static void test_reset_before_the_wait(void **state)
{
    (void)state;
    open_fixture();
    const VkCommandBufferBeginInfo begin = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
    VkCommandBuffer primary = fixture_begin(&fixture, 0);
    VkCommandBuffer secondary = begin_secondary(VK_COMMAND_BUFFER_USAGE_SIMULTANEOUS_USE_BIT);
    spoil_box(0);
    build(secondary, 1);
    GET(fixture.vk.EndCommandBuffer(secondary));
    fixture.vk.CmdExecuteCommands(primary, 1, &secondary);
    build(primary, 1);
    GET(fixture.vk.EndCommandBuffer(primary));
    submit(primary);
    GET(fixture.vk.ResetCommandBuffer(secondary, 0));
    GET(fixture.vk.BeginCommandBuffer(primary, &begin));
    for (int i = 0; i < BUILDS; i++)
        build(primary, BOXES);
    wait();
    expect_told(2, "minX");
    read_structure();
    GET(fixture.vk.EndCommandBuffer(primary));
    fixture.vk.FreeCommandBuffers(fixture.device, fixture.pool, 1, &secondary);
    fixture_expect_silence(&fixture);
    close_fixture();
}

/* Command buffers that execute themselves, or each other, have no end. */
static void test_executed_in_circles(void **state)
{
    (void)state;
    open_fixture();
    VkCommandBuffer primary = fixture_begin(&fixture, 0), secondaries[2];
    for (int i = 0; i < 2; i++) {
        secondaries[i] = begin_secondary(VK_COMMAND_BUFFER_USAGE_SIMULTANEOUS_USE_BIT);
        build(secondaries[i], 1);
    }
    build(primary, 1);
    fixture.vk.CmdExecuteCommands(secondaries[0], 1, &secondaries[0]);
    fixture.vk.CmdExecuteCommands(secondaries[0], 1, &secondaries[1]);
    fixture.vk.CmdExecuteCommands(secondaries[1], 1, &secondaries[0]);
    fixture.vk.CmdExecuteCommands(primary, 2, secondaries);
    fixture.vk.CmdExecuteCommands(primary, 1, &primary);
    submit(primary);
    wait();
    read_structure();
    close_fixture();
}

int main(int argc, char **argv)
{
    const char *reason = platform_open(&platform, argc > 1 ? argv[1] : "null");
    if (reason) {
        puts(reason);
        return 77;
    }
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_one_time_submitted_twice),
        cmocka_unit_test(test_one_time_memory_of_another),
        cmocka_unit_test(test_one_time_submitted_twice_at_once),
        cmocka_unit_test(test_secondary_one_time_submitted_twice),
        cmocka_unit_test(test_one_time_recorded_further),
        cmocka_unit_test(test_recorded_further_after_submission),
        cmocka_unit_test(test_recorded_further_and_submitted_again),
        cmocka_unit_test(test_secondaries_executed_after_submission),
        cmocka_unit_test(test_secondary_recorded_further),
    };
    /* What other drivers need not bear. */
    const struct CMUnitTest null_driver_tests[] = {
        cmocka_unit_test(test_reset_before_the_wait),
        cmocka_unit_test(test_executed_in_circles),
    };
    int failures = cmocka_run_group_tests(tests, NULL, NULL);
    if (platform.is_null)
        failures += cmocka_run_group_tests(null_driver_tests, NULL, NULL);
    return failures;
}
