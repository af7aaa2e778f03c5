/* SPDX-License-Identifier: Apache-2.0 */
/* Where level content ends: its budget, what it can't read in time, and places where it adds
 * nothing; each is told, and none disturbs the application. */
#include "tests/snapshots/fixture.h"

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
static struct fixture fixture;
static struct fixture_buffer boxes, structures, scratch;
static VkAccelerationStructureKHR blas;

/* ---- the stage */

static void open_fixture(const struct fixture_setup *setup)
{
    fixture_open(&fixture, &platform, setup);
    boxes = fixture_buffer(&fixture, BOXES * sizeof(VkAabbPositionsKHR),
                           VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR);
    structures = fixture_buffer(&fixture, STRUCTURE_SIZE,
                                VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_STORAGE_BIT_KHR);
    scratch = fixture_buffer(&fixture, SCRATCH_SIZE, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT);
    blas = fixture_structure(&fixture, &structures, 0, STRUCTURE_SIZE,
                             VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR);
}

static void close_fixture(void)
{
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

static uint64_t bytes_copied(void)
{
    PFN_vkGetCountersASSAY get =
        (PFN_vkGetCountersASSAY)fixture.get_device_proc_addr(fixture.device, "vkGetCountersASSAY");
    AssayCounters counters;
    assert_non_null(get);
    get(fixture.device, sizeof(counters), &counters);
    return counters.bytesSnapshot;
}

/* One message, which says this; it is forgotten. */
static void expect_told(const char *text)
{
    if (fixture.messages.count != 1)
        fail_msg("%u messages: %s", fixture.messages.count, fixture.messages.items[0].text);
    if (!strstr(fixture.messages.items[0].text, text))
        fail_msg("\"%s\" is not in: %s", text, fixture.messages.items[0].text);
    messages_clear(&fixture.messages);
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
    open_fixture(&(struct fixture_setup){.has_layer = true});
    VkCommandBuffer commands = fixture_begin(&fixture, 0);
    fixture_barrier(&fixture, commands);
    fixture_finish(&fixture, commands);
    assert_int_equal(bytes_copied(), 0);
    commands = fixture_begin(&fixture, 0);
    build(commands, 3);
    build(commands, 0);
    fixture_finish(&fixture, commands);
    assert_int_equal(bytes_copied(), 3 * sizeof(VkAabbPositionsKHR));
    fixture_expect_silence(&fixture);
    close_fixture();
}

/* Beyond the budget builds are left out, by position; those before are looked at. */
static void test_skipped_beyond_budget(void **state)
{
    (void)state;
    open_fixture(
        &(struct fixture_setup){.has_layer = true, .budget_mib = "2", .when_full = "skip"});
    VkCommandBuffer commands = fixture_begin(&fixture, 0);
    for (int i = 0; i < BUILDS; i++)
        build(commands, BOXES);
    fixture_finish(&fixture, commands);
    assert_int_equal(bytes_copied(), 2 * BOXES * sizeof(VkAabbPositionsKHR));
    expect_told("build 2 (beyond content_budget_mib), build 3 (beyond content_budget_mib)");
    commands = fixture_begin(&fixture, 0);
    build(commands, BOXES);
    fixture_finish(&fixture, commands);
    assert_int_equal(bytes_copied(), 3 * BOXES * sizeof(VkAabbPositionsKHR));
    fixture_expect_silence(&fixture);
    close_fixture();
}

/* What executes once gives its memory back once it is complete, without the application's help. */
static void test_waits_for_budget(void **state)
{
    (void)state;
    open_fixture(
        &(struct fixture_setup){.has_layer = true, .budget_mib = "2", .when_full = "wait"});
    VkCommandBuffer commands[BUILDS];
    for (int i = 0; i < BUILDS; i++) {
        commands[i] = fixture_begin(&fixture, VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT);
        build(commands[i], BOXES);
        GET(fixture.vk.EndCommandBuffer(commands[i]));
        GET(fixture_submit(&fixture, commands[i], VK_NULL_HANDLE));
    }
    GET(fixture.vk.DeviceWaitIdle(fixture.device));
    assert_int_equal(bytes_copied(), BUILDS * BOXES * sizeof(VkAabbPositionsKHR));
    fixture_expect_silence(&fixture);
    close_fixture();
}

/* A command buffer that may be pending twice, and waits for the host: to wait for its first
 * execution would be for ever. */
static void test_submits_again_while_pending(void **state)
{
    (void)state;
    open_fixture(&(struct fixture_setup){.has_layer = true});
    VkSemaphore semaphore = fixture_timeline(&fixture);
    VkCommandBuffer commands =
        fixture_begin(&fixture, VK_COMMAND_BUFFER_USAGE_SIMULTANEOUS_USE_BIT);
    spoil_box(0);
    build(commands, 1);
    GET(fixture.vk.EndCommandBuffer(commands));
    fixture_submit_waiting(&fixture, commands, semaphore, VK_NULL_HANDLE);
    fixture_expect_silence(&fixture);
    fixture_submit_waiting(&fixture, commands, semaphore, VK_NULL_HANDLE);
    expect_told("1 of command buffers that are submitted again before they are complete");
    const VkSemaphoreSignalInfo signal = {
        .sType = VK_STRUCTURE_TYPE_SEMAPHORE_SIGNAL_INFO, .semaphore = semaphore, .value = 1};
    GET(fixture.vk.SignalSemaphore(fixture.device, &signal));
    GET(fixture.vk.DeviceWaitIdle(fixture.device));
    expect_told("minX");
    fixture.vk.DestroySemaphore(fixture.device, semaphore, NULL);
    close_fixture();
}

static void test_twice_in_a_submission(void **state)
{
    (void)state;
    open_fixture(&(struct fixture_setup){.has_layer = true});
    VkCommandBuffer commands =
        fixture_begin(&fixture, VK_COMMAND_BUFFER_USAGE_SIMULTANEOUS_USE_BIT);
    spoil_box(0);
    build(commands, 1);
    GET(fixture.vk.EndCommandBuffer(commands));
    const VkCommandBuffer twice[] = {commands, commands};
    const VkSubmitInfo info = {
        .sType = VK_STRUCTURE_TYPE_SUBMIT_INFO, .commandBufferCount = 2, .pCommandBuffers = twice};
    GET(fixture.vk.QueueSubmit(fixture.queue, 1, &info, VK_NULL_HANDLE));
    expect_told("1 followed by another of the same command buffer in the submission");
    GET(fixture.vk.QueueWaitIdle(fixture.queue));
    expect_told("minX");
    close_fixture();
}

/* Resubmitted when it is complete, each execution is looked at by itself. */
static void test_submits_again(void **state)
{
    (void)state;
    open_fixture(&(struct fixture_setup){.has_layer = true});
    VkCommandBuffer commands = fixture_begin(&fixture, 0);
    build(commands, 2);
    GET(fixture.vk.EndCommandBuffer(commands));
    VkFence fence = fixture_fence(&fixture);
    for (uint32_t i = 0; i < 2; i++) {
        spoil_box(i);
        GET(fixture_submit(&fixture, commands, fence));
        GET(fixture.vk.WaitForFences(fixture.device, 1, &fence, VK_TRUE, UINT64_MAX));
        GET(fixture.vk.ResetFences(fixture.device, 1, &fence));
        expect_told("minX");
        memset(boxes.bytes, 0, 2 * sizeof(VkAabbPositionsKHR));
    }
    GET(fixture_submit(&fixture, commands, fence));
    GET(fixture.vk.WaitForFences(fixture.device, 1, &fence, VK_TRUE, UINT64_MAX));
    fixture_expect_silence(&fixture);
    fixture.vk.DestroyFence(fixture.device, fence, NULL);
    close_fixture();
}

/* The layer doesn't see that the application knows the end of its work, as it doesn't see events.
 * The device's destruction brings what is left. */
static void test_tells_at_destruction(void **state)
{
    (void)state;
    const VkEventCreateInfo info = {.sType = VK_STRUCTURE_TYPE_EVENT_CREATE_INFO};
    VkEvent event;
    open_fixture(&(struct fixture_setup){.has_layer = true});
    GET(fixture.vk.CreateEvent(fixture.device, &info, NULL, &event));
    VkCommandBuffer commands = fixture_begin(&fixture, 0);
    spoil_box(0);
    build(commands, 1);
    fixture.vk.CmdSetEvent(commands, event, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT);
    GET(fixture.vk.EndCommandBuffer(commands));
    GET(fixture_submit(&fixture, commands, VK_NULL_HANDLE));
    while (fixture.vk.GetEventStatus(fixture.device, event) != VK_EVENT_SET)
        continue;
    nanosleep(&(struct timespec){.tv_nsec = 100 * 1000 * 1000}, NULL);
    fixture_expect_silence(&fixture);
    fixture.vk.DestroyEvent(fixture.device, event, NULL);
    close_fixture();
    expect_told("minX");
}

static void test_not_without_its_level(void **state)
{
    (void)state;
    open_fixture(&(struct fixture_setup){.has_layer = false});
    assert_null(fixture.get_device_proc_addr(fixture.device, "vkGetCountersASSAY"));
    close_fixture();
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
