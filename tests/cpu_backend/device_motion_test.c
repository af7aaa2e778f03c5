/* SPDX-License-Identifier: Apache-2.0 */
/* What moves, built by command buffers on backend cpu, through the loader: the same as by the host,
 * from what was there when they executed. */
#include "device_fixture.h"
#include "motion_scene.h"

#include <stdlib.h>
#include <string.h>

/* ---- the scene, with its data in buffers */

static struct {
    struct moving_scene host;
    VkAccelerationStructureGeometryMotionTrianglesDataNV motion;
    struct device_build triangles, instances;
    struct device_buffer then;
} moving;

static void open_device_scene(void)
{
    moving_scene_open(&moving.host, 0);
    device_build_create(&moving.host.triangles, &moving.triangles);
    device_build_create(&moving.host.instances, &moving.instances);
    moving.then = device_buffer_create(MOTION_VERTICES_SIZE);
    memcpy(moving.then.bytes, moving.host.then, MOTION_VERTICES_SIZE);
    moving.motion = moving.host.motion;
    moving.motion.vertexData.deviceAddress = moving.then.address;
    moving.triangles.geometry.geometry.triangles.pNext = &moving.motion;
}

#define SCENE_TEST(name) TEST_BETWEEN(name, open_device_scene, close_silent_test)

/* Once they have executed, nothing is left of the data. */
static void build_scene(void)
{
    VkCommandBuffer commands = device_begin(PRIMARY);
    device_upload(commands, &moving.triangles);
    device_upload(commands, &moving.instances);
    device_build(commands, &moving.triangles, moving.host.blas.handle, VK_NULL_HANDLE);
    device_build(commands, &moving.instances, moving.host.tlas.handle, VK_NULL_HANDLE);
    device_finish(commands);
    memset(moving.then.bytes, 0, MOTION_VERTICES_SIZE);
    memset(moving.triangles.data.bytes, 0, MOTION_VERTICES_SIZE);
    memset(moving.instances.data.bytes, 0, MOTION_INSTANCES_SIZE);
}

static void expect_same_as_by_the_host(struct moving_scene *host)
{
    size_t sizes[4];
    void *bytes[4];
    bytes[0] = fixture_serialize(host->blas.handle, &sizes[0]);
    bytes[1] = fixture_serialize(host->tlas.handle, &sizes[1]);
    moving_scene_build(host);
    bytes[2] = fixture_serialize(host->blas.handle, &sizes[2]);
    bytes[3] = fixture_serialize(host->tlas.handle, &sizes[3]);
    for (int i = 0; i < 2; i++) {
        assert_int_equal(sizes[i], sizes[i + 2]);
        assert_memory_equal(bytes[i], bytes[i + 2], sizes[i]);
    }
}

/* ---- tests */

SCENE_TEST(test_same_as_host_build)
{
    const AssayCounters before = fixture_counters();
    build_scene();
    assert_int_equal(fixture_counters().bytesSnapshot - before.bytesSnapshot,
                     2 * MOTION_VERTICES_SIZE + MOTION_INSTANCES_SIZE);
    expect_moving_blas(moving.host.blas.handle, 4);
    expect_moving_tlas(moving.host.tlas.handle);
    expect_same_as_by_the_host(&moving.host);
}

SCENE_TEST(test_offsets)
{
    moving.host.triangles.range =
        (VkAccelerationStructureBuildRangeInfoKHR){.primitiveCount = MOVING_TRIANGLES - 2,
                                                   .primitiveOffset = 9 * sizeof(float),
                                                   .firstVertex = 3};
    moving.host.instances.range = (VkAccelerationStructureBuildRangeInfoKHR){
        .primitiveCount = MOVING_INSTANCES - 1, .primitiveOffset = MOTION_INSTANCE_STRIDE};
    build_scene();
    /* The last of the triangles, by the first of the instances: 2 from where the others begin. */
    expect_hit_at(fixture_trace_at(moving.host.tlas.handle, 2.25f, 0.25f, 1), 1 + 2 + 4 + 8, 0);
    expect_same_as_by_the_host(&moving.host);
}

SCENE_TEST(test_indirect)
{
    const VkAccelerationStructureBuildRangeInfoKHR range = {
        .primitiveCount = 1, .primitiveOffset = 9 * sizeof(float), .firstVertex = 3};
    VkCommandBuffer commands = device_begin(PRIMARY);
    device_upload(commands, &moving.triangles);
    moving.triangles.info.dstAccelerationStructure = moving.host.blas.handle;
    device_build_indirect(commands, &moving.triangles.info, MOVING_TRIANGLES, &range);
    device_finish(commands);
    expect_hit_at(fixture_trace_at(moving.host.blas.handle, 0.25f, 0.25f, 0.5f), 1 + 2 + 2, 0);
}

/* ---- pointers, whose low 4 bits are types */

enum { POINTERS = MOVING_INSTANCES + 1, APART = 160 };

/* In `instances`, so that each ends where the next one or the buffer's end comes, the last of them
 * first. */
static void point_to_instances(const struct device_buffer *instances, uint64_t pointers[POINTERS])
{
    static const size_t sizes[] = {sizeof(VkAccelerationStructureInstanceKHR),
                                   sizeof(VkAccelerationStructureMatrixMotionInstanceNV),
                                   sizeof(VkAccelerationStructureSRTMotionInstanceNV)};
    for (uint32_t i = 0; i < MOVING_INSTANCES; i++) {
        VkAccelerationStructureMotionInstanceNV element;
        const size_t at = (size_t)(MOVING_INSTANCES - i) * APART - sizes[i];
        memcpy(&element, (char *)moving.host.instances.data + (size_t)i * MOTION_INSTANCE_STRIDE,
               sizeof(element));
        memcpy(instances->bytes + at, &element.data, sizes[i]);
        pointers[i] = (instances->address + at) | element.type;
    }
    pointers[MOVING_INSTANCES] = VK_ACCELERATION_STRUCTURE_MOTION_INSTANCE_TYPE_SRT_MOTION_NV;
}

/* Content may tell of the null pointer. */
TEST_BETWEEN(test_array_of_pointers, open_device_scene, close_noisy_test)
{
    struct device_buffer instances = device_buffer_create((VkDeviceSize)MOVING_INSTANCES * APART);
    struct device_buffer pointers = device_buffer_create(POINTERS * sizeof(uint64_t));
    point_to_instances(&instances, (uint64_t *)pointers.bytes);
    moving.instances.geometry.geometry.instances.arrayOfPointers = VK_TRUE;
    moving.instances.geometry.geometry.instances.data.deviceAddress = pointers.address;
    moving.host.instances.range.primitiveCount = POINTERS;
    moving.host.tlas = fixture_create_for(&moving.host.instances);
    build_scene();
    memset(instances.bytes, 0, (size_t)MOVING_INSTANCES * APART); /* too late to matter */
    expect_moving_tlas(moving.host.tlas.handle);
}
