/* SPDX-License-Identifier: Apache-2.0 */
/* Backend cpu through the loader: builds and copies that are deferred, and joined by one thread or
 * by several at once. The valid calls are silent. */
#include "host_fixture.h"

#include <stdlib.h>
#include <string.h>

enum { THREADS = 2, BUILDS = 32, TRIANGLES = 20000 };

static VkDeferredOperationKHR operation; /* of a test */

static void create_operation(void)
{
    GET(vk.CreateDeferredOperationKHR(device, NULL, &operation));
}

static void destroy_operation(void)
{
    vk.DestroyDeferredOperationKHR(device, operation, NULL);
}

/* As an application's threads do: again while there may be more to do. */
static void *join(void *result)
{
    do {
        *(VkResult *)result = vk.DeferredOperationJoinKHR(device, operation);
    } while (*(VkResult *)result == VK_THREAD_IDLE_KHR);
    return NULL;
}

/* Returns the operation's result. */
static VkResult complete(void)
{
    VkResult results[THREADS];
    int successes = 0;
    assert_int_equal(vk.GetDeferredOperationResultKHR(device, operation), VK_NOT_READY);
    assert_in_range(vk.GetDeferredOperationMaxConcurrencyKHR(device, operation), 1, 2 * BUILDS);
    unit_test_run_threads(THREADS, join, results, sizeof(results[0]));
    for (int i = 0; i < THREADS; i++)
        successes += results[i] == VK_SUCCESS;
    assert_true(successes >= 1);
    assert_int_equal(vk.GetDeferredOperationMaxConcurrencyKHR(device, operation), 0);
    return vk.GetDeferredOperationResultKHR(device, operation);
}

static void expect_deferred(VkResult result)
{
    assert_int_equal(result, VK_OPERATION_DEFERRED_KHR);
    GET(complete());
}

/* ---- builds */

/* Many structures in one call. */
struct many {
    struct fixture_build builds[BUILDS];
    struct fixture_structure structures[BUILDS];
    VkAccelerationStructureBuildGeometryInfoKHR infos[BUILDS];
    const VkAccelerationStructureBuildRangeInfoKHR *ranges[BUILDS];
};

static struct many *open_many(uint32_t triangles)
{
    struct many *many = calloc(1, sizeof(*many));
    create_operation();
    for (uint32_t i = 0; i < BUILDS; i++) {
        fixture_triangles(&many->builds[i], triangles + i, 0);
        fixture_move(&many->builds[i], (float)i, 0, 0);
        many->structures[i] = fixture_create_for(&many->builds[i]);
        many->infos[i] = many->builds[i].info;
        many->infos[i].dstAccelerationStructure = many->structures[i].handle;
        many->ranges[i] = &many->builds[i].range;
    }
    return many;
}

static void close_many(struct many *many)
{
    free(many);
    destroy_operation();
}

static VkResult build_many(struct many *many)
{
    return vk.BuildAccelerationStructuresKHR(device, operation, BUILDS, many->infos, many->ranges);
}

static AssayHit trace_one(const struct many *many, uint32_t index)
{
    return fixture_trace(many->structures[index].handle, 0.25f, 0.25f);
}

/* Parameters may go when the call returns; what the addresses lead to is read later. */
SILENT_TEST(test_many_builds)
{
    struct many *many = open_many(1000);
    assert_int_equal(build_many(many), VK_OPERATION_DEFERRED_KHR);
    memset(many->infos, 0xff, sizeof(many->infos));
    memset(many->ranges, 0xff, sizeof(many->ranges));
    fixture_move(&many->builds[3], 30, 0, 0);
    AssayCounters before = fixture_counters();
    GET(complete());
    assert_int_equal(fixture_counters().builds - before.builds, BUILDS);
    for (uint32_t i = 0; i < BUILDS; i++)
        assert_float_equal(trace_one(many, i).t, i == 3 ? 31 : i + 1, 0);
    close_many(many);
}

/* The same bytes, whoever built it, and wherever. */
static void build_both_ways(struct fixture_build *build, struct fixture_structure *structure)
{
    *structure = fixture_create_for(build);
    struct fixture_structure shared = fixture_create(build->info.type, structure->size);
    GET(host_build(build, structure->handle, VK_NULL_HANDLE));
    create_operation();
    expect_deferred(fixture_build(operation, build, shared.handle, VK_NULL_HANDLE));
    expect_same_bytes(structure->handle, shared.handle);
    expect_deferred(fixture_build(operation, build, shared.handle, shared.handle));
    expect_same_bytes(structure->handle, shared.handle);
    destroy_operation();
}

SILENT_TEST(test_same_bytes)
{
    static const VkBuildAccelerationStructureFlagsKHR qualities[] = {
        0, VK_BUILD_ACCELERATION_STRUCTURE_PREFER_FAST_BUILD_BIT_KHR,
        VK_BUILD_ACCELERATION_STRUCTURE_PREFER_FAST_TRACE_BIT_KHR};
    for (int i = 0; i < 3; i++) {
        struct fixture_build triangles, instances;
        struct fixture_structure blas, tlas;
        fixture_triangles(&triangles, TRIANGLES, UPDATABLE | qualities[i]);
        build_both_ways(&triangles, &blas);
        const VkAccelerationStructureKHR blases[] = {blas.handle, blas.handle, blas.handle};
        fixture_instances(&instances, blases, 3, UPDATABLE | qualities[i]);
        build_both_ways(&instances, &tlas);
    }
}

/* ---- copies */

SILENT_TEST(test_copies)
{
    open_pair(100, 0);
    struct fixture_structure clone = fixture_create(TOP, pair.tlas.size);
    create_operation();
    expect_deferred(fixture_copy(operation, pair.tlas.handle, clone.handle, CLONE));
    expect_pair(clone.handle, 1);

    size_t size;
    void *bytes = fixture_serialize(pair.tlas.handle, &size), *late = own_block(malloc(size));
    expect_deferred(fixture_save(operation, clone.handle, late));
    assert_memory_equal(bytes, late, size);
    expect_deferred(fixture_load(operation, late, clone.handle));
    expect_pair(clone.handle, 1);
    destroy_operation();
}

/* ---- mistakes */

/* The operation returns the failure, and the other builds of the call are done. */
NOISY_TEST(test_failing)
{
    struct many *many = open_many(10);
    many->builds[5].geometry.geometry.triangles.vertexData.hostAddress = (void *)(uintptr_t)0x1000;
    build_many(many);
    expect_mistake(complete());
    assert_true(trace_one(many, 6).isHit);
    expect_mistake(fixture_trace_none(many->structures[5].handle));
    close_many(many);
}

/* Destroyed before it was joined, used again while pending, and structures gone by the time. */
NOISY_TEST(test_destroyed)
{
    struct many *many = open_many(10);
    build_many(many);
    expect_mistake(build_many(many));
    destroy_operation();

    create_operation();
    assert_int_equal(
        vk.BuildAccelerationStructuresKHR(device, operation, 0, many->infos, many->ranges),
        VK_OPERATION_NOT_DEFERRED_KHR);
    GET(vk.DeferredOperationJoinKHR(device, operation));
    build_many(many);
    destroy((uint64_t)many->structures[0].handle);
    expect_mistake(complete());
    many->structures[0] = fixture_create_blas(many->structures[0].size);
    close_many(many);
}

/* Overlapping scratch is a mistake, but not one that may break trees. */
NOISY_TEST(test_shared_scratch)
{
    struct many *many = open_many(1000);
    for (uint32_t i = 0; i < BUILDS; i++) /* the last is the largest */
        many->infos[i].scratchData = many->infos[BUILDS - 1].scratchData;
    build_many(many);
    GET(complete());
    for (uint32_t i = 0; i < BUILDS; i++)
        assert_true(trace_one(many, i).isHit);
    close_many(many);
}
