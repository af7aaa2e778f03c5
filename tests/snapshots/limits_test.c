/* SPDX-License-Identifier: Apache-2.0 */
/* Where level content ends: its budget, what it can't read in time, and places where it adds
 * nothing; each is told, and none disturbs the application. */
#include "stage.h"

#include <stdio.h>
#include <string.h>
#include <time.h>

#include "layer/assay.h"

enum {
    BOXES = 40000, /* close to a MiB */
    BUILDS = 4,
    STRUCTURE_SIZE = 16 << 20,
    SCRATCH_SIZE = 16 << 20,
};

static struct platform platform;
static struct stage stage;
static struct stage_buffer boxes, structures, scratch;
static VkAccelerationStructureKHR blas;

/* ---- the stage */

static void open_stage(const struct stage_setup *setup)
{
    stage_open(&stage, &platform, setup);
    boxes = stage_buffer(&stage, BOXES * sizeof(VkAabbPositionsKHR),
                         VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR);
    structures = stage_buffer(&stage, STRUCTURE_SIZE,
                              VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_STORAGE_BIT_KHR);
    scratch = stage_buffer(&stage, SCRATCH_SIZE, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT);
    blas = stage_structure(&stage, &structures, 0, STRUCTURE_SIZE,
                           VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR);
}

static void close_stage(void)
{
    stage.vk.DestroyAccelerationStructureKHR(stage.device, blas, NULL);
    stage_destroy_buffer(&stage, &boxes);
    stage_destroy_buffer(&stage, &structures);
    stage_destroy_buffer(&stage, &scratch);
    stage_close(&stage);
}

static void build(VkCommandBuffer commands, uint32_t count)
{
    stage_build_boxes(&stage, commands, blas, boxes.address, count,
                      (scratch.address + 255) & ~(VkDeviceAddress)255);
    stage_barrier(&stage, commands);
}

static uint64_t bytes_copied(void)
{
    PFN_vkGetCountersASSAY get =
        (PFN_vkGetCountersASSAY)stage.get_device_proc_addr(stage.device, "vkGetCountersASSAY");
    AssayCounters counters;
    assert_non_null(get);
    get(stage.device, sizeof(counters), &counters);
    return counters.bytesSnapshot;
}

/* One message, which says this; it is forgotten. */
static void expect_told(const char *text)
{
    if (stage.messages.count != 1)
        fail_msg("%u messages: %s", stage.messages.count, stage.messages.items[0].text);
    if (!strstr(stage.messages.items[0].text, text))
        fail_msg("\"%s\" is not in: %s", text, stage.messages.items[0].text);
    messages_clear(&stage.messages);
}

/* A box upside down in the last build, which level content finds if it looks. */
static void spoil_box(uint32_t i)
{
    ((VkAabbPositionsKHR *)boxes.bytes)[i] = (VkAabbPositionsKHR){.minX = 1, .maxX = -1};
}

/* ---- tests */

static void test_only_builds_cost(void **state)
{
    (void)state;
    open_stage(&(struct stage_setup){.has_layer = true});
    VkCommandBuffer commands = stage_begin(&stage, 0);
    stage_barrier(&stage, commands);
    stage_finish(&stage, commands);
    assert_int_equal(bytes_copied(), 0);
    commands = stage_begin(&stage, 0);
    build(commands, 3);
    build(commands, 0);
    stage_finish(&stage, commands);
    assert_int_equal(bytes_copied(), 3 * sizeof(VkAabbPositionsKHR));
    stage_expect_silence(&stage);
    close_stage();
}

/* Beyond the budget builds are left out, by position; those before are looked at. */
static void test_skipped_beyond_budget(void **state)
{
    (void)state;
    open_stage(&(struct stage_setup){.has_layer = true, .budget_mib = "2", .when_full = "skip"});
    VkCommandBuffer commands = stage_begin(&stage, 0);
    for (int i = 0; i < BUILDS; i++)
        build(commands, BOXES);
    stage_finish(&stage, commands);
    assert_int_equal(bytes_copied(), 2 * BOXES * sizeof(VkAabbPositionsKHR));
    expect_told("build 2 (beyond content_budget_mib), build 3 (beyond content_budget_mib)");
    commands = stage_begin(&stage, 0);
    build(commands, BOXES);
    stage_finish(&stage, commands);
    assert_int_equal(bytes_copied(), 3 * BOXES * sizeof(VkAabbPositionsKHR));
    stage_expect_silence(&stage);
    close_stage();
}

/* What executes once gives its memory back once it is complete, without the application's help. */
static void test_waits_for_budget(void **state)
{
    (void)state;
    open_stage(&(struct stage_setup){.has_layer = true, .budget_mib = "2", .when_full = "wait"});
    VkCommandBuffer commands[BUILDS];
    for (int i = 0; i < BUILDS; i++) {
        commands[i] = stage_begin(&stage, VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT);
        build(commands[i], BOXES);
        GET(stage.vk.EndCommandBuffer(commands[i]));
        GET(stage_submit(&stage, commands[i], VK_NULL_HANDLE));
    }
    GET(stage.vk.DeviceWaitIdle(stage.device));
    assert_int_equal(bytes_copied(), BUILDS * BOXES * sizeof(VkAabbPositionsKHR));
    stage_expect_silence(&stage);
    close_stage();
}

/* A command buffer that may be pending twice, and waits for the host: to wait for its first
 * execution would be for ever. */
static void test_submits_again_while_pending(void **state)
{
    (void)state;
    open_stage(&(struct stage_setup){.has_layer = true});
    VkSemaphore semaphore = stage_timeline(&stage);
    VkCommandBuffer commands = stage_begin(&stage, VK_COMMAND_BUFFER_USAGE_SIMULTANEOUS_USE_BIT);
    spoil_box(0);
    build(commands, 1);
    GET(stage.vk.EndCommandBuffer(commands));
    stage_submit_waiting(&stage, commands, semaphore, VK_NULL_HANDLE);
    stage_expect_silence(&stage);
    stage_submit_waiting(&stage, commands, semaphore, VK_NULL_HANDLE);
    expect_told("1 of command buffers that are submitted again before they are complete");
    const VkSemaphoreSignalInfo signal = {
        .sType = VK_STRUCTURE_TYPE_SEMAPHORE_SIGNAL_INFO, .semaphore = semaphore, .value = 1};
    GET(stage.vk.SignalSemaphore(stage.device, &signal));
    GET(stage.vk.DeviceWaitIdle(stage.device));
    expect_told("minX");
    stage.vk.DestroySemaphore(stage.device, semaphore, NULL);
    close_stage();
}

static void test_twice_in_a_submission(void **state)
{
    (void)state;
    open_stage(&(struct stage_setup){.has_layer = true});
    VkCommandBuffer commands = stage_begin(&stage, VK_COMMAND_BUFFER_USAGE_SIMULTANEOUS_USE_BIT);
    spoil_box(0);
    build(commands, 1);
    GET(stage.vk.EndCommandBuffer(commands));
    const VkCommandBuffer twice[] = {commands, commands};
    const VkSubmitInfo info = {
        .sType = VK_STRUCTURE_TYPE_SUBMIT_INFO, .commandBufferCount = 2, .pCommandBuffers = twice};
    GET(stage.vk.QueueSubmit(stage.queue, 1, &info, VK_NULL_HANDLE));
    expect_told("1 followed by another of the same command buffer in the submission");
    GET(stage.vk.QueueWaitIdle(stage.queue));
    expect_told("minX");
    close_stage();
}

/* Resubmitted when it is complete, each execution is looked at by itself. */
static void test_submits_again(void **state)
{
    (void)state;
    open_stage(&(struct stage_setup){.has_layer = true});
    VkCommandBuffer commands = stage_begin(&stage, 0);
    build(commands, 2);
    GET(stage.vk.EndCommandBuffer(commands));
    VkFence fence = stage_fence(&stage);
    for (uint32_t i = 0; i < 2; i++) {
        spoil_box(i);
        GET(stage_submit(&stage, commands, fence));
        GET(stage.vk.WaitForFences(stage.device, 1, &fence, VK_TRUE, UINT64_MAX));
        GET(stage.vk.ResetFences(stage.device, 1, &fence));
        expect_told("minX");
        memset(boxes.bytes, 0, 2 * sizeof(VkAabbPositionsKHR));
    }
    GET(stage_submit(&stage, commands, fence));
    GET(stage.vk.WaitForFences(stage.device, 1, &fence, VK_TRUE, UINT64_MAX));
    stage_expect_silence(&stage);
    stage.vk.DestroyFence(stage.device, fence, NULL);
    close_stage();
}

/* The layer doesn't see that the application knows the end of its work, as it doesn't see events.
 * The device's destruction brings what is left. */
static void test_tells_at_destruction(void **state)
{
    (void)state;
    const VkEventCreateInfo info = {.sType = VK_STRUCTURE_TYPE_EVENT_CREATE_INFO};
    VkEvent event;
    open_stage(&(struct stage_setup){.has_layer = true});
    GET(stage.vk.CreateEvent(stage.device, &info, NULL, &event));
    VkCommandBuffer commands = stage_begin(&stage, 0);
    spoil_box(0);
    build(commands, 1);
    stage.vk.CmdSetEvent(commands, event, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT);
    GET(stage.vk.EndCommandBuffer(commands));
    GET(stage_submit(&stage, commands, VK_NULL_HANDLE));
    while (stage.vk.GetEventStatus(stage.device, event) != VK_EVENT_SET)
        continue;
    nanosleep(&(struct timespec){.tv_nsec = 100 * 1000 * 1000}, NULL);
    stage_expect_silence(&stage);
    stage.vk.DestroyEvent(stage.device, event, NULL);
    close_stage();
    expect_told("minX");
}

static void test_not_without_its_level(void **state)
{
    (void)state;
    open_stage(&(struct stage_setup){.has_layer = false});
    assert_null(stage.get_device_proc_addr(stage.device, "vkGetCountersASSAY"));
    close_stage();
}

int main(int argc, char **argv)
{
    const char *reason = platform_open(&platform, argc > 1 ? argv[1] : "lavapipe");
    if (reason) {
        puts(reason);
        return 77;
    }
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_only_builds_cost),
        cmocka_unit_test(test_skipped_beyond_budget),
        cmocka_unit_test(test_waits_for_budget),
        cmocka_unit_test(test_submits_again_while_pending),
        cmocka_unit_test(test_twice_in_a_submission),
        cmocka_unit_test(test_submits_again),
        cmocka_unit_test(test_tells_at_destruction),
        cmocka_unit_test(test_not_without_its_level),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
