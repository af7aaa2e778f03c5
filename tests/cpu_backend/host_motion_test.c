/* SPDX-License-Identifier: Apache-2.0 */
/* Backend cpu with VK_NV_ray_tracing_motion_blur: what does not move costs what it costs without
 * the extension. tests/programs/backend/motion.cases has what moves. */
#include "host_fixture.h"

#include <stdlib.h>
#include <string.h>

/* A chain that leads nowhere. */
NOISY_TEST(test_unreadable_chain)
{
    open_pair(10, 0);
    pair.triangles.geometry.geometry.triangles.pNext = (void *)(uintptr_t)0x1000;
    expect_mistake(host_build(&pair.triangles, pair.blas.handle, 0));
    assert_int_equal(fixture_sizes(&pair.triangles).accelerationStructureSize, 0);
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
