/* SPDX-License-Identifier: Apache-2.0 */
/* Threads that record, submit, query and trace at once on backend cpu, each with structures of its
 * own over one BLAS that all of them share, for thread sanitizers: over the null driver, which
 * copies nothing, so that boxes are points at the origin. */
#include "device_fixture.h"
#include "src/platform/clock.h"
#include "tests/fixture/make.h"
#include "tests/fixture/messenger.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>

enum { THREADS = 4, ROUNDS = 40 };

static pthread_mutex_t queue_lock = PTHREAD_MUTEX_INITIALIZER;
static struct fixture_structure shared;

struct worker {
    VkCommandPool pool;
    struct fixture_build host_triangles, host_instances;
    struct device_build triangles, instances;
    struct fixture_structure blas, tlas;
    VkQueryPool queries;
    VkFence fence;
    unsigned failures;
};

static void open_worker(struct worker *worker)
{
    worker->pool = command_pool_create(&vk, device);
    OWN(DestroyCommandPool, worker->pool);
    worker->fence = fence_create(&vk, device);
    OWN(DestroyFence, worker->fence);
    worker->queries = query_pool_create(&vk, device, SERIALIZATION_SIZE, 1);
    OWN(DestroyQueryPool, worker->queries);
    fixture_triangles(&worker->host_triangles, 4, 0);
    worker->blas = fixture_create_for(&worker->host_triangles);
    device_build_create(&worker->host_triangles, &worker->triangles);
    const VkAccelerationStructureKHR blases[] = {worker->blas.handle, shared.handle};
    fixture_instances(&worker->host_instances, blases, 2, 0);
    worker->tlas = fixture_create_for(&worker->host_instances);
    device_build_create(&worker->host_instances, &worker->instances);
}

static VkCommandBuffer record(struct worker *worker)
{
    VkCommandBuffer commands = commands_begin(&vk, device, worker->pool, PRIMARY, 0, NULL);
    device_build(commands, &worker->triangles, worker->blas.handle, VK_NULL_HANDLE);
    device_build(commands, &worker->instances, worker->tlas.handle, VK_NULL_HANDLE);
    vk.CmdResetQueryPool(commands, worker->queries, 0, 1);
    vk.CmdWriteAccelerationStructuresPropertiesKHR(commands, 1, &worker->blas.handle,
                                                   SERIALIZATION_SIZE, worker->queries, 0);
    vk.CmdCopyQueryPoolResults(commands, worker->queries, 0, 1, worker->triangles.staging.handle, 0,
                               8, VK_QUERY_RESULT_64_BIT);
    device_end(commands);
    return commands;
}

static bool run(struct worker *worker, VkCommandBuffer commands)
{
    pthread_mutex_lock(&queue_lock);
    VkResult result = commands_submit(&vk, queue, commands, worker->fence);
    pthread_mutex_unlock(&queue_lock);
    return result == VK_SUCCESS &&
           vk.WaitForFences(device, 1, &worker->fence, VK_TRUE, UINT64_MAX) == VK_SUCCESS &&
           vk.ResetFences(device, 1, &worker->fence) == VK_SUCCESS;
}

/* The host rebuilds what all TLASes may refer to. */
static bool rebuild_shared(struct fixture_build *build)
{
    static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
    pthread_mutex_lock(&lock);
    VkResult result = host_build(build, shared.handle, VK_NULL_HANDLE);
    pthread_mutex_unlock(&lock);
    return result == VK_SUCCESS;
}

static bool look(const struct worker *worker)
{
    uint64_t size = 0;
    fixture_trace(worker->tlas.handle, 0, 0);
    return vk.GetQueryPoolResults(device, worker->queries, 0, 1, sizeof(size), &size, sizeof(size),
                                  VK_QUERY_RESULT_64_BIT) == VK_SUCCESS &&
           size > 0;
}

static void *work(void *argument)
{
    struct worker *worker = argument;
    for (int round = 0; round < ROUNDS; round++) {
        VkCommandBuffer commands = record(worker);
        bool is_well = run(worker, commands);
        is_well = is_well && run(worker, commands);
        is_well = is_well && rebuild_shared(&worker->host_triangles) && look(worker);
        vk.FreeCommandBuffers(device, worker->pool, 1, &commands);
        worker->failures += !is_well;
    }
    return NULL;
}

SILENT_TEST(test_threads)
{
    static struct worker workers[THREADS];
    struct fixture_build build;
    fixture_triangles(&build, 4, 0);
    shared = fixture_create_for(&build);
    for (int i = 0; i < THREADS; i++)
        open_worker(&workers[i]);
    unit_test_run_threads(THREADS, work, workers, sizeof(workers[0]));
    for (int i = 0; i < THREADS; i++)
        assert_int_equal(workers[i].failures, 0);
}

/* ---- a thread that waits for work behind that of another one, which is still being checked */

static atomic_bool is_checking, is_waiting;

MESSENGER_CALLBACK(pause_in_message)
{
    atomic_store(&is_checking, true);
    while (!atomic_load(&is_waiting))
        clock_yield();
    clock_sleep(20000000);
    return VK_FALSE;
}

static void *submit_mistake(void *commands)
{
    if (commands_submit(&vk, queue, commands, VK_NULL_HANDLE) != VK_SUCCESS)
        abort();
    return NULL;
}

/* An update of a structure that was never built. */
static VkCommandBuffer record_mistake(void)
{
    static struct fixture_build build;
    static struct device_build triangles;
    fixture_triangles(&build, 4, UPDATABLE);
    const VkAccelerationStructureKHR unbuilt = fixture_create_for(&build).handle;
    device_build_create(&build, &triangles);
    VkCommandBuffer commands = device_begin(PRIMARY);
    device_build(commands, &triangles, unbuilt, unbuilt);
    device_end(commands);
    return commands;
}

NOISY_TEST(test_results_behind_work_of_another_thread)
{
    struct fixture_build build;
    fixture_triangles(&build, 4, 0);
    const struct fixture_structure blas = fixture_create_for(&build);
    const VkQueryPool queries = query_pool_create(&vk, device, SERIALIZATION_SIZE, 1);
    const VkFence fence = fence_create(&vk, device);
    const STRUCT(VkDebugUtilsMessengerCreateInfoEXT, info,
                 .messageSeverity = VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT,
                 .messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT,
                 .pfnUserCallback = pause_in_message);
    VkDebugUtilsMessengerEXT messenger;
    uint64_t size = 0;
    pthread_t thread;
    OWN(DestroyQueryPool, queries);
    OWN(DestroyFence, fence);
    GET(host_build(&build, blas.handle, VK_NULL_HANDLE));
    VkCommandBuffer mistake = record_mistake(), commands = device_begin(PRIMARY);
    vk.CmdResetQueryPool(commands, queries, 0, 1);
    vk.CmdWriteAccelerationStructuresPropertiesKHR(commands, 1, &blas.handle, SERIALIZATION_SIZE,
                                                   queries, 0);
    device_end(commands);
    GET(instance.vk.CreateDebugUtilsMessengerEXT(instance.instance, &info, NULL, &messenger));
    assert_int_equal(pthread_create(&thread, NULL, submit_mistake, mistake), 0);
    while (!atomic_load(&is_checking))
        clock_yield();
    GET(commands_submit(&vk, second_queue, commands, fence));
    atomic_store(&is_waiting, true);
    GET(vk.WaitForFences(device, 1, &fence, VK_TRUE, UINT64_MAX));
    GET(vk.GetQueryPoolResults(device, queries, 0, 1, sizeof(size), &size, sizeof(size),
                               VK_QUERY_RESULT_64_BIT));
    assert_true(size > 0);
    pthread_join(thread, NULL);
    instance.vk.DestroyDebugUtilsMessengerEXT(instance.instance, messenger, NULL);
    GET(vk.DeviceWaitIdle(device));
    vk.FreeCommandBuffers(device, command_pool, 2, (VkCommandBuffer[]){mistake, commands});
}

/* ---- a query whose batch waits for what another thread signals */

static void *signal_later(void *timeline)
{
    const STRUCT(VkSemaphoreSignalInfo, info, .semaphore = timeline, .value = 1);
    clock_sleep(20000000);
    GET(vk.SignalSemaphore(device, &info));
    return NULL;
}

SILENT_TEST(test_a_query_that_waits_for_another_thread)
{
    static const uint64_t value = 1;
    static const VkPipelineStageFlags stage = VK_PIPELINE_STAGE_ALL_COMMANDS_BIT;
    struct fixture_build build;
    fixture_triangles(&build, 4, 0);
    const struct fixture_structure blas = fixture_create_for(&build);
    const VkQueryPool queries = query_pool_create(&vk, device, SERIALIZATION_SIZE, 1);
    VkSemaphore timeline = timeline_create(&vk, device);
    uint64_t size = 0;
    pthread_t thread;
    OWN(DestroyQueryPool, queries);
    OWN(DestroySemaphore, timeline);
    GET(host_build(&build, blas.handle, VK_NULL_HANDLE));
    VkCommandBuffer commands = device_begin(PRIMARY);
    vk.CmdResetQueryPool(commands, queries, 0, 1);
    vk.CmdWriteAccelerationStructuresPropertiesKHR(commands, 1, &blas.handle, SERIALIZATION_SIZE,
                                                   queries, 0);
    device_end(commands);
    const STRUCT(VkTimelineSemaphoreSubmitInfo, values, .waitSemaphoreValueCount = 1,
                 .pWaitSemaphoreValues = &value);
    const STRUCT(VkSubmitInfo, info, .pNext = &values, .waitSemaphoreCount = 1,
                 .pWaitSemaphores = &timeline, .pWaitDstStageMask = &stage, .commandBufferCount = 1,
                 .pCommandBuffers = &commands);
    GET(vk.QueueSubmit(queue, 1, &info, VK_NULL_HANDLE));
    assert_int_equal(pthread_create(&thread, NULL, signal_later, timeline), 0);
    assert_int_equal(vk.GetQueryPoolResults(device, queries, 0, 1, sizeof(size), &size,
                                            sizeof(size),
                                            VK_QUERY_RESULT_64_BIT | VK_QUERY_RESULT_WAIT_BIT),
                     VK_SUCCESS);
    assert_true(size > 0);
    pthread_join(thread, NULL);
    GET(vk.DeviceWaitIdle(device));
    vk.FreeCommandBuffers(device, command_pool, 1, &commands);
}
