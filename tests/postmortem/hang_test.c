/* SPDX-License-Identifier: Apache-2.0 */
/* Several threads wait while the device makes no progress: one report at most.
 * tests/programs/postmortem/hang.cases has the waits of one thread. */
#include "tests/snapshots/scene.h"

#include <pthread.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { BUFFER_SIZE = 1 << 16, MILLISECOND = 1000 * 1000 };

static VkFence fence;

static void open_scene(void)
{
    setenv("VK_ASSAY_VALIDATION_HANG_SECONDS", "1", 1);
    SCENE_OPEN(.boxes_size = BUFFER_SIZE, .structure_size = BUFFER_SIZE);
    fence = fence_create(&fixture.vk, fixture.device);
    scene_invalidate_box(0);
}

static void close_scene(void)
{
    platform.null_driver.reset();
    fixture.vk.DestroyFence(fixture.device, fence, NULL);
    scene_close();
}

/* Submits a build at which the device hangs. */
static void hang(void)
{
    PLAN_FAULT(.kind = NULL_DRIVER_HANG, .at = NULL_DRIVER_AT_BUILD);
    VkCommandBuffer commands = scene_record_boxes(0, 1);
    GET(fixture.vk.EndCommandBuffer(commands));
    GET(fixture_submit(&fixture, commands, fence));
    fixture_expect_silence(&fixture);
}

static uint32_t count_of(const char *id)
{
    uint32_t count = 0;
    const struct messages *messages = &fixture.instance.messages;
    for (uint32_t i = 0; i < messages_kept(messages); i++)
        count += strstr(messages->items[i].id, id) != NULL;
    return count;
}

enum { WAITERS = 4 };

static void *wait_on_thread(void *result)
{
    *(VkResult *)result = fixture.vk.WaitForFences(fixture.device, 1, &fence, VK_TRUE, UINT64_MAX);
    return NULL;
}

TEST_BETWEEN(test_several_waiters, open_scene, close_scene)
{
    VkResult results[WAITERS];
    pthread_t threads[WAITERS];
    hang();
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
