/* SPDX-License-Identifier: Apache-2.0 */
/* What moves, built by the host on backend cpu, through the loader: it is hit where it is at the
 * ray's time, and what doesn't move costs what it did without the extension. */
#include "host_fixture.h"
#include "motion_scene.h"

#include <stdlib.h>
#include <string.h>

static struct moving_scene moving;

SILENT_TEST(test_triangles_and_instances)
{
    moving_scene_open(&moving, 0);
    moving_scene_build(&moving);
    expect_moving_blas(moving.blas.handle, 4);
    expect_moving_tlas(moving.tlas.handle);
}

/* Of a build with motion, geometries may stand still. */
SILENT_TEST(test_still_triangles)
{
    moving_scene_open(&moving, 0);
    moving.triangles.geometry.geometry.triangles.pNext = NULL;
    GET(host_build(&moving.triangles, moving.blas.handle, 0));
    expect_moving_blas(moving.blas.handle, 0);
}

SILENT_TEST(test_update)
{
    moving_scene_open(&moving, UPDATABLE);
    moving_scene_build(&moving);
    for (uint32_t i = 0; i < MOVING_TRIANGLES * 9; i += 3)
        moving.then[i] += 3;
    GET(host_build(&moving.triangles, moving.blas.handle, moving.blas.handle));
    expect_moving_blas(moving.blas.handle, 7);
}

/* Pointers have the type of what they point to in their low 4 bits. */
SILENT_TEST(test_array_of_pointers)
{
    moving_scene_open(&moving, 0);
    VkAccelerationStructureMotionInstanceDataNV *data =
        own_block(aligned_alloc(16, MOVING_INSTANCES * sizeof(*data)));
    uint64_t pointers[MOVING_INSTANCES];
    for (uint32_t i = 0; i < MOVING_INSTANCES; i++) {
        VkAccelerationStructureMotionInstanceNV element;
        memcpy(&element, (char *)moving.instances.data + i * MOTION_INSTANCE_STRIDE,
               sizeof(element));
        data[i] = element.data;
        pointers[i] = (uint64_t)(uintptr_t)&data[i] | element.type;
    }
    moving.instances.geometry.geometry.instances.arrayOfPointers = VK_TRUE;
    moving.instances.geometry.geometry.instances.data.hostAddress = pointers;
    moving_scene_build(&moving);
    expect_moving_tlas(moving.tlas.handle);
}

/* Vertices that aren't there, and a chain that isn't. */
NOISY_TEST(test_unreadable)
{
    moving_scene_open(&moving, 0);
    moving.motion.vertexData.deviceAddress = 0x1000;
    expect_mistake(host_build(&moving.triangles, moving.blas.handle, 0));
    moving.triangles.geometry.geometry.triangles.pNext = (void *)(uintptr_t)0x1000;
    expect_mistake(host_build(&moving.triangles, moving.blas.handle, 0));
    assert_int_equal(fixture_sizes(&moving.triangles).accelerationStructureSize, 0);
}

/* As assay.h had rays before they had a time. */
SILENT_TEST(test_rays_without_time)
{
    struct untimed {
        float origin[3], tMin, direction[3], tMax;
        uint32_t flags, cullMask;
    };
    moving_scene_open(&moving, 0);
    moving_scene_build(&moving);
    const struct untimed rays[] = {
        {.origin = {-1, 9, 0.25f}, .direction = {1, 0, 0}, .tMax = 1e30f, .cullMask = 0xff},
        {.origin = {-1, 0.25f, 0.25f}, .direction = {1, 0, 0}, .tMax = 1e30f, .cullMask = 0xff},
    };
    AssayHit hits[2];
    AssayTraceInfo info = trace_info((uint64_t)moving.tlas.handle, ASSAY_ACCURACY_EXACT, 2,
                                     (const AssayRay *)(const void *)rays, hits);
    info.raySize = sizeof(rays[0]);
    GET(trace_rays(device, &info));
    assert_false(hits[0].isHit);
    expect_hit_at(hits[1], 1, 0);
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
