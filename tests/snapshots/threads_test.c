/* SPDX-License-Identifier: Apache-2.0 */
/* Threads that record, submit and wait at once at level content on backend driver, each with
 * command buffers and data of its own, for thread sanitizers; a device that is lost meanwhile; and
 * a secondary that two threads submit. */
#include "tests/snapshots/scene.h"

#include <pthread.h>
#include <string.h>

enum {
    THREADS = 4,
    ROUNDS = 40,
    BOXES = 16,
    STRUCTURE_SIZE = 1 << 16,
    SCRATCH_SIZE = 1 << 16,
    DATA_SIZE = BOXES * sizeof(VkAabbPositionsKHR),
};

static pthread_mutex_t queue_lock = PTHREAD_MUTEX_INITIALIZER;

struct worker {
    struct fixture own; /* with a command pool of its own */
    struct device_buffer boxes, structures, scratch;
    VkAccelerationStructureKHR blas;
    VkFence fence;
    VkResult result; /* of what it did last */
};
/* Larger than a stack on Windows. */
static struct worker workers[THREADS];

static void open_worker(struct worker *worker)
{
    *worker = (struct worker){.fence = fence_create(&fixture.vk, fixture.device)};
    worker->own.device = fixture.device;
    worker->own.vk = fixture.vk;
    worker->own.queue = fixture.queue;
    worker->own.pool = command_pool_create(&fixture.vk, fixture.device);
    worker->boxes = scene_input(DATA_SIZE);
    worker->structures = fixture_buffer(&fixture, STRUCTURE_SIZE,
                                        VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_STORAGE_BIT_KHR);
    worker->scratch = fixture_buffer(&fixture, SCRATCH_SIZE, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT);
    worker->blas = fixture_structure(&fixture, &worker->structures, 0, STRUCTURE_SIZE,
                                     VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR);
}

static void close_worker(struct worker *worker)
{
    fixture.vk.DestroyCommandPool(fixture.device, worker->own.pool, NULL);
    fixture.vk.DestroyFence(fixture.device, worker->fence, NULL);
}

/* `lock`: of the queue, or NULL if no other thread uses it. */
static VkResult submit(struct worker *worker, VkCommandBuffer commands, pthread_mutex_t *lock)
{
    if (lock)
        pthread_mutex_lock(lock);
    VkResult result = fixture_submit(&worker->own, commands, worker->fence);
    if (lock)
        pthread_mutex_unlock(lock);
    if (result == VK_SUCCESS)
        result = fixture.vk.WaitForFences(fixture.device, 1, &worker->fence, VK_TRUE, UINT64_MAX);
    return result == VK_SUCCESS ? fixture.vk.ResetFences(fixture.device, 1, &worker->fence)
                                : result;
}

/* Submitted twice, so that what an execution copied may have to be kept while the next one
 * copies. */
static void *work(void *argument)
{
    struct worker *worker = argument;
    for (int round = 0; round < ROUNDS && worker->result == VK_SUCCESS; round++) {
        VkCommandBuffer commands = fixture_begin(&worker->own, 0);
        fixture_build_boxes(&worker->own, commands, worker->blas, worker->boxes.address, BOXES,
                            (worker->scratch.address + 255) & ~(VkDeviceAddress)255);
        GET(fixture.vk.EndCommandBuffer(commands));
        for (int i = 0; i < 2 && worker->result == VK_SUCCESS; i++)
            worker->result = submit(worker, commands, &queue_lock);
        fixture.vk.FreeCommandBuffers(fixture.device, worker->own.pool, 1, &commands);
    }
    return NULL;
}

static void run_threads(void (*meanwhile)(void))
{
    pthread_t threads[THREADS];
    for (int i = 0; i < THREADS; i++)
        open_worker(&workers[i]);
    for (int i = 0; i < THREADS; i++)
        assert_int_equal(pthread_create(&threads[i], NULL, work, &workers[i]), 0);
    if (meanwhile)
        meanwhile();
    for (int i = 0; i < THREADS; i++)
        pthread_join(threads[i], NULL);
}

TEST(test_threads)
{
    fixture_open(&fixture, &platform, &(struct instance_settings){.level = "content"});
    run_threads(NULL);
    for (int i = 0; i < THREADS; i++) {
        GET(workers[i].result);
        close_worker(&workers[i]);
    }
    fixture_expect_silence(&fixture);
    fixture_close(&fixture);
}

/* ---- a shared secondary */

static VkCommandBuffer secondary;

static void *submit_secondary(void *argument)
{
    struct worker *worker = argument;
    VkCommandBuffer commands = fixture_begin(&worker->own, 0);
    fixture.vk.CmdExecuteCommands(commands, 1, &secondary);
    GET(fixture.vk.EndCommandBuffer(commands));
    for (int round = 0; round < ROUNDS && worker->result == VK_SUCCESS; round++)
        worker->result = submit(worker, commands, NULL);
    return NULL;
}

/* Two threads submit primaries to queues of their own, which execute the same secondary. Nothing
 * orders the two queues: the null driver builds nothing. The layer says at most that it does not
 * validate what executes twice at once. */
TEST(test_shared_secondary)
{
    pthread_t thread;
    if (!platform.is_null)
        skip();
    fixture_open(
        &fixture, &platform,
        &(struct instance_settings){.level = "content", .hazards = "false", .queue_count = 2});
    for (uint32_t i = 0; i < 2; i++) {
        open_worker(&workers[i]);
        fixture.vk.GetDeviceQueue(fixture.device, 0, i, &workers[i].own.queue);
    }
    secondary = fixture_begin_secondary(&fixture, VK_COMMAND_BUFFER_USAGE_SIMULTANEOUS_USE_BIT);
    fixture_build_boxes(&fixture, secondary, workers[0].blas, workers[0].boxes.address, BOXES,
                        (workers[0].scratch.address + 255) & ~(VkDeviceAddress)255);
    GET(fixture.vk.EndCommandBuffer(secondary));
    assert_int_equal(pthread_create(&thread, NULL, submit_secondary, &workers[1]), 0);
    submit_secondary(&workers[0]);
    pthread_join(thread, NULL);
    for (int i = 0; i < 2; i++) {
        GET(workers[i].result);
        close_worker(&workers[i]);
    }
    for (uint32_t i = 0; i < messages_kept(&fixture.instance.messages); i++)
        if (!strstr(fixture.instance.messages.items[i].text, "submitted again before"))
            fail_msg("%s", fixture.instance.messages.items[i].text);
    fixture_close(&fixture);
}

/* The null driver reads the table of live structures on the thread that submits, while the other
 * one changes it as it may for a GPU: a race for the thread sanitizer. */
#ifdef __SANITIZE_THREAD__
enum { IS_SANITIZED = 1 };
#else
enum { IS_SANITIZED = 0 };
#endif

/* If both threads submit at the same time, the order is unknown to one of them, which lets each
 * live structure count as built for the guard. */
TEST_IF(test_shared_guarded_secondary, platform.is_null && !IS_SANITIZED)
{
    pthread_t thread;
    uint64_t read[4 * ROUNDS];
    SCENE_OPEN(.settings = {.guard = "references", .queue_count = 2}, .boxes_size = DATA_SIZE,
               .structure_size = STRUCTURE_SIZE, .has_tlas = true);
    fixture_finish(&fixture, scene_record_boxes(0, 1));
    for (uint32_t i = 0; i < 2; i++) {
        open_worker(&workers[i]);
        fixture.vk.GetDeviceQueue(fixture.device, 0, i, &workers[i].own.queue);
    }
    struct device_buffer instances = scene_input(2 * sizeof(VkAccelerationStructureInstanceKHR));
    VkAccelerationStructureInstanceKHR *instance = (void *)instances.bytes;
    scene_write_instance(&instances, true);
    instance[1] = instance[0];
    instance[1].accelerationStructureReference =
        structure_address(&fixture.vk, fixture.device, workers[0].blas); /* never built */
    const struct fixture_build build = scene_describe_instances(instances.address, false, 2);
    platform.null_driver.set_reads_instances(true);
    secondary = fixture_begin_secondary(&fixture, VK_COMMAND_BUFFER_USAGE_SIMULTANEOUS_USE_BIT);
    fixture_build(&fixture, secondary, &build);
    GET(fixture.vk.EndCommandBuffer(secondary));
    assert_int_equal(pthread_create(&thread, NULL, submit_secondary, &workers[1]), 0);
    submit_secondary(&workers[0]);
    pthread_join(thread, NULL);
    assert_int_equal(platform.null_driver.take_references(read, 4 * ROUNDS), 4 * ROUNDS);
    for (int i = 0; i < 4 * ROUNDS; i += 2) {
        assert_int_equal(read[i], instance[0].accelerationStructureReference);
        assert_true(read[i + 1] == instance[1].accelerationStructureReference || !read[i + 1]);
    }
    for (int i = 0; i < 2; i++)
        close_worker(&workers[i]);
    platform.null_driver.set_reads_instances(false);
    messages_clear(&fixture.instance.messages); /* about the structure that is not built */
    scene_close();
}

/* ---- a lost device */

static void lose_device(void)
{
    platform.null_driver.set_device_lost(true);
}

/* The layer reports only that these builds may not have executed, and no thread hangs. A thread
 * that does not know of the loss yet may submit a command buffer again before the layer has seen it
 * complete. */
TEST(test_lost_device)
{
    if (!platform.is_null)
        skip();
    fixture_open(&fixture, &platform, &(struct instance_settings){.level = "content"});
    run_threads(lose_device);
    for (int i = 0; i < THREADS; i++) {
        assert_true(workers[i].result == VK_SUCCESS || workers[i].result == VK_ERROR_DEVICE_LOST);
        close_worker(&workers[i]);
    }
    for (uint32_t i = 0; i < messages_kept(&fixture.instance.messages); i++)
        if (!strstr(fixture.instance.messages.items[i].text, " lost") &&
            !strstr(fixture.instance.messages.items[i].text, "submitted again before"))
            fail_msg("%s", fixture.instance.messages.items[i].text);
    fixture_close(&fixture);
    platform.null_driver.set_device_lost(false);
}
