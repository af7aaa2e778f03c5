/* SPDX-License-Identifier: Apache-2.0 */
/* Builds of command buffers on backend cpu, through the loader: what they read is what was there
 * when they executed, whenever the tree is asked for; and none is made that nobody asks for. */
#include "device_fixture.h"

#include <stdlib.h>
#include <string.h>

enum {
    TRIANGLES = 50,
    TRIANGLE_SIZE = 9 * sizeof(float),
    UPDATABLE = VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_UPDATE_BIT_KHR,
    COMPACTABLE = VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_COMPACTION_BIT_KHR,
};

static const VkCommandBufferLevel SECONDARY = VK_COMMAND_BUFFER_LEVEL_SECONDARY;

/* ---- scenes: a BLAS of triangles, and a TLAS of two instances of it */

static struct {
    struct fixture_build host_triangles, host_instances;
    struct device_build triangles, instances;
    struct fixture_structure blas, tlas;
} scene;

static void open_scene(VkBuildAccelerationStructureFlagsKHR flags)
{
    fixture_triangles(&scene.host_triangles, TRIANGLES, flags);
    scene.blas = fixture_create_for(&scene.host_triangles);
    device_build_create(&scene.host_triangles, TRIANGLES * TRIANGLE_SIZE, &scene.triangles);
    const VkAccelerationStructureKHR blases[] = {scene.blas.handle, scene.blas.handle};
    fixture_instances(&scene.host_instances, blases, 2, flags);
    scene.tlas = fixture_create_for(&scene.host_instances);
    device_build_create(&scene.host_instances, 2 * sizeof(VkAccelerationStructureInstanceKHR),
                        &scene.instances);
}

/* Triangles at (x, y, z), as far as the command buffer goes. */
static void record_triangles(VkCommandBuffer commands, float y, VkAccelerationStructureKHR dst,
                             VkAccelerationStructureKHR src)
{
    fixture_move(&scene.host_triangles, 0, y, 0);
    device_upload(commands, &scene.triangles);
    device_build(commands, &scene.triangles, dst, src);
}

static void record_scene(VkCommandBuffer commands)
{
    record_triangles(commands, 0, scene.blas.handle, VK_NULL_HANDLE);
    device_upload(commands, &scene.instances);
    device_build(commands, &scene.instances, scene.tlas.handle, VK_NULL_HANDLE);
}

/* Whether the triangles of a structure are where they are after record_triangles(y). */
static bool is_at(VkAccelerationStructureKHR structure, float y)
{
    return fixture_trace(structure, y + 0.25f, 0.25f).isHit &&
           !fixture_trace(structure, y - 0.25f, 0.25f).isHit;
}

/* Another structure for the same build. */
static struct fixture_structure create_twin(struct fixture_build *build)
{
    return fixture_create_for(build);
}

static void record_clone(VkCommandBuffer commands, VkAccelerationStructureKHR src,
                         VkAccelerationStructureKHR dst)
{
    device_copy(commands, src, dst, VK_COPY_ACCELERATION_STRUCTURE_MODE_CLONE_KHR);
    device_barrier(commands);
}

/* ---- tests */

SILENT_TEST(test_same_as_host_build)
{
    open_scene(0);
    VkCommandBuffer commands = device_begin(PRIMARY);
    record_scene(commands);
    device_finish(commands);
    assert_true(fixture_trace(scene.tlas.handle, 0.25f, 0.25f).isHit);
    assert_true(fixture_trace(scene.tlas.handle, 2.25f, 0.25f).isHit);
    assert_false(fixture_trace(scene.tlas.handle, 1.25f, 0.25f).isHit);

    struct fixture_structure blas = create_twin(&scene.host_triangles);
    struct fixture_structure tlas = create_twin(&scene.host_instances);
    GET(host_build(&scene.host_triangles, blas.handle, VK_NULL_HANDLE));
    GET(host_build(&scene.host_instances, tlas.handle, VK_NULL_HANDLE));
    expect_same_bytes(scene.blas.handle, blas.handle);
    expect_same_bytes(scene.tlas.handle, tlas.handle);
}

SILENT_TEST(test_only_what_is_asked_for)
{
    open_scene(UPDATABLE);
    const AssayCounters before = fixture_counters();
    VkCommandBuffer commands = device_begin(PRIMARY);
    record_scene(commands);
    device_end(commands);
    for (int i = 0; i < 3; i++)
        device_run(commands);
    const AssayCounters submitted = fixture_counters();
    assert_int_equal(submitted.builds, before.builds);
    assert_int_equal(submitted.bytesSnapshot - before.bytesSnapshot,
                     TRIANGLES * TRIANGLE_SIZE + 2 * sizeof(VkAccelerationStructureInstanceKHR));
    assert_true(is_at(scene.blas.handle, 0));
    assert_int_equal(fixture_counters().builds - before.builds, 1);
    fixture_trace(scene.tlas.handle, 0, 0);
    assert_int_equal(fixture_counters().builds - before.builds, 2);
}

/* However many updates nobody looked at, one is carried out. */
SILENT_TEST(test_updates)
{
    open_scene(UPDATABLE);
    const AssayCounters before = fixture_counters();
    for (int i = 0; i < 20; i++) {
        VkCommandBuffer commands = device_begin(PRIMARY);
        record_triangles(commands, (float)i, scene.blas.handle,
                         i ? scene.blas.handle : VK_NULL_HANDLE);
        device_finish(commands);
    }
    assert_true(is_at(scene.blas.handle, 19));
    const AssayCounters after = fixture_counters();
    assert_int_equal(after.builds - before.builds, 1);
    assert_int_equal(after.updates - before.updates, 1);
}

/* A TLAS is built over its BLAS as it was then, though that is rebuilt, or gone, before anybody
 * asks. */
SILENT_TEST(test_tlas_keeps_its_timestamp)
{
    open_scene(0);
    struct fixture_structure twin = create_twin(&scene.host_instances);
    GET(host_build(&scene.host_triangles, scene.blas.handle, VK_NULL_HANDLE));
    GET(host_build(&scene.host_instances, twin.handle, VK_NULL_HANDLE));
    size_t twin_size, size;
    const void *twin_bytes = fixture_serialize(twin.handle, &twin_size);
    destroy((uint64_t)twin.handle);

    VkCommandBuffer commands = device_begin(PRIMARY);
    record_scene(commands);
    device_finish(commands);
    commands = device_begin(PRIMARY);
    record_triangles(commands, 100, scene.blas.handle, VK_NULL_HANDLE);
    device_finish(commands);
    destroy((uint64_t)scene.blas.handle);
    const void *bytes = fixture_serialize(scene.tlas.handle, &size);
    assert_int_equal(size, twin_size);
    assert_memory_equal(bytes, twin_bytes, size);
}

/* A command buffer that runs again overwrites the snapshots of its last run, which a clone still
 * needs. */
SILENT_TEST(test_resubmission)
{
    open_scene(0);
    struct fixture_structure clone = create_twin(&scene.host_triangles);
    VkCommandBuffer build = device_begin(PRIMARY);
    record_triangles(build, 0, scene.blas.handle, VK_NULL_HANDLE);
    device_end(build);
    VkCommandBuffer copy = device_begin(PRIMARY);
    record_clone(copy, scene.blas.handle, clone.handle);
    device_end(copy);

    const AssayCounters before = fixture_counters();
    device_run(build);
    device_run(copy);
    fixture_move(&scene.host_triangles, 0, 7, 0);
    memcpy(scene.triangles.staging.bytes, scene.host_triangles.data, TRIANGLES * TRIANGLE_SIZE);
    device_run(build);
    assert_int_equal(fixture_counters().builds, before.builds);
    assert_true(is_at(clone.handle, 0));
    assert_true(is_at(scene.blas.handle, 7));
}

SILENT_TEST(test_secondary)
{
    open_scene(0);
    VkCommandBuffer secondary = device_begin(SECONDARY);
    record_scene(secondary);
    device_end(secondary);
    VkCommandBuffer primary = device_begin(PRIMARY);
    vk.CmdExecuteCommands(primary, 1, &secondary);
    device_finish(primary);
    vk.FreeCommandBuffers(device, command_pool, 1, &secondary);
    assert_true(is_at(scene.blas.handle, 0));
    assert_true(fixture_trace(scene.tlas.handle, 2.25f, 0.25f).isHit);
}

/* Each execution copies to the same place. Only what is asked for is told, and only once. */
NOISY_TEST(test_executed_twice_at_once)
{
    open_scene(0);
    struct fixture_structure clone = create_twin(&scene.host_triangles);
    VkCommandBuffer secondary = device_begin(SECONDARY);
    record_triangles(secondary, 0, scene.blas.handle, VK_NULL_HANDLE);
    device_end(secondary);
    VkCommandBuffer primary = device_begin(PRIMARY);
    vk.CmdExecuteCommands(primary, 1, &secondary);
    record_clone(primary, scene.blas.handle, clone.handle);
    vk.CmdExecuteCommands(primary, 1, &secondary);
    device_end(primary);
    for (int i = 0; i < 2; i++) {
        device_run(primary);
        assert_true(is_at(scene.blas.handle, 0));
        expect_silence();
    }
    assert_true(is_at(clone.handle, 0));
    assert_int_equal(messages->count, 1);
    assert_non_null(strstr(messages->items[0].text, "what the last one copied"));
    device_run(primary);
    assert_true(is_at(clone.handle, 0));
    assert_int_equal(messages->count, 1);
}

SILENT_TEST(test_indirect)
{
    open_scene(0);
    enum { SKIPPED = 10, COUNT = 5 };
    struct device_buffer ranges = device_buffer_create(64);
    const VkAccelerationStructureBuildRangeInfoKHR range = {
        .primitiveCount = COUNT, .primitiveOffset = SKIPPED * TRIANGLE_SIZE};
    memcpy(ranges.bytes + 16, &range, sizeof(range));
    const VkDeviceAddress address = ranges.address + 16;
    const uint32_t stride = sizeof(range), maximum = TRIANGLES;
    const uint32_t *const maxima = &maximum;

    VkCommandBuffer commands = device_begin(PRIMARY);
    device_upload(commands, &scene.triangles);
    scene.triangles.info.dstAccelerationStructure = scene.blas.handle;
    vk.CmdBuildAccelerationStructuresIndirectKHR(commands, 1, &scene.triangles.info, &address,
                                                 &stride, &maxima);
    device_finish(commands);
    const AssayHit hit = fixture_trace(scene.blas.handle, 0.25f, 0.25f);
    assert_true(hit.isHit);
    assert_int_equal(hit.primitive, 0);
    assert_float_equal(hit.t, SKIPPED + 1, 0); /* the ray begins at x = -1 */
}
