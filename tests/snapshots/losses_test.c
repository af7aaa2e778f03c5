/* SPDX-License-Identifier: Apache-2.0 */
/* Executions that level content can't look at because nobody knows when they had their turn, or
 * because the device is lost: each is told. On the null driver, which waits for nothing. */
#include "stage.h"

#include <stdio.h>
#include <string.h>

enum { BUFFER_SIZE = 1 << 16 };

#define LEFT_OUT                                                                                   \
    "assay_validation.level = content: builds are not looked at, of executions of command "        \
    "buffers: "

static struct platform platform;
static struct stage stage;
static struct stage_buffer boxes, structures, scratch;
static VkAccelerationStructureKHR blas;
static VkSemaphore timeline; /* nobody signals it */
static VkFence fence;

/* ---- the stage */

static void open_stage(void)
{
    stage_open(&stage, &platform, &(struct stage_setup){.has_layer = true});
    boxes = stage_buffer(&stage, BUFFER_SIZE,
                         VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR);
    structures =
        stage_buffer(&stage, BUFFER_SIZE, VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_STORAGE_BIT_KHR);
    scratch = stage_buffer(&stage, BUFFER_SIZE, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT);
    blas = stage_structure(&stage, &structures, 0, BUFFER_SIZE,
                           VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR);
    timeline = stage_timeline(&stage);
    fence = stage_fence(&stage);
    ((VkAabbPositionsKHR *)boxes.bytes)[0] = (VkAabbPositionsKHR){.minX = 1, .maxX = -1};
}

/* Without its semaphore, whose end ends waits for it. */
static void close_rest(void)
{
    stage.vk.DestroyFence(stage.device, fence, NULL);
    stage.vk.DestroyAccelerationStructureKHR(stage.device, blas, NULL);
    stage_destroy_buffer(&stage, &boxes);
    stage_destroy_buffer(&stage, &structures);
    stage_destroy_buffer(&stage, &scratch);
    stage_close(&stage);
}

static void close_stage(void)
{
    stage.vk.DestroySemaphore(stage.device, timeline, NULL);
    close_rest();
}

static VkCommandBuffer record(void)
{
    VkCommandBuffer commands = stage_begin(&stage, 0);
    stage_build_boxes(&stage, commands, blas, boxes.address, 1,
                      (scratch.address + 255) & ~(VkDeviceAddress)255);
    GET(stage.vk.EndCommandBuffer(commands));
    return commands;
}

static VkResult wait(void)
{
    return stage.vk.WaitForFences(stage.device, 1, &fence, VK_TRUE, UINT64_MAX);
}

/* One message, which begins so; it is forgotten. */
static void expect_told(const char *text)
{
    if (stage.messages.count != 1)
        fail_msg("%u messages: %s", stage.messages.count, stage.messages.items[0].text);
    if (strncmp(stage.messages.items[0].text, text, strlen(text)) != 0)
        fail_msg("\"%s\" is not how this begins: %s", text, stage.messages.items[0].text);
    messages_clear(&stage.messages);
}

/* ---- tests */

static void test_complete_for_no_known_reason(void **state)
{
    (void)state;
    open_stage();
    VkCommandBuffer first = record(), second = record();
    stage_submit_waiting(&stage, first, timeline, fence);
    stage_expect_silence(&stage);
    GET(wait());
    expect_told(LEFT_OUT
                "1, and all from now on, whose order isn't known (something is complete "
                "whose wait nothing known has ended).");
    GET(stage_submit(&stage, second, VK_NULL_HANDLE));
    GET(stage.vk.DeviceWaitIdle(stage.device));
    stage_expect_silence(&stage);
    close_stage();
    stage_expect_silence(&stage);
}

/* What is submitted first after the loss is what there is to tell of. */
static void test_nothing_left_out_until_later(void **state)
{
    (void)state;
    open_stage();
    VkCommandBuffer nothing = stage_begin(&stage, 0), commands = record();
    GET(stage.vk.EndCommandBuffer(nothing));
    stage_submit_waiting(&stage, nothing, timeline, fence);
    GET(wait());
    stage_expect_silence(&stage);
    GET(stage_submit(&stage, commands, VK_NULL_HANDLE));
    expect_told(LEFT_OUT "1, and all from now on,");
    close_stage();
    stage_expect_silence(&stage);
}

static void test_device_lost(void **state)
{
    (void)state;
    open_stage();
    GET(stage_submit(&stage, record(), fence));
    stage_expect_silence(&stage);
    platform.null_driver.set_device_lost(true);
    assert_int_equal(wait(), VK_ERROR_DEVICE_LOST);
    expect_told(LEFT_OUT "1 on a device that is lost.");
    close_stage();
    platform.null_driver.set_device_lost(false);
    stage_expect_silence(&stage);
}

static void test_held_to_the_end(void **state)
{
    (void)state;
    open_stage();
    stage_submit_waiting(&stage, record(), timeline, fence);
    stage_expect_silence(&stage);
    close_rest();
    expect_told(LEFT_OUT "1 behind waits for signals that weren't submitted.");
}

int main(void)
{
    const char *reason = platform_open(&platform, "null");
    if (reason) {
        puts(reason);
        return 77;
    }
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_complete_for_no_known_reason),
        cmocka_unit_test(test_nothing_left_out_until_later),
        cmocka_unit_test(test_device_lost),
        cmocka_unit_test(test_held_to_the_end),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
