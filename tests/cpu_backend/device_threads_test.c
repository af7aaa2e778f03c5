/* SPDX-License-Identifier: Apache-2.0 */
/* Threads that record, submit, query and trace at once on backend cpu, each with structures of its
 * own over one BLAS that all of them share, for thread sanitizers: over the null driver, which
 * copies nothing, so that boxes are points at the origin. */
#include "device_fixture.h"

#include <pthread.h>

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
