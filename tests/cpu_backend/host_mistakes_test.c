/* SPDX-License-Identifier: Apache-2.0 */
/* Backend cpu through the loader: what mistakes lead to. None crashes, and each leaves the
 * structures as they were. */
#include "host_fixture.h"

#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

#define WILD ((VkAccelerationStructureKHR)0x1234567890)

NOISY_TEST(test_wild_handles)
{
    open_pair(10, UPDATABLE);
    expect_mistake(host_build(&pair.triangles, WILD, VK_NULL_HANDLE));
    expect_mistake(host_build(&pair.triangles, pair.blas.handle, WILD));
    expect_mistake(host_copy(WILD, pair.blas.handle, CLONE));
    uint64_t value = 1;
    const VkAccelerationStructureKHR wild = WILD;
    expect_mistake(vk.WriteAccelerationStructuresPropertiesKHR(device, 1, &wild, STRUCTURE_SIZE, 8,
                                                               &value, 8));
    assert_int_equal(value, 0);
    expect_mistake(vk.WriteAccelerationStructuresPropertiesKHR(
        device, 1, &pair.blas.handle, VK_QUERY_TYPE_OCCLUSION, 8, &value, 8));
    const VkDeferredOperationKHR operation = (VkDeferredOperationKHR)0x42;
    expect_mistake(fixture_build(operation, &pair.triangles, pair.blas.handle, VK_NULL_HANDLE));
    expect_mistake(vk.DeferredOperationJoinKHR(device, operation));
    expect_mistake(vk.GetDeferredOperationResultKHR(device, operation));
    assert_int_equal(vk.GetDeferredOperationMaxConcurrencyKHR(device, operation), 0);
    vk.DestroyDeferredOperationKHR(device, operation, NULL);
    vk.DestroyDeferredOperationKHR(device, VK_NULL_HANDLE, NULL);
    vk.DestroyAccelerationStructureKHR(device, VK_NULL_HANDLE, NULL);
    expect_pair(pair.tlas.handle, 1);
}

/* An instance of what is destroyed, or not built, is as good as none. */
NOISY_TEST(test_destroyed)
{
    open_pair(10, UPDATABLE);
    expect_pair(pair.tlas.handle, 1);
    struct fixture_structure empty = fixture_create_blas(pair.blas.size);
    VkAccelerationStructureInstanceKHR *instances = pair.instances.data;
    instances[1].accelerationStructureReference = (uint64_t)empty.handle;
    GET(host_build(&pair.instances, pair.tlas.handle, VK_NULL_HANDLE));
    expect_hit(pair.tlas.handle, 0.25f, 1, 0);
    assert_false(fixture_trace(pair.tlas.handle, 2.25f, 0.25f).isHit);
    destroy((uint64_t)pair.blas.handle);
    assert_false(fixture_trace(pair.tlas.handle, 0.25f, 0.25f).isHit);
    destroy((uint64_t)empty.handle);
    destroy((uint64_t)pair.tlas.handle);
    expect_mistake(fixture_trace_none(pair.tlas.handle));
}

static VkResult build_again(void)
{
    return host_build(&pair.triangles, pair.blas.handle, VK_NULL_HANDLE);
}

/* Each leaves the structure as it was. */
NOISY_TEST(test_bad_pointers)
{
    open_pair(10, UPDATABLE);
    size_t page = (size_t)sysconf(_SC_PAGESIZE);
    char *hole = mmap(NULL, 2 * page, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    mprotect(hole + page, page, PROT_NONE);
    VkAccelerationStructureGeometryTrianglesDataKHR *triangles =
        &pair.triangles.geometry.geometry.triangles;
    const VkAccelerationStructureGeometryTrianglesDataKHR valid = *triangles;

    triangles->vertexData.hostAddress = NULL;
    expect_mistake(build_again());
    triangles->vertexData.hostAddress = hole + page - 100; /* three triangles are 108 bytes */
    expect_mistake(build_again());
    triangles->vertexData.hostAddress = hole + page - 10 * 36;
    GET(build_again());
    *triangles = valid;
    triangles->vertexStride = UINT64_MAX;
    expect_mistake(build_again());
    *triangles = valid;
    triangles->indexType = VK_INDEX_TYPE_UINT32;
    triangles->indexData.hostAddress = hole + page - 119;
    expect_mistake(build_again());
    triangles->indexData.hostAddress = hole + page - 120;
    GET(build_again());
    memset(hole, 0xff, page); /* wild indices */
    expect_mistake(build_again());
    *triangles = valid;
    triangles->transformData.hostAddress = hole + page - 47;
    expect_mistake(build_again());
    *triangles = valid;
    triangles->vertexFormat = VK_FORMAT_D32_SFLOAT;
    expect_mistake(build_again());
    *triangles = valid;

    pair.triangles.info.scratchData.hostAddress = hole + page; /* the backend has its own */
    GET(build_again());
    pair.triangles.info.scratchData.hostAddress = pair.triangles.scratch;
    pair.triangles.info.pGeometries = (const void *)(hole + page - 8);
    expect_mistake(build_again());
    pair.triangles.info.pGeometries = &pair.triangles.geometry;
    pair.instances.geometry.geometry.instances.arrayOfPointers = VK_TRUE;
    expect_mistake(host_build(&pair.instances, pair.tlas.handle, VK_NULL_HANDLE));
    expect_mistake(vk.WriteAccelerationStructuresPropertiesKHR(device, 1, &pair.blas.handle,
                                                               STRUCTURE_SIZE, 8, hole + page, 8));
    GET(build_again());
    expect_pair(pair.tlas.handle, 1);
    munmap(hole, 2 * page);
}

/* A shape that the source hasn't, and a structure that is too small. */
NOISY_TEST(test_bad_builds)
{
    open_pair(10, UPDATABLE);
    pair.triangles.range.primitiveCount = 9;
    expect_mistake(host_build(&pair.triangles, pair.blas.handle, pair.blas.handle));
    pair.triangles.range.primitiveCount = 10;
    struct fixture_structure small = fixture_create_blas(256);
    expect_mistake(host_build(&pair.triangles, small.handle, VK_NULL_HANDLE));
    expect_mistake(host_build(&pair.triangles, pair.blas.handle, small.handle));
    expect_pair(pair.tlas.handle, 1);
}
