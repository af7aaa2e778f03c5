/* SPDX-License-Identifier: Apache-2.0 */
/* Calls that destroy, free or reset something query no fence, nor do submissions. A layer below
 * would learn from the result that the device has completed the layer's own fence, and all that was
 * submitted before it: it would no longer report that the application destroys what is in use. */
#include "tests/snapshots/scene.h"

enum { BUFFER_SIZE = 1 << 16 };

static VkCommandPool pool;
static VkCommandBuffer commands[2];
static VkQueryPool queries;
static VkFence fence;
static VkSemaphore semaphore;
static VkEvent event;
static struct device_buffer unrelated;

/* Submits builds, whose fences the layer has not seen signaled. */
static void open_at(const char *level)
{
    const STRUCT(VkQueryPoolCreateInfo, query_info, .queryCount = 1,
                 .queryType = VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_KHR);
    SCENE_OPEN(.settings.level = level, .boxes_size = BUFFER_SIZE, .structure_size = BUFFER_SIZE);
    pool = command_pool_create(&fixture.vk, fixture.device);
    fence = fence_create(&fixture.vk, fixture.device);
    semaphore = timeline_create(&fixture.vk, fixture.device);
    GET(fixture.vk.CreateEvent(fixture.device, &MAKE(VkEventCreateInfo), NULL, &event));
    GET(fixture.vk.CreateQueryPool(fixture.device, &query_info, NULL, &queries));
    unrelated = scene_input(BUFFER_SIZE);
    scene_invalidate_box(0);
    for (int i = 0; i < 2; i++) {
        commands[i] =
            commands_begin(&fixture.vk, fixture.device, pool, VK_COMMAND_BUFFER_LEVEL_PRIMARY,
                           VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT, NULL);
        scene_build_boxes(commands[i], 1);
        scene_submit(commands[i]);
    }
}

static void open_scene(void)
{
    open_at("content");
}

/* Backend cpu makes the structure when it is read, so the structure has the copies until then. */
static void open_cpu(void)
{
    open_at("execution");
}

static void destroy_structure(void)
{
    fixture.vk.DestroyAccelerationStructureKHR(fixture.device, scene.blas, NULL);
    fixture.structure_count = 0;
}

static void destroy_buffer(void)
{
    fixture_destroy_buffer(&fixture, &unrelated); /* and frees its memory */
}

static void destroy_query_pool(void)
{
    fixture.vk.DestroyQueryPool(fixture.device, queries, NULL);
    queries = VK_NULL_HANDLE;
}

static void reset_query_pool(void)
{
    fixture.vk.ResetQueryPool(fixture.device, queries, 0, 1);
}

static void destroy_fence(void)
{
    GET(fixture.vk.ResetFences(fixture.device, 1, &fence));
    fixture.vk.DestroyFence(fixture.device, fence, NULL);
    fence = VK_NULL_HANDLE;
}

static void destroy_semaphore(void)
{
    fixture.vk.DestroySemaphore(fixture.device, semaphore, NULL);
    semaphore = VK_NULL_HANDLE;
}

static void destroy_event(void)
{
    GET(fixture.vk.ResetEvent(fixture.device, event));
    fixture.vk.DestroyEvent(fixture.device, event, NULL);
    event = VK_NULL_HANDLE;
}

static void reset_command_buffer(void)
{
    GET(fixture.vk.ResetCommandBuffer(commands[0], 0));
}

static void begin_command_buffer(void)
{
    GET(fixture.vk.BeginCommandBuffer(commands[0], &MAKE(VkCommandBufferBeginInfo)));
}

static void free_command_buffer(void)
{
    fixture.vk.FreeCommandBuffers(fixture.device, pool, 1, &commands[0]);
}

static void reset_command_pool(void)
{
    GET(fixture.vk.ResetCommandPool(fixture.device, pool, 0));
}

static void destroy_command_pool(void)
{
    fixture.vk.DestroyCommandPool(fixture.device, pool, NULL);
    pool = VK_NULL_HANDLE;
}

static void submit_nothing(void)
{
    GET(fixture.vk.QueueSubmit(fixture.queue, 0, NULL, VK_NULL_HANDLE));
}

static const struct row {
    const char *test;
    void (*destroy)(void);
    const char *text; /* of the only message; NULL: there is none */
} rows[] = {{"test_destroy_structure", destroy_structure, "has not completed"},
            {"test_destroy_buffer", destroy_buffer},
            {"test_destroy_query_pool", destroy_query_pool},
            {"test_reset_query_pool", reset_query_pool},
            {"test_destroy_fence", destroy_fence},
            {"test_destroy_semaphore", destroy_semaphore},
            {"test_destroy_event", destroy_event},
            {"test_reset_command_buffer", reset_command_buffer},
            {"test_begin_command_buffer", begin_command_buffer},
            {"test_free_command_buffer", free_command_buffer},
            {"test_reset_command_pool", reset_command_pool},
            {"test_destroy_command_pool", destroy_command_pool},
            {"test_submit_nothing", submit_nothing}};

static uint64_t count_queries(void)
{
    static const char *const names[] = {"vkGetFenceStatus",      "vkWaitForFences",
                                        "vkWaitSemaphores",      "vkGetSemaphoreCounterValue",
                                        "vkQueueWaitIdle",       "vkDeviceWaitIdle",
                                        "vkGetQueryPoolResults", "vkGetEventStatus"};
    uint64_t count = 0;
    for (size_t i = 0; i < ARRAY_COUNT(names); i++)
        count += platform.null_driver.calls(names[i]);
    return count;
}

static void close_scene(void)
{
    GET(fixture.vk.DeviceWaitIdle(fixture.device));
    fixture.vk.DestroyQueryPool(fixture.device, queries, NULL);
    fixture.vk.DestroyFence(fixture.device, fence, NULL);
    fixture.vk.DestroySemaphore(fixture.device, semaphore, NULL);
    fixture.vk.DestroyEvent(fixture.device, event, NULL);
    fixture.vk.DestroyCommandPool(fixture.device, pool, NULL);
    scene_close();
}

/* The copies are validated all the same, when the host has observed the end of the builds. */
TEST_OF_ROWS_BETWEEN(test_destroys, rows, const struct row *row, open_scene, close_scene)
{
    const uint64_t before = count_queries();
    row->destroy();
    assert_int_equal(count_queries(), before);
    if (row->text)
        expect_messages(1, row->text);
    else
        fixture_expect_silence(&fixture);
    messages_clear(&fixture.instance.messages);
    GET(fixture.vk.DeviceWaitIdle(fixture.device));
    expect_messages(2, "minX");
}

TEST_BETWEEN_IF(test_destroy_unread_structure, open_cpu, close_scene, platform.is_cpu)
{
    const uint64_t before = count_queries();
    destroy_structure();
    assert_int_equal(count_queries(), before);
}
