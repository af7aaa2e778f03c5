/* SPDX-License-Identifier: Apache-2.0 */
/* Guarded builds (setting guard): a build reads no reference to what is not a live, built
 * bottom-level structure, all others as they are, and the application's memory stays as it is. On
 * the null driver, which tells what builds have read, and on lavapipe, which crashes. */
#include "tests/snapshots/guard_scene.h"

#include <string.h>

/* ---- references that no instance may have */

static VkAccelerationStructureKHR make_in(const struct device_buffer *buffer, VkDeviceSize offset,
                                          VkAccelerationStructureTypeKHR type)
{
    return fixture_structure(&fixture, buffer, offset, STRUCTURE_SIZE, type);
}

static uint64_t wild(void)
{
    return 0x7f0123456700;
}

static uint64_t unaligned(void)
{
    return guard_scene_address(scene.blas) + 8;
}

static uint64_t destroyed(void)
{
    VkAccelerationStructureKHR structure = guard_scene_build_another(&guard_scene.spare);
    uint64_t address = guard_scene_address(structure);
    guard_scene_destroy(structure);
    return address;
}

static uint64_t without_buffer(void)
{
    struct device_buffer buffer = guard_scene_buffer();
    uint64_t address = guard_scene_address(guard_scene_build_another(&buffer));
    fixture_destroy_buffer(&fixture, &buffer);
    return address;
}

static uint64_t never_built(void)
{
    return guard_scene_address(
        make_in(&guard_scene.spare, 0, VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR));
}

static uint64_t top_level(void)
{
    return guard_scene_address(scene.tlas);
}

static uint64_t of_another_device(void)
{
    return guard_scene_of_another_device();
}

static const struct {
    uint64_t (*find)(void);
    const char *found; /* in the message */
} mistakes[] = {
    {wild, "is not the address of an acceleration structure"},
    {unaligned, "is not the address of an acceleration structure"},
    {destroyed, "is not the address of an acceleration structure"},
    {without_buffer, "is not bound to memory"},
    {never_built, "not a live, built bottom-level acceleration structure"},
    {top_level, "which is not a bottom-level acceleration structure"},
    {of_another_device, "is not the address of an acceleration structure"},
};

static void open_scene(void)
{
    guard_scene_open("references");
}

static void play_mistakes(void (*build)(VkCommandBuffer commands, uint32_t count))
{
    for (size_t i = 0; i < sizeof(mistakes) / sizeof(mistakes[0]); i++) {
        open_scene();
        uint64_t bad = mistakes[i].find(), valid = guard_scene_address(scene.blas);
        guard_scene_write((uint64_t[]){valid, bad, 0, valid}, 4);
        unsigned char before[4 * INSTANCE_SIZE];
        VkCommandBuffer commands = fixture_begin(&fixture, 0);
        build(commands, 4);
        memcpy(before, guard_scene.instances.bytes, sizeof(before));
        fixture_finish(&fixture, commands);
        guard_scene_expect_read((uint64_t[]){valid, 0, 0, valid}, 4);
        assert_memory_equal(before, guard_scene.instances.bytes, sizeof(before));
        guard_scene_expect(mistakes[i].found, "replaced 1 reference");
        guard_scene_close();
    }
}

TEST(test_replaces)
{
    play_mistakes(guard_scene_build);
}

TEST(test_replaces_behind_pointers)
{
    play_mistakes(guard_scene_build_pointers);
}

TEST_IF(test_replaces_in_indirect_builds, platform.is_null)
{
    play_mistakes(guard_scene_build_indirect);
}

/* What the tests above would not see if the null driver read something else. */
TEST_IF(test_off, platform.is_null)
{
    guard_scene_open("off");
    guard_scene_write((uint64_t[]){wild()}, 1);
    VkCommandBuffer commands = fixture_begin(&fixture, 0);
    guard_scene_build(commands, 1);
    fixture_finish(&fixture, commands);
    guard_scene_expect_read((uint64_t[]){wild()}, 1);
    guard_scene_expect(mistakes[0].found, "12281");
    guard_scene_close();
}

/* ---- builds in execution order */

#define GUARD_TEST(name) TEST_BETWEEN_IF(name, open_scene, guard_scene_close, true)
#define NULL_TEST(name) TEST_BETWEEN_IF(name, open_scene, guard_scene_close, platform.is_null)

/* A build of `structure`, which is in the spare buffer. */
static void build_spare(VkCommandBuffer commands, VkAccelerationStructureKHR structure)
{
    guard_scene_build_boxes(commands, structure);
}

static void finish(VkCommandBuffer commands, uint64_t reads)
{
    fixture_finish(&fixture, commands);
    guard_scene_expect_read(&reads, 1);
}

GUARD_TEST(test_built_before_in_the_command_buffer)
{
    VkAccelerationStructureKHR structure = guard_scene_make(&guard_scene.spare);
    uint64_t reference = guard_scene_address(structure);
    guard_scene_write(&reference, 1);
    VkCommandBuffer commands = fixture_begin(&fixture, 0);
    build_spare(commands, structure);
    guard_scene_build(commands, 1);
    finish(commands, reference);
    fixture_expect_silence(&fixture);
}

GUARD_TEST(test_built_later_in_the_command_buffer)
{
    VkAccelerationStructureKHR structure = guard_scene_make(&guard_scene.spare);
    uint64_t reference = guard_scene_address(structure);
    guard_scene_write(&reference, 1);
    VkCommandBuffer commands = fixture_begin(&fixture, 0);
    guard_scene_build(commands, 1);
    fixture_barrier(&fixture, commands);
    build_spare(commands, structure);
    finish(commands, 0);
    guard_scene_expect("replaced 1 reference", "instance 0");
    commands = fixture_begin(&fixture, 0);
    guard_scene_build(commands, 1);
    finish(commands, reference);
    fixture_expect_silence(&fixture);
}

GUARD_TEST(test_built_by_a_copy_in_a_secondary)
{
    VkAccelerationStructureKHR structure = guard_scene_make(&guard_scene.spare);
    uint64_t reference = guard_scene_address(structure);
    guard_scene_write(&reference, 1);
    VkCommandBuffer first = fixture_begin_secondary(&fixture, 0),
                    second = fixture_begin_secondary(&fixture, 0);
    const VkCopyAccelerationStructureInfoKHR copy =
        MAKE(VkCopyAccelerationStructureInfoKHR, .src = scene.blas, .dst = structure,
             .mode = VK_COPY_ACCELERATION_STRUCTURE_MODE_CLONE_KHR);
    fixture.vk.CmdCopyAccelerationStructureKHR(first, &copy);
    fixture_barrier(&fixture, first);
    guard_scene_build(second, 1);
    fixture_barrier(&fixture, second);
    GET(fixture.vk.EndCommandBuffer(first));
    GET(fixture.vk.EndCommandBuffer(second));
    VkCommandBuffer commands = fixture_begin(&fixture, 0);
    fixture.vk.CmdExecuteCommands(commands, 1, &second);
    fixture.vk.CmdExecuteCommands(commands, 1, &first);
    finish(commands, 0);
    guard_scene_expect("replaced 1 reference", "instance 0");
    commands = fixture_begin(&fixture, 0);
    fixture.vk.CmdExecuteCommands(commands, 1, &first);
    fixture.vk.CmdExecuteCommands(commands, 1, &second);
    finish(commands, reference);
    fixture_expect_silence(&fixture);
}

/* The table of each submission, with one command buffer. */
static void resubmit(VkCommandBufferUsageFlags flags)
{
    uint64_t reference = guard_scene_address(scene.blas);
    VkCommandBuffer commands = fixture_begin(&fixture, flags);
    guard_scene_build(commands, 1);
    GET(fixture.vk.EndCommandBuffer(commands));
    guard_scene_write(&reference, 1);
    guard_scene_run(commands, reference);
    fixture_expect_silence(&fixture);
    VkAccelerationStructureKHR later = guard_scene_build_another(&guard_scene.spare);
    reference = guard_scene_address(later);
    guard_scene_write(&reference, 1);
    guard_scene_run(commands, reference);
    fixture_expect_silence(&fixture);
    guard_scene_destroy(later);
    guard_scene_run(commands, 0);
    guard_scene_expect(mistakes[0].found, "replaced 1 reference");
}

GUARD_TEST(test_resubmitted)
{
    resubmit(0);
}

GUARD_TEST(test_resubmitted_simultaneous)
{
    resubmit(VK_COMMAND_BUFFER_USAGE_SIMULTANEOUS_USE_BIT);
}

/* Two submissions in flight of one command buffer, the second with a structure that the first has
 * not known. */
GUARD_TEST(test_in_flight)
{
    uint64_t reference = guard_scene_address(scene.blas);
    VkAccelerationStructureKHR later = guard_scene_make(&guard_scene.spare);
    guard_scene_write(&reference, 1);
    VkCommandBuffer commands =
        fixture_begin(&fixture, VK_COMMAND_BUFFER_USAGE_SIMULTANEOUS_USE_BIT);
    fixture_barrier(&fixture, commands);
    guard_scene_build(commands, 1);
    fixture_barrier(&fixture, commands);
    GET(fixture.vk.EndCommandBuffer(commands));
    VkCommandBuffer between = fixture_begin(&fixture, 0);
    build_spare(between, later);
    uint64_t next = guard_scene_address(later);
    guard_scene_change_reference(between, next);
    GET(fixture.vk.EndCommandBuffer(between));
    GET(fixture_submit(&fixture, commands, VK_NULL_HANDLE));
    GET(fixture_submit(&fixture, between, VK_NULL_HANDLE));
    GET(fixture_submit(&fixture, commands, VK_NULL_HANDLE));
    GET(fixture.vk.DeviceWaitIdle(fixture.device));
    guard_scene_expect_read((uint64_t[]){reference, next}, 2);
    messages_clear(&fixture.instance.messages); /* of snapshots that were overwritten */
}

/* The memory of snapshots was given back after the first submission, so the second reads nothing,
 * but nothing wild either. */
GUARD_TEST(test_submitted_once_more)
{
    uint64_t reference = guard_scene_address(scene.blas);
    guard_scene_write(&reference, 1);
    VkCommandBuffer commands = fixture_begin(&fixture, VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT);
    guard_scene_build(commands, 1);
    GET(fixture.vk.EndCommandBuffer(commands));
    guard_scene_run(commands, reference);
    guard_scene_run(commands, 0);
    messages_clear(&fixture.instance.messages); /* of the resubmission */
}

/* Many structures, so that the table grows, while they come and go. */
GUARD_TEST(test_table_grows)
{
    enum { COUNT = 1500, SMALL = 256 };
    static VkAccelerationStructureKHR structures[COUNT];
    struct device_buffer buffer = fixture_buffer(
        &fixture, COUNT * SMALL, VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_STORAGE_BIT_KHR);
    uint64_t reference = guard_scene_address(scene.blas);
    guard_scene_write(&reference, 1);
    for (int round = 0; round < 3; round++) {
        for (uint32_t i = 0; i < COUNT; i++) {
            const VkAccelerationStructureCreateInfoKHR info = MAKE(
                VkAccelerationStructureCreateInfoKHR, .buffer = buffer.handle, .offset = i * SMALL,
                .size = SMALL, .type = VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR);
            GET(fixture.vk.CreateAccelerationStructureKHR(fixture.device, &info, NULL,
                                                          &structures[i]));
        }
        VkCommandBuffer commands = fixture_begin(&fixture, 0);
        guard_scene_build(commands, 1);
        finish(commands, reference);
        for (uint32_t i = 0; i < COUNT; i++)
            fixture.vk.DestroyAccelerationStructureKHR(fixture.device, structures[i], NULL);
    }
    fixture_expect_silence(&fixture);
}

/* ---- what builds read beside their references */

GUARD_TEST(test_offset)
{
    uint64_t reference = guard_scene_address(scene.blas);
    guard_scene_write((uint64_t[]){wild(), reference, wild()}, 3);
    VkCommandBuffer commands = fixture_begin(&fixture, 0);
    guard_scene_build_at(commands, INSTANCE_SIZE, 1);
    finish(commands, reference);
    fixture_expect_silence(&fixture);
}

/* A pointer to no memory. */
GUARD_TEST(test_wild_pointer)
{
    uint64_t reference = guard_scene_address(scene.blas), nowhere = wild();
    guard_scene_write((uint64_t[]){reference, reference}, 2);
    guard_scene_point(1, nowhere);
    VkCommandBuffer commands = fixture_begin(&fixture, 0);
    guard_scene_build_given_pointers(commands, 2);
    fixture_finish(&fixture, commands);
    guard_scene_expect_read((uint64_t[]){reference, 0}, 2);
    guard_scene_expect("1 instance in memory that cannot be read", "guard");
}

/* ---- the driver's result */

enum { SERIALIZED_SIZE = 2 * STRUCTURE_SIZE }; /* lavapipe writes all bytes of the structure */

/* Builds, and copies the structure's serialized form to a buffer. */
static struct device_buffer serialize(VkCommandBuffer commands)
{
    struct device_buffer to = fixture_buffer(&fixture, SERIALIZED_SIZE, 0);
    const VkCopyAccelerationStructureToMemoryInfoKHR copy = MAKE(
        VkCopyAccelerationStructureToMemoryInfoKHR, .src = scene.tlas,
        .dst.deviceAddress = to.address, .mode = VK_COPY_ACCELERATION_STRUCTURE_MODE_SERIALIZE_KHR);
    fixture_barrier(&fixture, commands);
    fixture.vk.CmdCopyAccelerationStructureToMemoryKHR(commands, &copy);
    fixture_finish(&fixture, commands);
    messages_clear(&fixture.instance.messages); /* of the build that is not guarded */
    return to;
}

static struct device_buffer serialize_guarded(void)
{
    VkCommandBuffer commands = fixture_begin(&fixture, 0);
    guard_scene_build(commands, 4);
    return serialize(commands);
}

/* A query that counts compute work keeps the layer from dispatching. */
static struct device_buffer serialize_unguarded(void)
{
    const VkQueryPoolCreateInfo info =
        MAKE(VkQueryPoolCreateInfo, .queryType = VK_QUERY_TYPE_PIPELINE_STATISTICS, .queryCount = 1,
             .pipelineStatistics = VK_QUERY_PIPELINE_STATISTIC_COMPUTE_SHADER_INVOCATIONS_BIT);
    VkQueryPool queries;
    GET(fixture.vk.CreateQueryPool(fixture.device, &info, NULL, &queries));
    VkCommandBuffer commands = fixture_begin(&fixture, 0);
    fixture.vk.CmdResetQueryPool(commands, queries, 0, 1);
    fixture.vk.CmdBeginQuery(commands, queries, 0, 0);
    guard_scene_build(commands, 4);
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

TEST_BETWEEN_IF(test_same_structure, open_scene, guard_scene_close, serializes_alike())
{
    uint64_t reference = guard_scene_address(scene.blas);
    guard_scene_write((uint64_t[]){reference, reference, 0, reference}, 4);
    struct device_buffer guarded = serialize_guarded(), unguarded = serialize_unguarded();
    assert_memory_equal(guarded.bytes, unguarded.bytes, SERIALIZED_SIZE);
    guard_scene_write((uint64_t[]){reference, wild(), 0, reference}, 4);
    struct device_buffer other = serialize_guarded();
    assert_memory_not_equal(guarded.bytes, other.bytes, SERIALIZED_SIZE);
}

/* One warning for a device. */
NULL_TEST(test_unguarded)
{
    uint64_t reference = guard_scene_address(scene.blas);
    guard_scene_write(&reference, 1);
    VkCommandBuffer commands = fixture_begin(&fixture, 0);
    fixture.vk.CmdPushConstants(commands, VK_NULL_HANDLE, VK_SHADER_STAGE_COMPUTE_BIT, 2, 2, "x");
    for (int i = 0; i < 2; i++) {
        guard_scene_build(commands, 1);
        fixture_barrier(&fixture, commands);
    }
    assert_int_equal(fixture.instance.messages.count, 1);
    guard_scene_expect("some builds read the application's instances unguarded", "disturbing");
    GET(fixture.vk.EndCommandBuffer(commands));
    fixture.vk.FreeCommandBuffers(fixture.device, fixture.pool, 1, &commands);
}

/* Builds that cannot be guarded read what the application wrote. */
static void build_without(const char *command)
{
    uint64_t reference = wild();
    guard_scene_write(&reference, 1);
    VkCommandBuffer commands = fixture_begin(&fixture, 0);
    platform.null_driver.fail_next(command, VK_ERROR_OUT_OF_DEVICE_MEMORY);
    guard_scene_build(commands, 1);
    platform.null_driver.fail_next(command, VK_SUCCESS);
    fixture_finish(&fixture, commands);
    guard_scene_expect_read(&reference, 1);
    guard_scene_expect("some builds read the application's instances unguarded", "no memory");
}

NULL_TEST(test_without_memory)
{
    build_without("vkAllocateMemory");
    VkCommandBuffer commands = fixture_begin(&fixture, 0);
    guard_scene_build(commands, 1);
    finish(commands, 0);
    guard_scene_expect(mistakes[0].found, "replaced 1 reference");
}

NULL_TEST(test_without_pipeline)
{
    build_without("vkCreateComputePipelines");
}

/* A submission waits for a signal that was not submitted, so builds may come before it. The null
 * driver executes it at once. */
NULL_TEST(test_order_unknown)
{
    uint64_t references[] = {guard_scene_address(guard_scene_make(&guard_scene.spare)), wild()};
    VkSemaphore timeline = timeline_create(&fixture.vk, fixture.device);
    const VkSemaphoreSignalInfo signal =
        MAKE(VkSemaphoreSignalInfo, .semaphore = timeline, .value = 1);
    guard_scene_write(references, 2);
    VkCommandBuffer commands = fixture_begin(&fixture, 0);
    guard_scene_build(commands, 2);
    GET(fixture.vk.EndCommandBuffer(commands));
    fixture_submit_waiting(&fixture, commands, timeline, VK_NULL_HANDLE);
    guard_scene_expect_read((uint64_t[]){references[0], 0}, 2);
    GET(fixture.vk.SignalSemaphore(fixture.device, &signal));
    GET(fixture.vk.DeviceWaitIdle(fixture.device));
    guard_scene_expect(mistakes[0].found, "replaced 1 reference");
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
        const uint64_t reference = i % 2 ? wild() : valid;
        unsigned char *at = guard_scene.instances.bytes + (size_t)i * MOTION_STRIDE;
        memset(at, 0, MOTION_STRIDE);
        if (has_header)
            memcpy(at, &type, sizeof(type));
        memcpy(at + 8 * has_header + reference_offsets[type], &reference, sizeof(reference));
        guard_scene_point(i, guard_scene.instances.address + i * MOTION_STRIDE + type);
    }
}

static void build_moving(bool are_pointers)
{
    const uint64_t valid = guard_scene_address(scene.blas);
    write_moving(valid, !are_pointers);
    VkCommandBuffer commands = fixture_begin(&fixture, 0);
    guard_scene_build_moving(commands, are_pointers, MOTION_COUNT);
    fixture_finish(&fixture, commands);
    guard_scene_expect_read((uint64_t[]){valid, 0, valid, 0, valid, 0}, MOTION_COUNT);
    guard_scene_expect(mistakes[0].found, "replaced 3 references");
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

static uint64_t nv_handle(VkAccelerationStructureNV structure)
{
    uint64_t handle;
    GET(fixture.vk.GetAccelerationStructureHandleNV(fixture.device, structure, sizeof(handle),
                                                    &handle));
    return handle;
}

static VkAccelerationStructureNV nv_make(const VkAccelerationStructureInfoNV *info,
                                         VkDeviceMemory *memory)
{
    const VkAccelerationStructureCreateInfoNV create_info =
        MAKE(VkAccelerationStructureCreateInfoNV, .info = *info);
    VkAccelerationStructureNV structure;
    GET(fixture.vk.CreateAccelerationStructureNV(fixture.device, &create_info, NULL, &structure));
    *memory = memory_create(&fixture.vk, fixture.device, fixture.memory_type, STRUCTURE_SIZE);
    const VkBindAccelerationStructureMemoryInfoNV bind =
        MAKE(VkBindAccelerationStructureMemoryInfoNV, .accelerationStructure = structure,
             .memory = *memory);
    GET(fixture.vk.BindAccelerationStructureMemoryNV(fixture.device, 1, &bind));
    return structure;
}

NULL_TEST(test_nv)
{
    enum { BOTTOM, TOP, DESTROYED, COUNT };
    const VkAccelerationStructureInfoNV bottom = MAKE(
                                            VkAccelerationStructureInfoNV,
                                            .type = VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_NV),
                                        top = MAKE(VkAccelerationStructureInfoNV,
                                                   .type =
                                                       VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_NV,
                                                   .instanceCount = 4);
    VkDeviceMemory memories[COUNT];
    VkAccelerationStructureNV structures[COUNT];
    uint64_t handles[COUNT];
    for (int i = 0; i < COUNT; i++) {
        structures[i] = nv_make(i == TOP ? &top : &bottom, &memories[i]);
        handles[i] = nv_handle(structures[i]);
    }
    fixture.vk.DestroyAccelerationStructureNV(fixture.device, structures[DESTROYED], NULL);
    guard_scene_write((uint64_t[]){handles[BOTTOM], wild(), handles[TOP], handles[DESTROYED]}, 4);
    VkCommandBuffer commands = fixture_begin(&fixture, 0);
    fixture.vk.CmdBuildAccelerationStructureNV(commands, &top, guard_scene.instances.handle, 0,
                                               VK_FALSE, structures[TOP], VK_NULL_HANDLE,
                                               scene.scratch.handle, 0);
    fixture_finish(&fixture, commands);
    guard_scene_expect_read((uint64_t[]){handles[BOTTOM], 0, 0, 0}, 4);
    guard_scene_expect("12264", "replaced 3 references");
    for (int i = 0; i < COUNT; i++) {
        if (i != DESTROYED)
            fixture.vk.DestroyAccelerationStructureNV(fixture.device, structures[i], NULL);
        fixture.vk.FreeMemory(fixture.device, memories[i], NULL);
    }
}

/* ---- memory */

/* Each command buffer has a chunk of 256 KiB for copies, and one for guarded copies. Of each kind
 * 16 MiB stay. */
NULL_TEST(test_idle_frames_give_copies_back)
{
    enum { BUFFERS = 100, KEPT = 64 };
    VkCommandBuffer commands[BUFFERS];
    uint64_t reference = guard_scene_address(scene.blas);
    guard_scene_write(&reference, 1);
    for (int i = 0; i < BUFFERS; i++) {
        commands[i] = fixture_begin(&fixture, 0);
        guard_scene_build(commands[i], 1);
        scene_submit(commands[i]);
    }
    GET(fixture.vk.DeviceWaitIdle(fixture.device));
    fixture.vk.FreeCommandBuffers(fixture.device, fixture.pool, BUFFERS, commands);
    platform.null_driver.reset();
    for (int i = 0; i < 20; i++)
        fixture_finish(&fixture, fixture_begin(&fixture, 0));
    assert_int_equal(platform.null_driver.calls("vkFreeMemory"), 2 * (BUFFERS - KEPT));
}
