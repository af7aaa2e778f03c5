/* SPDX-License-Identifier: Apache-2.0 */
/* Backend cpu through the loader: parameters that no program can lose, and what the extension for
 * motion costs scenes without motion. */
#include "host_fixture.h"

#include <stdlib.h>
#include <string.h>

/* ---- structures that cannot be read: nothing is built, and sizes are 0 */

static void expect_nothing(struct fixture_build *build, VkAccelerationStructureKHR dst)
{
    assert_int_equal(fixture_sizes(build).accelerationStructureSize, 0);
    expect_mistake(host_build(build, dst, VK_NULL_HANDLE));
}

NOISY_TEST(test_unreadable_chains)
{
    const void *const nowhere = (const void *)(uintptr_t)0x1000;
    open_pair(10, 0);
    struct fixture_build spheres = pair.triangles;
    pair.triangles.geometry.geometry.triangles.pNext = nowhere;
    expect_nothing(&pair.triangles, pair.blas.handle);
    spheres.geometry.geometryType = VK_GEOMETRY_TYPE_SPHERES_NV;
    spheres.geometry.pNext = nowhere;
    spheres.info.pGeometries = &spheres.geometry;
    expect_nothing(&spheres, pair.blas.handle);
    expect_pair(pair.tlas.handle, 1);
}

NOISY_TEST(test_unreadable_usage_counts)
{
    const STRUCT(VkMicromapBuildInfoEXT, info, .usageCountsCount = 1,
                 .pUsageCounts = (const void *)(uintptr_t)0x1000);
    STRUCT(VkMicromapBuildSizesInfoEXT, sizes, .micromapSize = 1);
    vk.GetMicromapBuildSizesEXT(device, VK_ACCELERATION_STRUCTURE_BUILD_TYPE_HOST_KHR, &info,
                                &sizes);
    assert_int_equal(sizes.micromapSize, 1); /* the call is skipped */
    expect_mistake(vk.BuildMicromapsEXT(device, VK_NULL_HANDLE, 1, &info));
}

SILENT_TEST(test_micromap_sizes)
{
    const VkMicromapUsageEXT usage = {1, 1, VK_OPACITY_MICROMAP_FORMAT_4_STATE_EXT};
    const STRUCT(VkMicromapBuildInfoEXT, info, .usageCountsCount = 1, .pUsageCounts = &usage);
    STRUCT(VkMicromapBuildSizesInfoEXT, sizes, .discardable = VK_TRUE);
    vk.GetMicromapBuildSizesEXT(device, VK_ACCELERATION_STRUCTURE_BUILD_TYPE_HOST_KHR, &info,
                                &sizes);
    assert_in_range(sizes.micromapSize, 1, 4096);
    assert_false(sizes.discardable);
}

/* ---- what it costs */

struct cost {
    AssayCounters counters;
    VkAccelerationStructureBuildSizesInfoKHR sizes[2];
    void *bytes; /* of the BLAS, whose references are none */
    size_t size;
};

static struct cost cost_of_still_scene(void)
{
    struct cost cost;
    open_pair(10, 0);
    expect_pair(pair.tlas.handle, 1);
    cost.bytes = fixture_serialize(pair.blas.handle, &cost.size);
    cost.sizes[0] = fixture_sizes(&pair.triangles);
    cost.sizes[1] = fixture_sizes(&pair.instances);
    cost.counters = fixture_counters();
    destroy_pair();
    return cost;
}

static void expect_same_sizes(const VkAccelerationStructureBuildSizesInfoKHR *a,
                              const VkAccelerationStructureBuildSizesInfoKHR *b)
{
    assert_int_equal(a->accelerationStructureSize, b->accelerationStructureSize);
    assert_int_equal(a->buildScratchSize, b->buildScratchSize);
    assert_int_equal(a->updateScratchSize, b->updateScratchSize);
}

SILENT_TEST(test_no_motion_costs_nothing)
{
    const STRUCT(VkPhysicalDeviceAccelerationStructureFeaturesKHR, features,
                 .accelerationStructure = VK_TRUE, .accelerationStructureHostCommands = VK_TRUE);
    const VkDevice first = device;
    const VkuDeviceDispatchTable first_vk = vk;
    VkuDeviceDispatchTable with_vk, without_vk;
    VkDevice with = instance_fixture_open_device(&instance, &with_vk), without;
    GET(instance_fixture_create_device(&instance, &features, backend_extensions, 2, &without,
                                       &without_vk));
    fixture_use_device(with, &with_vk);
    struct cost a = cost_of_still_scene();
    vk.DestroyDevice(with, NULL);
    fixture_use_device(without, &without_vk);
    struct cost b = cost_of_still_scene();
    vk.DestroyDevice(without, NULL);
    fixture_use_device(first, &first_vk);

    assert_memory_equal(&a.counters, &b.counters, sizeof(a.counters));
    for (int i = 0; i < 2; i++)
        expect_same_sizes(&a.sizes[i], &b.sizes[i]);
    assert_int_equal(a.size, b.size);
    assert_memory_equal(a.bytes, b.bytes, a.size);
}
