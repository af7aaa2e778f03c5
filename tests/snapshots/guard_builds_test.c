/* SPDX-License-Identifier: Apache-2.0 */
/* Guarded builds: what they read beside references, what the driver makes of them, instances of
 * other extensions, and builds that are not guarded. */
#include "tests/fixture/copies.h"
#include "tests/snapshots/guard_scene.h"

#include <string.h>

/* ---- what builds read beside their references */

GUARD_TEST(test_offset)
{
    uint64_t reference = guard_address(scene.blas);
    guard_write((uint64_t[]){guard_wild(), reference, guard_wild()}, 3);
    VkCommandBuffer commands = fixture_begin(&fixture, 0);
    guard_build_at(commands, INSTANCE_SIZE, 1);
    guard_finish(commands, reference);
    fixture_expect_silence(&fixture);
}

/* A pointer to no memory. */
GUARD_TEST(test_wild_pointer)
{
    uint64_t reference = guard_address(scene.blas), nowhere = guard_wild();
    guard_write((uint64_t[]){reference, reference}, 2);
    guard_point(1, nowhere);
    VkCommandBuffer commands = fixture_begin(&fixture, 0);
    guard_build_pointers(commands, 2);
    fixture_finish(&fixture, commands);
    guard_expect_read((uint64_t[]){reference, 0}, 2);
    guard_expect("1 instance in memory that cannot be read", "guard");
}

/* ---- the driver's result */

enum { SERIALIZED_SIZE = 2 * STRUCTURE_SIZE }; /* lavapipe writes all bytes of the structure */

/* Builds, and copies the structure's serialized form to a buffer. */
static struct device_buffer serialize(VkCommandBuffer commands)
{
    struct device_buffer to = fixture_buffer(&fixture, SERIALIZED_SIZE, 0);
    const VkCopyAccelerationStructureToMemoryInfoKHR copy = serialize_info(scene.tlas, to.address);
    fixture_barrier(&fixture, commands);
    fixture.vk.CmdCopyAccelerationStructureToMemoryKHR(commands, &copy);
    fixture_finish(&fixture, commands);
    messages_clear(&fixture.instance.messages); /* of the build that is not guarded */
    return to;
}

static struct device_buffer serialize_guarded(void)
{
    VkCommandBuffer commands = fixture_begin(&fixture, 0);
    guard_build(commands, 4);
    return serialize(commands);
}

/* A query that counts compute work keeps the layer from dispatching. */
static struct device_buffer serialize_unguarded(void)
{
    const STRUCT(VkQueryPoolCreateInfo, info, .queryType = VK_QUERY_TYPE_PIPELINE_STATISTICS,
                 .queryCount = 1,
                 .pipelineStatistics = VK_QUERY_PIPELINE_STATISTIC_COMPUTE_SHADER_INVOCATIONS_BIT);
    VkQueryPool queries;
    GET(fixture.vk.CreateQueryPool(fixture.device, &info, NULL, &queries));
    VkCommandBuffer commands = fixture_begin(&fixture, 0);
    fixture.vk.CmdResetQueryPool(commands, queries, 0, 1);
    fixture.vk.CmdBeginQuery(commands, queries, 0, 0);
    guard_build(commands, 4);
    fixture.vk.CmdEndQuery(commands, queries, 0);
    struct device_buffer serialized = serialize(commands);
    fixture.vk.DestroyQueryPool(fixture.device, queries, NULL);
    return serialized;
}

/* What NVIDIA's driver serializes has bytes that differ from build to build. */
static bool serializes_alike(void)
{
    return !platform.is_null && strcmp(platform.name, "lavapipe") == 0;
}

TEST_BETWEEN_IF(test_same_structure, guard_open_references, guard_close, serializes_alike())
{
    uint64_t reference = guard_address(scene.blas);
    guard_write((uint64_t[]){reference, reference, 0, reference}, 4);
    struct device_buffer guarded = serialize_guarded(), unguarded = serialize_unguarded();
    assert_memory_equal(guarded.bytes, unguarded.bytes, SERIALIZED_SIZE);
    guard_write((uint64_t[]){reference, guard_wild(), 0, reference}, 4);
    struct device_buffer other = serialize_guarded();
    assert_memory_not_equal(guarded.bytes, other.bytes, SERIALIZED_SIZE);
}

/* One warning for a device. */
NULL_TEST(test_unguarded)
{
    guard_refer_to(scene.blas);
    VkCommandBuffer commands = fixture_begin(&fixture, 0);
    fixture.vk.CmdPushConstants(commands, VK_NULL_HANDLE, VK_SHADER_STAGE_COMPUTE_BIT, 2, 2, "x");
    for (int i = 0; i < 2; i++) {
        guard_build(commands, 1);
        fixture_barrier(&fixture, commands);
    }
    assert_int_equal(fixture.instance.messages.count, 1);
    guard_expect("some builds read the application's instances unguarded", "disturbing");
    GET(fixture.vk.EndCommandBuffer(commands));
    fixture.vk.FreeCommandBuffers(fixture.device, fixture.pool, 1, &commands);
}

/* Behind the dispatch the constants are pushed again, up to the last ones. */
NULL_TEST(test_last_constants)
{
    const uint64_t reference = guard_refer_to(scene.blas);
    VkCommandBuffer commands = fixture_begin(&fixture, 0);
    fixture.vk.CmdPushConstants(commands, VK_NULL_HANDLE, VK_SHADER_STAGE_COMPUTE_BIT, 252, 4,
                                "end");
    guard_build(commands, 1);
    fixture_finish(&fixture, commands);
    guard_expect_read(&reference, 1);
}

/* Builds that cannot be guarded read what the application wrote. */
static void build_without(const char *command)
{
    uint64_t reference = guard_wild();
    guard_write(&reference, 1);
    VkCommandBuffer commands = fixture_begin(&fixture, 0);
    platform.null_driver.fail_next(command, VK_ERROR_OUT_OF_DEVICE_MEMORY);
    guard_build(commands, 1);
    platform.null_driver.fail_next(command, VK_SUCCESS);
    fixture_finish(&fixture, commands);
    guard_expect_read(&reference, 1);
    guard_expect("some builds read the application's instances unguarded", "no memory");
}

NULL_TEST(test_without_memory)
{
    build_without("vkAllocateMemory");
    guard_build_alone(1);
    guard_expect_read(&(uint64_t){0}, 1);
    guard_expect(GUARD_NO_STRUCTURE, "replaced 1 reference");
}

NULL_TEST(test_without_pipeline)
{
    build_without("vkCreateComputePipelines");
}

/* A submission waits for a signal that was not submitted, so builds may come before it. The null
 * driver executes it at once. */
NULL_TEST(test_order_unknown)
{
    uint64_t references[] = {guard_address(guard_make(&guard_scene.spare)), guard_wild()};
    VkSemaphore timeline = timeline_create(&fixture.vk, fixture.device);
    const STRUCT(VkSemaphoreSignalInfo, signal, .semaphore = timeline, .value = 1);
    guard_write(references, 2);
    VkCommandBuffer commands = fixture_begin(&fixture, 0);
    guard_build(commands, 2);
    GET(fixture.vk.EndCommandBuffer(commands));
    fixture_submit_waiting(&fixture, commands, timeline, VK_NULL_HANDLE);
    guard_expect_read((uint64_t[]){references[0], 0}, 2);
    GET(fixture.vk.SignalSemaphore(fixture.device, &signal));
    GET(fixture.vk.DeviceWaitIdle(fixture.device));
    guard_expect(GUARD_NO_STRUCTURE, "replaced 1 reference");
    fixture.vk.DestroySemaphore(fixture.device, timeline, NULL);
}

/* ---- VK_NV_ray_tracing_motion_blur */

enum { MOTION_STRIDE = 160, MOTION_COUNT = 6 };

static const uint32_t reference_offsets[] = {56, 104, 136}; /* by type */

/* Instances of each type, valid and invalid, with or without the header that has the type. */
static void write_moving(uint64_t valid, bool has_header)
{
    for (uint32_t i = 0; i < MOTION_COUNT; i++) {
        const uint32_t type = i / 2;
        const uint64_t reference = i % 2 ? guard_wild() : valid;
        unsigned char *at = guard_scene.instances.bytes + (size_t)i * MOTION_STRIDE;
        memset(at, 0, MOTION_STRIDE);
        if (has_header)
            memcpy(at, &type, sizeof(type));
        memcpy(at + 8 * has_header + reference_offsets[type], &reference, sizeof(reference));
        guard_point(i, guard_scene.instances.address + i * MOTION_STRIDE + type);
    }
}

static void build_moving(bool are_pointers)
{
    const uint64_t valid = guard_address(scene.blas);
    write_moving(valid, !are_pointers);
    VkCommandBuffer commands = fixture_begin(&fixture, 0);
    guard_build_moving(commands, are_pointers, MOTION_COUNT);
    fixture_finish(&fixture, commands);
    guard_expect_read((uint64_t[]){valid, 0, valid, 0, valid, 0}, MOTION_COUNT);
    guard_expect(GUARD_NO_STRUCTURE, "replaced 3 references");
}

NULL_TEST(test_motion)
{
    build_moving(false);
}

NULL_TEST(test_motion_behind_pointers)
{
    build_moving(true);
}

/* ---- VK_NV_ray_tracing */

static VkAccelerationStructureNV nv_make(const VkAccelerationStructureInfoNV *info,
                                         VkDeviceMemory *memory)
{
    const STRUCT(VkAccelerationStructureCreateInfoNV, create_info, .info = *info);
    VkAccelerationStructureNV structure;
    GET(fixture.vk.CreateAccelerationStructureNV(fixture.device, &create_info, NULL, &structure));
    *memory = memory_create(&fixture.vk, fixture.device, fixture.memory_type, STRUCTURE_SIZE);
    const STRUCT(VkBindAccelerationStructureMemoryInfoNV, bind, .accelerationStructure = structure,
                 .memory = *memory);
    GET(fixture.vk.BindAccelerationStructureMemoryNV(fixture.device, 1, &bind));
    return structure;
}

NULL_TEST(test_nv)
{
    enum { BOTTOM, TOP, DESTROYED, FREED, COUNT };
    const STRUCT(VkAccelerationStructureInfoNV, bottom,
                 .type = VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_NV);
    const STRUCT(VkAccelerationStructureInfoNV, top,
                 .type = VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_NV, .instanceCount = 5);
    VkDeviceMemory memories[COUNT];
    VkAccelerationStructureNV structures[COUNT];
    uint64_t handles[COUNT];
    for (int i = 0; i < COUNT; i++) {
        structures[i] = nv_make(i == TOP ? &top : &bottom, &memories[i]);
        GET(fixture.vk.GetAccelerationStructureHandleNV(fixture.device, structures[i],
                                                        sizeof(handles[i]), &handles[i]));
    }
    fixture.vk.DestroyAccelerationStructureNV(fixture.device, structures[DESTROYED], NULL);
    fixture.vk.FreeMemory(fixture.device, memories[FREED], NULL);
    memories[FREED] = VK_NULL_HANDLE;
    guard_write((uint64_t[]){handles[BOTTOM], guard_wild(), handles[TOP], handles[DESTROYED],
                             handles[FREED]},
                5);
    VkCommandBuffer commands = fixture_begin(&fixture, 0);
    fixture.vk.CmdBuildAccelerationStructureNV(commands, &top, guard_scene.instances.handle, 0,
                                               VK_FALSE, structures[TOP], VK_NULL_HANDLE,
                                               scene.scratch.handle, 0);
    fixture_finish(&fixture, commands);
    guard_expect_read((uint64_t[]){handles[BOTTOM], 0, 0, 0, 0}, 5);
    guard_expect("12264", "replaced 4 references");
    for (int i = 0; i < COUNT; i++) {
        if (i != DESTROYED)
            fixture.vk.DestroyAccelerationStructureNV(fixture.device, structures[i], NULL);
        fixture.vk.FreeMemory(fixture.device, memories[i], NULL);
    }
}

/* ---- memory */

/* The copies take some 30 MiB, and so do the guarded copies. Of each kind 16 MiB stay. */
NULL_TEST(test_idle_frames_give_copies_back)
{
    enum { BUFFERS = 100, BUILDS = 300, KEPT = 64 };
    VkCommandBuffer commands[BUFFERS];
    guard_refer_to(scene.blas);
    platform.null_driver.reset();
    for (int i = 0; i < BUFFERS; i++) {
        commands[i] = fixture_begin(&fixture, 0);
        for (int j = 0; j < BUILDS; j++)
            guard_build(commands[i], GUARD_INSTANCES);
        scene_submit(commands[i]);
    }
    GET(fixture.vk.DeviceWaitIdle(fixture.device));
    fixture.vk.FreeCommandBuffers(fixture.device, fixture.pool, BUFFERS, commands);
    const uint32_t allocated = platform.null_driver.calls("vkAllocateMemory");
    platform.null_driver.reset();
    for (int i = 0; i < 20; i++)
        fixture_finish(&fixture, fixture_begin(&fixture, 0));
    const uint32_t freed = platform.null_driver.calls("vkFreeMemory");
    assert_true(freed > 0);
    assert_true(freed <= allocated - 2 * KEPT);
}
