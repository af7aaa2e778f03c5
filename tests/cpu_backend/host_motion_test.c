/* SPDX-License-Identifier: Apache-2.0 */
/* What moves, built by the host on backend cpu, through the loader: it is hit where it is at the
 * ray's time, and what doesn't move costs what it did without the extension. */
#include "host_scene.h"
#include "motion_scene.h"

#include <stdlib.h>
#include <string.h>

static struct moving_scene moving;

static void close_moving(void)
{
    moving_scene_close(&fixture, &moving);
    expect_silence();
}

TEST_CLOSED(test_triangles_and_instances, close_moving)
{
    moving_scene_open(&fixture, &moving, 0);
    moving_scene_build(&fixture, &moving);
    expect_moving_blas(&fixture, moving.blas.handle, 4);
    expect_moving_tlas(&fixture, moving.tlas.handle);
}

/* Of a build with motion, geometries may stand still. */
TEST_CLOSED(test_still_triangles, close_moving)
{
    moving_scene_open(&fixture, &moving, 0);
    moving.triangles.geometry.geometry.triangles.pNext = NULL;
    GET(host_build(&moving.triangles, moving.blas.handle, 0));
    expect_moving_blas(&fixture, moving.blas.handle, 0);
}

TEST_CLOSED(test_update, close_moving)
{
    moving_scene_open(&fixture, &moving, UPDATABLE);
    moving_scene_build(&fixture, &moving);
    for (uint32_t i = 0; i < MOVING_TRIANGLES * 9; i += 3)
        moving.then[i] += 3;
    GET(host_build(&moving.triangles, moving.blas.handle, moving.blas.handle));
    expect_moving_blas(&fixture, moving.blas.handle, 7);
}

/* Pointers have the type of what they point to in their low 4 bits. */
TEST_CLOSED(test_array_of_pointers, expect_silence)
{
    moving_scene_open(&fixture, &moving, 0);
    VkAccelerationStructureMotionInstanceDataNV *data =
        aligned_alloc(16, MOVING_INSTANCES * sizeof(*data));
    uint64_t pointers[MOVING_INSTANCES];
    for (uint32_t i = 0; i < MOVING_INSTANCES; i++) {
        VkAccelerationStructureMotionInstanceNV instance;
        memcpy(&instance, (char *)moving.instances.data + i * MOTION_INSTANCE_STRIDE,
               sizeof(instance));
        data[i] = instance.data;
        pointers[i] = (uint64_t)(uintptr_t)&data[i] | instance.type;
    }
    moving.instances.geometry.geometry.instances.arrayOfPointers = VK_TRUE;
    moving.instances.geometry.geometry.instances.data.hostAddress = pointers;
    moving_scene_build(&fixture, &moving);
    expect_moving_tlas(&fixture, moving.tlas.handle);
    moving_scene_close(&fixture, &moving);
    free(data);
}

/* Vertices that aren't there, and a chain that isn't. */
TEST_CLOSED(test_unreadable, forget_messages)
{
    moving_scene_open(&fixture, &moving, 0);
    moving.motion.vertexData.deviceAddress = 0x1000;
    expect_mistake(host_build(&moving.triangles, moving.blas.handle, 0));
    moving.triangles.geometry.geometry.triangles.pNext = (void *)(uintptr_t)0x1000;
    expect_mistake(host_build(&moving.triangles, moving.blas.handle, 0));
    assert_int_equal(fixture_sizes(&fixture, &moving.triangles).accelerationStructureSize, 0);
    moving_scene_close(&fixture, &moving);
}

/* As assay.h had rays before they had a time. */
TEST_CLOSED(test_rays_without_time, close_moving)
{
    struct untimed {
        float origin[3], tMin, direction[3], tMax;
        uint32_t flags, cullMask;
    };
    moving_scene_open(&fixture, &moving, 0);
    moving_scene_build(&fixture, &moving);
    const struct untimed rays[] = {
        {.origin = {-1, 9, 0.25f}, .direction = {1, 0, 0}, .tMax = 1e30f, .cullMask = 0xff},
        {.origin = {-1, 0.25f, 0.25f}, .direction = {1, 0, 0}, .tMax = 1e30f, .cullMask = 0xff},
    };
    AssayHit hits[2];
    const AssayTraceInfo info = {.accelerationStructure = (uint64_t)moving.tlas.handle,
                                 .accuracy = ASSAY_ACCURACY_EXACT,
                                 .rayCount = 2,
                                 .raySize = sizeof(rays[0]),
                                 .hitSize = sizeof(hits[0]),
                                 .rays = (const AssayRay *)(const void *)rays,
                                 .hits = hits};
    GET(fixture.trace_rays(fixture.device, &info));
    assert_false(hits[0].isHit);
    assert_true(hits[1].isHit);
    assert_float_equal(hits[1].t, 1, 0);
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
    open_scene(10, 0);
    expect_scene(scene.tlas.handle, 1);
    cost.bytes = serialize(scene.blas.handle, &cost.size);
    cost.sizes[0] = fixture_sizes(&fixture, &scene.triangles);
    cost.sizes[1] = fixture_sizes(&fixture, &scene.instances);
    cost.counters = fixture_counters(&fixture);
    close_scene();
    return cost;
}

static void expect_same_sizes(const VkAccelerationStructureBuildSizesInfoKHR *a,
                              const VkAccelerationStructureBuildSizesInfoKHR *b)
{
    assert_int_equal(a->accelerationStructureSize, b->accelerationStructureSize);
    assert_int_equal(a->buildScratchSize, b->buildScratchSize);
    assert_int_equal(a->updateScratchSize, b->updateScratchSize);
}

TEST_CLOSED(test_no_motion_costs_nothing, expect_silence)
{
    const STRUCT(VkPhysicalDeviceAccelerationStructureFeaturesKHR, features,
                 .accelerationStructure = VK_TRUE, .accelerationStructureHostCommands = VK_TRUE);
    const VkDevice first = fixture.device;
    const VkuDeviceDispatchTable vk = fixture.vk;
    VkuDeviceDispatchTable with_vk, without_vk;
    VkDevice with = instance_fixture_open_device(&fixture.instance_fixture, &with_vk), without;
    GET(instance_fixture_create_device(&fixture.instance_fixture, &features, backend_extensions, 2,
                                       &without, &without_vk));
    fixture_use_device(&fixture, with, &with_vk);
    struct cost a = cost_of_still_scene();
    fixture.vk.DestroyDevice(with, NULL);
    fixture_use_device(&fixture, without, &without_vk);
    struct cost b = cost_of_still_scene();
    fixture.vk.DestroyDevice(without, NULL);
    fixture_use_device(&fixture, first, &vk);

    assert_memory_equal(&a.counters, &b.counters, sizeof(a.counters));
    for (int i = 0; i < 2; i++)
        expect_same_sizes(&a.sizes[i], &b.sizes[i]);
    assert_int_equal(a.size, b.size);
    assert_memory_equal(a.bytes, b.bytes, a.size);
    free(a.bytes);
    free(b.bytes);
}
