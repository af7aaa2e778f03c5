/* SPDX-License-Identifier: Apache-2.0 */
/* Builds of command buffers on backend cpu, through the loader: what they read is what was there
 * when they executed, whenever the tree is asked for; and none is made that nobody asks for. */
#include "device_program.h"

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
    scene.blas = fixture_create_for(fixture, &scene.host_triangles);
    device_build_create(&device, &scene.host_triangles, TRIANGLES * TRIANGLE_SIZE,
                        &scene.triangles);
    const VkAccelerationStructureKHR blases[] = {scene.blas.handle, scene.blas.handle};
    fixture_instances(&scene.host_instances, blases, 2, flags);
    scene.tlas = fixture_create_for(fixture, &scene.host_instances);
    device_build_create(&device, &scene.host_instances,
                        2 * sizeof(VkAccelerationStructureInstanceKHR), &scene.instances);
}

static void close_scene(void)
{
    device_build_destroy(&device, &scene.triangles);
    device_build_destroy(&device, &scene.instances);
    fixture_destroy(fixture, &scene.tlas);
    fixture_destroy(fixture, &scene.blas);
    fixture_free(&scene.host_triangles);
    fixture_free(&scene.host_instances);
    device_expect_silence(&device);
}

/* Triangles at (x, y, z), as far as the command buffer goes. */
static void record_triangles(VkCommandBuffer commands, float y, VkAccelerationStructureKHR dst,
                             VkAccelerationStructureKHR src)
{
    fixture_move(&scene.host_triangles, 0, y, 0);
    device_upload(&device, commands, &scene.triangles);
    device_build(&device, commands, &scene.triangles, dst, src);
}

static void record_scene(VkCommandBuffer commands)
{
    record_triangles(commands, 0, scene.blas.handle, VK_NULL_HANDLE);
    device_upload(&device, commands, &scene.instances);
    device_build(&device, commands, &scene.instances, scene.tlas.handle, VK_NULL_HANDLE);
}

/* Whether the triangles of a structure are where they are after record_triangles(y). */
static bool is_at(VkAccelerationStructureKHR structure, float y)
{
    return fixture_trace(fixture, structure, y + 0.25f, 0.25f).isHit &&
           !fixture_trace(fixture, structure, y - 0.25f, 0.25f).isHit;
}

/* Another structure for the same build. */
static struct fixture_structure create_twin(struct fixture_build *build)
{
    free(build->scratch);
    return fixture_create_for(fixture, build);
}

static void host_build(struct fixture_build *build, VkAccelerationStructureKHR dst)
{
    GET(fixture_build(fixture, VK_NULL_HANDLE, build, dst, VK_NULL_HANDLE));
}

static void record_clone(VkCommandBuffer commands, VkAccelerationStructureKHR src,
                         VkAccelerationStructureKHR dst)
{
    device_copy(&device, commands, src, dst, VK_COPY_ACCELERATION_STRUCTURE_MODE_CLONE_KHR);
    device_barrier(&device, commands);
}

/* ---- tests */

TEST_CLOSED(test_same_as_host_build, close_scene)
{
    open_scene(0);
    VkCommandBuffer commands = device_begin(&device, PRIMARY);
    record_scene(commands);
    device_finish(&device, commands);
    assert_true(fixture_trace(fixture, scene.tlas.handle, 0.25f, 0.25f).isHit);
    assert_true(fixture_trace(fixture, scene.tlas.handle, 2.25f, 0.25f).isHit);
    assert_false(fixture_trace(fixture, scene.tlas.handle, 1.25f, 0.25f).isHit);

    struct fixture_structure blas = create_twin(&scene.host_triangles);
    struct fixture_structure tlas = create_twin(&scene.host_instances);
    host_build(&scene.host_triangles, blas.handle);
    host_build(&scene.host_instances, tlas.handle);
    device_expect_same_bytes(&device, scene.blas.handle, blas.handle);
    device_expect_same_bytes(&device, scene.tlas.handle, tlas.handle);
    fixture_destroy(fixture, &blas);
    fixture_destroy(fixture, &tlas);
}

TEST_CLOSED(test_only_what_is_asked_for, close_scene)
{
    open_scene(UPDATABLE);
    const AssayCounters before = fixture_counters(fixture);
    VkCommandBuffer commands = device_begin(&device, PRIMARY);
    record_scene(commands);
    device_end(&device, commands);
    for (int i = 0; i < 3; i++)
        device_run(&device, commands);
    const AssayCounters submitted = fixture_counters(fixture);
    assert_int_equal(submitted.builds, before.builds);
    assert_int_equal(submitted.bytesSnapshot - before.bytesSnapshot,
                     TRIANGLES * TRIANGLE_SIZE + 2 * sizeof(VkAccelerationStructureInstanceKHR));
    assert_true(is_at(scene.blas.handle, 0));
    assert_int_equal(fixture_counters(fixture).builds - before.builds, 1);
    fixture_trace(fixture, scene.tlas.handle, 0, 0);
    assert_int_equal(fixture_counters(fixture).builds - before.builds, 2);
    fixture->vk.FreeCommandBuffers(fixture->device, device.pool, 1, &commands);
}

/* However many updates nobody looked at, one is carried out. */
TEST_CLOSED(test_updates, close_scene)
{
    open_scene(UPDATABLE);
    const AssayCounters before = fixture_counters(fixture);
    for (int i = 0; i < 20; i++) {
        VkCommandBuffer commands = device_begin(&device, PRIMARY);
        record_triangles(commands, (float)i, scene.blas.handle,
                         i ? scene.blas.handle : VK_NULL_HANDLE);
        device_finish(&device, commands);
    }
    assert_true(is_at(scene.blas.handle, 19));
    const AssayCounters after = fixture_counters(fixture);
    assert_int_equal(after.builds - before.builds, 1);
    assert_int_equal(after.updates - before.updates, 1);
}

/* A TLAS is built over its BLAS as it was then, though that is rebuilt, or gone, before anybody
 * asks. */
TEST_CLOSED(test_tlas_keeps_its_timestamp, close_scene)
{
    open_scene(0);
    struct fixture_structure twin = create_twin(&scene.host_instances);
    host_build(&scene.host_triangles, scene.blas.handle);
    host_build(&scene.host_instances, twin.handle);
    size_t twin_size, size;
    void *twin_bytes = device_serialize(&device, twin.handle, &twin_size);
    fixture_destroy(fixture, &twin);

    VkCommandBuffer commands = device_begin(&device, PRIMARY);
    record_scene(commands);
    device_finish(&device, commands);
    commands = device_begin(&device, PRIMARY);
    record_triangles(commands, 100, scene.blas.handle, VK_NULL_HANDLE);
    device_finish(&device, commands);
    fixture->vk.DestroyAccelerationStructureKHR(fixture->device, scene.blas.handle, NULL);
    scene.blas.handle = VK_NULL_HANDLE;
    void *bytes = device_serialize(&device, scene.tlas.handle, &size);
    assert_int_equal(size, twin_size);
    assert_memory_equal(bytes, twin_bytes, size);
    free(bytes);
    free(twin_bytes);
}

/* A command buffer that runs again overwrites the snapshots of its last run, which a clone still
 * needs. */
TEST_CLOSED(test_resubmission, close_scene)
{
    open_scene(0);
    struct fixture_structure clone = create_twin(&scene.host_triangles);
    VkCommandBuffer build = device_begin(&device, PRIMARY);
    record_triangles(build, 0, scene.blas.handle, VK_NULL_HANDLE);
    device_end(&device, build);
    VkCommandBuffer copy = device_begin(&device, PRIMARY);
    record_clone(copy, scene.blas.handle, clone.handle);
    device_end(&device, copy);

    const AssayCounters before = fixture_counters(fixture);
    device_run(&device, build);
    device_run(&device, copy);
    fixture_move(&scene.host_triangles, 0, 7, 0);
    memcpy(scene.triangles.staging.bytes, scene.host_triangles.data, TRIANGLES * TRIANGLE_SIZE);
    device_run(&device, build);
    assert_int_equal(fixture_counters(fixture).builds, before.builds);
    assert_true(is_at(clone.handle, 0));
    assert_true(is_at(scene.blas.handle, 7));
    fixture->vk.FreeCommandBuffers(fixture->device, device.pool, 1, &build);
    fixture->vk.FreeCommandBuffers(fixture->device, device.pool, 1, &copy);
    fixture_destroy(fixture, &clone);
}

TEST_CLOSED(test_secondary, close_scene)
{
    open_scene(0);
    VkCommandBuffer secondary = device_begin(&device, SECONDARY);
    record_scene(secondary);
    device_end(&device, secondary);
    VkCommandBuffer primary = device_begin(&device, PRIMARY);
    fixture->vk.CmdExecuteCommands(primary, 1, &secondary);
    device_finish(&device, primary);
    fixture->vk.FreeCommandBuffers(fixture->device, device.pool, 1, &secondary);
    assert_true(is_at(scene.blas.handle, 0));
    assert_true(fixture_trace(fixture, scene.tlas.handle, 2.25f, 0.25f).isHit);
}

/* Each execution copies to the same place. Only what is asked for is told, and only once. */
TEST_CLOSED(test_executed_twice_at_once, close_scene)
{
    open_scene(0);
    struct fixture_structure clone = create_twin(&scene.host_triangles);
    VkCommandBuffer secondary = device_begin(&device, SECONDARY);
    record_triangles(secondary, 0, scene.blas.handle, VK_NULL_HANDLE);
    device_end(&device, secondary);
    VkCommandBuffer primary = device_begin(&device, PRIMARY);
    fixture->vk.CmdExecuteCommands(primary, 1, &secondary);
    record_clone(primary, scene.blas.handle, clone.handle);
    fixture->vk.CmdExecuteCommands(primary, 1, &secondary);
    device_end(&device, primary);
    for (int i = 0; i < 2; i++) {
        device_run(&device, primary);
        assert_true(is_at(scene.blas.handle, 0));
        device_expect_silence(&device);
    }
    assert_true(is_at(clone.handle, 0));
    const struct messages *messages = &fixture->instance_fixture.messages;
    assert_int_equal(messages->count, 1);
    assert_non_null(strstr(messages->items[0].text, "what the last one copied"));
    device_run(&device, primary);
    assert_true(is_at(clone.handle, 0));
    assert_int_equal(messages->count, 1);
    messages_clear(&fixture->instance_fixture.messages);
    fixture->vk.FreeCommandBuffers(fixture->device, device.pool, 1, &primary);
    fixture->vk.FreeCommandBuffers(fixture->device, device.pool, 1, &secondary);
    fixture_destroy(fixture, &clone);
}

TEST_CLOSED(test_indirect, close_scene)
{
    open_scene(0);
    enum { SKIPPED = 10, COUNT = 5 };
    struct device_buffer ranges = device_buffer_create(&device, 64);
    const VkAccelerationStructureBuildRangeInfoKHR range = {
        .primitiveCount = COUNT, .primitiveOffset = SKIPPED * TRIANGLE_SIZE};
    memcpy(ranges.bytes + 16, &range, sizeof(range));
    const VkDeviceAddress address = ranges.address + 16;
    const uint32_t stride = sizeof(range), maximum = TRIANGLES;
    const uint32_t *const maxima = &maximum;

    VkCommandBuffer commands = device_begin(&device, PRIMARY);
    device_upload(&device, commands, &scene.triangles);
    scene.triangles.info.dstAccelerationStructure = scene.blas.handle;
    fixture->vk.CmdBuildAccelerationStructuresIndirectKHR(commands, 1, &scene.triangles.info,
                                                          &address, &stride, &maxima);
    device_finish(&device, commands);
    const AssayHit hit = fixture_trace(fixture, scene.blas.handle, 0.25f, 0.25f);
    assert_true(hit.isHit);
    assert_int_equal(hit.primitive, 0);
    assert_float_equal(hit.t, SKIPPED + 1, 0); /* the ray begins at x = -1 */
    device_buffer_destroy(&device, &ranges);
}
