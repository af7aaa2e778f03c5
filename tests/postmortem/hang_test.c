/* SPDX-License-Identifier: Apache-2.0 */
/* Waits while the device makes no progress: one report, and results as without the layer. */
#include "tests/fixture/messenger.h"
#include "tests/snapshots/scene.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { BUFFER_SIZE = 1 << 16, MILLISECOND = 1000 * 1000 };

static VkFence fence;
static VkSemaphore timeline;

static void open_with(const char *seconds)
{
    setenv("VK_ASSAY_VALIDATION_HANG_SECONDS", seconds, 1);
    SCENE_OPEN(.boxes_size = BUFFER_SIZE, .structure_size = BUFFER_SIZE);
    fence = fence_create(&fixture.vk, fixture.device);
    timeline = timeline_create(&fixture.vk, fixture.device);
    scene_invalidate_box(0);
}

static void open_scene(void)
{
    open_with("1");
}

static void open_on(VkPhysicalDeviceType type)
{
    struct null_driver_config config = platform.null_driver.default_config();
    config.properties.deviceType = type;
    platform.null_driver.configure(&config);
    open_scene();
    platform.null_driver.configure(NULL);
}

static void close_scene(void)
{
    platform.null_driver.reset();
    fixture.vk.DestroyFence(fixture.device, fence, NULL);
    fixture.vk.DestroySemaphore(fixture.device, timeline, NULL);
    scene_close();
}

#define HANG_TEST(name) TEST_BETWEEN(name, open_scene, close_scene)

/* Submits a build at which the device hangs, behind which a fence and a semaphore are signaled. */
static void hang_with(bool skips_copies, enum null_driver_progress progress)
{
    const uint64_t one = 1;
    const STRUCT(VkTimelineSemaphoreSubmitInfo, values, .signalSemaphoreValueCount = 1,
                 .pSignalSemaphoreValues = &one);
    PLAN_FAULT(.kind = NULL_DRIVER_HANG, .at = NULL_DRIVER_AT_BUILD, .skips_copies = skips_copies,
               .progress = progress);
    VkCommandBuffer commands = scene_record_boxes(0, 1);
    GET(fixture.vk.EndCommandBuffer(commands));
    const STRUCT(VkSubmitInfo, info, .pNext = &values, .commandBufferCount = 1,
                 .pCommandBuffers = &commands, .signalSemaphoreCount = 1,
                 .pSignalSemaphores = &timeline);
    GET(fixture.vk.QueueSubmit(fixture.queue, 1, &info, fence));
    fixture_expect_silence(&fixture);
}

static void hang(bool skips_copies)
{
    hang_with(skips_copies, NULL_DRIVER_STANDS);
}

static uint32_t count_of(const char *id)
{
    uint32_t count = 0;
    const struct messages *messages = &fixture.instance.messages;
    for (uint32_t i = 0; i < messages_kept(messages); i++)
        count += strstr(messages->items[i].id, id) != NULL;
    return count;
}

/* ---- another thread, which ends the hang when the layer has reported it */

MESSENGER_CALLBACK(report_arrives)
{
    if (strcmp(data->pMessageIdName, "ASSAY-hang") == 0)
        *(atomic_bool *)user = true;
    return VK_FALSE;
}

static void *end_hang(void *reported)
{
    while (!atomic_load((atomic_bool *)reported))
        nanosleep(&(struct timespec){.tv_nsec = MILLISECOND}, NULL);
    platform.null_driver.end_hang();
    return NULL;
}

static VkResult wait_for(uint64_t nanoseconds)
{
    return fixture.vk.WaitForFences(fixture.device, 1, &fence, VK_TRUE, nanoseconds);
}

CALL_AS(wait_for_fence, wait_for(UINT64_MAX))

static VkResult wait_for_any_fence(void)
{
    VkFence fences[] = {fence_create(&fixture.vk, fixture.device), fence};
    VkResult result = fixture.vk.WaitForFences(fixture.device, 2, fences, VK_FALSE, UINT64_MAX / 2);
    fixture.vk.DestroyFence(fixture.device, fences[0], NULL);
    return result;
}

CALL_AS(wait_for_semaphore,
        fixture.vk.WaitSemaphores(fixture.device,
                                  &MAKE(VkSemaphoreWaitInfo, .semaphoreCount = 1,
                                        .pSemaphores = &timeline, .pValues = &(uint64_t){1}),
                                  UINT64_MAX))
CALL_AS(wait_for_queue, fixture.vk.QueueWaitIdle(fixture.queue))
CALL_AS(wait_for_device, fixture.vk.DeviceWaitIdle(fixture.device))

static const struct row {
    const char *test;
    VkResult (*wait)(void);
} rows[] = {{"test_fence", wait_for_fence},
            {"test_any_fence", wait_for_any_fence},
            {"test_semaphore", wait_for_semaphore},
            {"test_queue", wait_for_queue},
            {"test_device", wait_for_device}};

/* Waits until the layer has reported the hang, which then ends. */
static void wait_until_reported(VkResult (*wait)(void))
{
    atomic_bool reported = false;
    VkDebugUtilsMessengerEXT messenger;
    pthread_t thread;
    const STRUCT(VkDebugUtilsMessengerCreateInfoEXT, info,
                 .messageSeverity = VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT,
                 .messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT |
                                VK_DEBUG_UTILS_MESSAGE_TYPE_GENERAL_BIT_EXT,
                 .pfnUserCallback = report_arrives, .pUserData = &reported);
    GET(fixture.instance.vk.CreateDebugUtilsMessengerEXT(fixture.instance.instance, &info, NULL,
                                                         &messenger));
    assert_int_equal(pthread_create(&thread, NULL, end_hang, &reported), 0);
    GET(wait());
    pthread_join(thread, NULL);
    GET(fixture.vk.DeviceWaitIdle(fixture.device));
    fixture.instance.vk.DestroyDebugUtilsMessengerEXT(fixture.instance.instance, messenger, NULL);
}

/* The report comes while the call waits, and the finding only once. */
TEST_OF_ROWS_BETWEEN(test_waits, rows, const struct row *row, open_scene, close_scene)
{
    hang(false);
    wait_until_reported(row->wait);
    assert_int_equal(fixture.instance.messages.count, 2);
    assert_int_equal(messages_count(&fixture.instance.messages, "ASSAY-hang",
                                    ": its inputs had been copied, and it had not finished."),
                     1);
    assert_int_equal(count_of("VUID"), 1);
    assert_has(fixture.instance.messages.items[0].text, "read while the device made no progress");
}

/* ---- progress. Each wait of the driver makes some, or none does, so no result depends on how long
 * a slice takes. */

static const uint64_t long_wait = 1500 * (uint64_t)MILLISECOND;

static VkResult wait_for_all_fences(void)
{
    VkFence fences[16];
    for (size_t i = 0; i < ARRAY_COUNT(fences); i++)
        fences[i] = i + 1 < ARRAY_COUNT(fences) ? fence_create(&fixture.vk, fixture.device) : fence;
    VkResult result =
        fixture.vk.WaitForFences(fixture.device, ARRAY_COUNT(fences), fences, VK_TRUE, long_wait);
    for (size_t i = 0; i + 1 < ARRAY_COUNT(fences); i++)
        fixture.vk.DestroyFence(fixture.device, fences[i], NULL);
    return result;
}

CALL_AS(wait_for_one_fence, wait_for(long_wait))
CALL_AS(wait_for_high_value,
        fixture.vk.WaitSemaphores(fixture.device,
                                  &MAKE(VkSemaphoreWaitInfo, .semaphoreCount = 1,
                                        .pSemaphores = &timeline, .pValues = &(uint64_t){1000}),
                                  long_wait))

static const struct progress_row {
    const char *test;
    VkPhysicalDeviceType type;
    enum null_driver_progress progress;
    VkResult (*wait)(void);
} progress_rows[] = {{"test_processor_computes", VK_PHYSICAL_DEVICE_TYPE_CPU, NULL_DRIVER_COMPUTES,
                      wait_for_one_fence},
                     {"test_processor_computes_for_semaphore", VK_PHYSICAL_DEVICE_TYPE_CPU,
                      NULL_DRIVER_COMPUTES, wait_for_high_value},
                     {"test_fences_are_signaled", VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU,
                      NULL_DRIVER_SIGNALS, wait_for_all_fences},
                     {"test_value_grows", VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU, NULL_DRIVER_SIGNALS,
                      wait_for_high_value}};

TEST_OF_ROWS(test_progress, progress_rows, const struct progress_row *row, unit_test_nothing)
{
    open_on(row->type);
    hang_with(true, row->progress);
    assert_int_equal(row->wait(), VK_TIMEOUT);
    fixture_expect_silence(&fixture);
    platform.null_driver.end_hang();
    GET(wait_for_fence());
    close_scene();
}

/* What the host computes says nothing about a GPU. */
static const struct progress_row hang_rows[] = {
    {"test_gpu_while_host_computes", VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU, NULL_DRIVER_COMPUTES,
     wait_for_fence},
    {"test_gpu_stands", VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU, NULL_DRIVER_STANDS,
     wait_for_semaphore}};

TEST_OF_ROWS(test_no_progress, hang_rows, const struct progress_row *row, unit_test_nothing)
{
    open_on(row->type);
    hang_with(true, row->progress);
    wait_until_reported(row->wait);
    assert_int_equal(count_of("ASSAY-hang"), 1);
    close_scene();
}

/* A driver on the processor that uses no processor time has no progress, either. */
TEST(test_processor_stands)
{
    open_on(VK_PHYSICAL_DEVICE_TYPE_CPU);
    hang(true);
    while (!count_of("ASSAY-hang"))
        assert_int_equal(wait_for(long_wait), VK_TIMEOUT);
    platform.null_driver.end_hang();
    GET(wait_for_fence());
    close_scene();
}

/* ---- timeouts */

HANG_TEST(test_timeouts_stay)
{
    hang(true);
    const uint64_t timeouts[] = {0, 1, 20 * MILLISECOND, 600 * (uint64_t)MILLISECOND};
    const uint64_t calls = platform.null_driver.calls("vkWaitForFences");
    assert_int_equal(wait_for(0), VK_TIMEOUT);
    assert_true(platform.null_driver.calls("vkWaitForFences") > calls);
    for (size_t i = 0; i < ARRAY_COUNT(timeouts); i++) {
        struct timespec begin, end;
        clock_gettime(CLOCK_MONOTONIC, &begin);
        assert_int_equal(wait_for(timeouts[i]), VK_TIMEOUT);
        clock_gettime(CLOCK_MONOTONIC, &end);
        const uint64_t passed = (uint64_t)(end.tv_sec - begin.tv_sec) * 1000 * MILLISECOND +
                                (uint64_t)end.tv_nsec - (uint64_t)begin.tv_nsec;
        assert_true(passed >= timeouts[i]);
    }
    platform.null_driver.end_hang();
    GET(wait_for_fence());
}

/* A wait that is longer than hang_seconds reports, and still times out; and only one does. */
HANG_TEST(test_reports_once)
{
    hang(true);
    while (!count_of("ASSAY-hang"))
        assert_int_equal(wait_for(long_wait), VK_TIMEOUT);
    assert_int_equal(wait_for(long_wait), VK_TIMEOUT);
    expect_messages(1,
                    "The device has made no progress for 1 second, while the application waits "
                    "for it. 1 build was submitted");
    platform.null_driver.set_device_lost(true);
    assert_int_equal(wait_for_fence(), VK_ERROR_DEVICE_LOST);
    assert_int_equal(wait_for_device(), VK_ERROR_DEVICE_LOST);
}

TEST_CLOSED(test_off, close_scene)
{
    open_with("0");
    hang(false);
    assert_int_equal(wait_for(1500 * (uint64_t)MILLISECOND), VK_TIMEOUT);
    fixture_expect_silence(&fixture);
}

/* What the application waits for is signaled while it waits, so errors reach it. */
HANG_TEST(test_lost_while_waiting)
{
    hang(false);
    PLAN_FAULT(.kind = NULL_DRIVER_LOSE, .at = NULL_DRIVER_AT_WAIT, .number = 2);
    assert_int_equal(wait_for_device(), VK_ERROR_DEVICE_LOST);
    assert_int_equal(count_of("ASSAY-device-lost"), 1);
    assert_int_equal(count_of("ASSAY-hang"), 0);
}

/* ---- threads */

enum { WAITERS = 4 };

static void *wait_on_thread(void *result)
{
    *(VkResult *)result = wait_for_fence();
    return NULL;
}

HANG_TEST(test_several_waiters)
{
    VkResult results[WAITERS];
    pthread_t threads[WAITERS];
    hang(false);
    for (int i = 0; i < WAITERS; i++)
        assert_int_equal(pthread_create(&threads[i], NULL, wait_on_thread, &results[i]), 0);
    nanosleep(&(struct timespec){.tv_sec = 1, .tv_nsec = 500 * MILLISECOND}, NULL);
    platform.null_driver.end_hang();
    for (int i = 0; i < WAITERS; i++) {
        pthread_join(threads[i], NULL);
        GET(results[i]);
    }
    GET(fixture.vk.DeviceWaitIdle(fixture.device));
    assert_true(count_of("ASSAY-hang") <= 1);
    assert_int_equal(count_of("VUID"), 1);
}
