/* SPDX-License-Identifier: Apache-2.0 */
/* Guarded builds (setting guard): a build reads no reference to what is not a live, built
 * bottom-level structure, all others as they are, and the application's memory stays as it is. On
 * the null driver, which tells what builds have read, and on lavapipe, which crashes. */
#include "tests/fixture/copies.h"
#include "tests/snapshots/guard_scene.h"

#include <string.h>

/* ---- references that no instance may have */

static uint64_t unaligned(void)
{
    return guard_address(scene.blas) + 8;
}

static uint64_t destroyed(void)
{
    VkAccelerationStructureKHR structure = guard_build_another(&guard_scene.spare);
    uint64_t address = guard_address(structure);
    guard_destroy(structure);
    return address;
}

static uint64_t without_buffer(void)
{
    struct device_buffer buffer = guard_buffer();
    uint64_t address = guard_address(guard_build_another(&buffer));
    fixture_destroy_buffer(&fixture, &buffer);
    return address;
}

static uint64_t never_built(void)
{
    return guard_address(guard_make(&guard_scene.spare));
}

static uint64_t top_level(void)
{
    return guard_address(scene.tlas);
}

static const struct {
    uint64_t (*find)(void);
    const char *found; /* in the message */
} mistakes[] = {
    {guard_wild, GUARD_NO_STRUCTURE},
    {unaligned, GUARD_NO_STRUCTURE},
    {destroyed, GUARD_NO_STRUCTURE},
    {without_buffer, "is not bound to memory"},
    {never_built, "That structure was "},
    {top_level, "which is not a bottom-level acceleration structure"},
    {guard_of_another_device, GUARD_NO_STRUCTURE},
};

static void play_mistakes(void (*build)(VkCommandBuffer commands, uint32_t count))
{
    for (size_t i = 0; i < sizeof(mistakes) / sizeof(mistakes[0]); i++) {
        guard_open("references");
        uint64_t bad = mistakes[i].find(), valid = guard_address(scene.blas);
        guard_write((uint64_t[]){valid, bad, 0, valid}, 4);
        unsigned char before[4 * INSTANCE_SIZE];
        VkCommandBuffer commands = fixture_begin(&fixture, 0);
        build(commands, 4);
        memcpy(before, guard_scene.instances.bytes, sizeof(before));
        fixture_finish(&fixture, commands);
        guard_expect_read((uint64_t[]){valid, 0, 0, valid}, 4);
        assert_memory_equal(before, guard_scene.instances.bytes, sizeof(before));
        guard_expect(mistakes[i].found, "replaced 1 reference");
        guard_close();
    }
}

TEST(test_replaces)
{
    play_mistakes(guard_build);
}

TEST(test_replaces_behind_pointers)
{
    play_mistakes(guard_build_pointers);
}

TEST_IF(test_replaces_in_indirect_builds, platform.is_null)
{
    play_mistakes(guard_build_indirect);
}

/* What the tests above would not see if the null driver read something else. */
TEST_IF(test_off, platform.is_null)
{
    guard_open("off");
    guard_write((uint64_t[]){guard_wild()}, 1);
    guard_build_alone(1);
    guard_expect_read((uint64_t[]){guard_wild()}, 1);
    guard_expect(GUARD_NO_STRUCTURE, "12281");
    guard_close();
}

/* ---- builds in execution order */

static void build_and_refer_to(VkAccelerationStructureTypeKHR type)
{
    VkAccelerationStructureKHR structure =
        fixture_structure(&fixture, &guard_scene.spare, 0, STRUCTURE_SIZE, type);
    const uint64_t reference = guard_refer_to(structure);
    VkCommandBuffer commands = fixture_begin(&fixture, 0);
    guard_build_boxes(commands, structure);
    guard_build(commands, 1);
    guard_finish(commands, reference);
    fixture_expect_silence(&fixture);
}

GUARD_TEST(test_built_before_in_the_command_buffer)
{
    build_and_refer_to(VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR);
}

GUARD_TEST(test_generic_structure)
{
    build_and_refer_to(VK_ACCELERATION_STRUCTURE_TYPE_GENERIC_KHR);
}

GUARD_TEST(test_built_later_in_the_command_buffer)
{
    VkAccelerationStructureKHR structure = guard_make(&guard_scene.spare);
    const uint64_t reference = guard_refer_to(structure);
    VkCommandBuffer commands = fixture_begin(&fixture, 0);
    guard_build(commands, 1);
    fixture_barrier(&fixture, commands);
    guard_build_boxes(commands, structure);
    guard_finish(commands, 0);
    guard_expect("replaced 1 reference", "instance 0");
    guard_build_alone(1);
    guard_expect_read(&(uint64_t){reference}, 1);
    fixture_expect_silence(&fixture);
}

GUARD_TEST(test_built_by_a_copy_in_a_secondary)
{
    VkAccelerationStructureKHR structure = guard_make(&guard_scene.spare);
    const uint64_t reference = guard_refer_to(structure);
    VkCommandBuffer first = fixture_begin_secondary(&fixture, 0),
                    second = fixture_begin_secondary(&fixture, 0);
    const VkCopyAccelerationStructureInfoKHR copy =
        copy_info(scene.blas, structure, VK_COPY_ACCELERATION_STRUCTURE_MODE_CLONE_KHR);
    fixture.vk.CmdCopyAccelerationStructureKHR(first, &copy);
    fixture_barrier(&fixture, first);
    guard_build(second, 1);
    fixture_barrier(&fixture, second);
    GET(fixture.vk.EndCommandBuffer(first));
    GET(fixture.vk.EndCommandBuffer(second));
    VkCommandBuffer commands = fixture_begin(&fixture, 0);
    fixture.vk.CmdExecuteCommands(commands, 1, &second);
    fixture.vk.CmdExecuteCommands(commands, 1, &first);
    guard_finish(commands, 0);
    guard_expect("replaced 1 reference", "instance 0");
    commands = fixture_begin(&fixture, 0);
    fixture.vk.CmdExecuteCommands(commands, 1, &first);
    fixture.vk.CmdExecuteCommands(commands, 1, &second);
    guard_finish(commands, reference);
    fixture_expect_silence(&fixture);
}

/* The table of each submission, with one command buffer. */
static void resubmit(VkCommandBufferUsageFlags flags)
{
    uint64_t reference = guard_address(scene.blas);
    VkCommandBuffer commands = fixture_begin(&fixture, flags);
    guard_build(commands, 1);
    GET(fixture.vk.EndCommandBuffer(commands));
    guard_write(&reference, 1);
    guard_run(commands, reference);
    fixture_expect_silence(&fixture);
    VkAccelerationStructureKHR later = guard_build_another(&guard_scene.spare);
    reference = guard_refer_to(later);
    guard_run(commands, reference);
    fixture_expect_silence(&fixture);
    guard_destroy(later);
    guard_run(commands, 0);
    guard_expect(GUARD_NO_STRUCTURE, "replaced 1 reference");
}

GUARD_TEST(test_resubmitted)
{
    resubmit(0);
}

GUARD_TEST(test_resubmitted_simultaneous)
{
    resubmit(VK_COMMAND_BUFFER_USAGE_SIMULTANEOUS_USE_BIT);
}

/* The memory of snapshots was given back after the first submission, so the second reads nothing,
 * but nothing wild either. */
GUARD_TEST(test_submitted_once_more)
{
    const uint64_t reference = guard_refer_to(scene.blas);
    VkCommandBuffer commands = fixture_begin(&fixture, VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT);
    guard_build(commands, 1);
    GET(fixture.vk.EndCommandBuffer(commands));
    guard_run(commands, reference);
    guard_run(commands, 0);
    messages_clear(&fixture.instance.messages); /* of the resubmission */
}

/* Many structures, so that the table grows, while they come and go. */
GUARD_TEST(test_table_grows)
{
    enum { COUNT = 1500, SMALL = 256 };
    static VkAccelerationStructureKHR structures[COUNT];
    struct device_buffer buffer = fixture_buffer(
        &fixture, COUNT * SMALL, VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_STORAGE_BIT_KHR);
    const uint64_t reference = guard_refer_to(scene.blas);
    for (int round = 0; round < 3; round++) {
        for (uint32_t i = 0; i < COUNT; i++) {
            const STRUCT(VkAccelerationStructureCreateInfoKHR, info, .buffer = buffer.handle,
                         .offset = i * SMALL, .size = SMALL,
                         .type = VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR);
            GET(fixture.vk.CreateAccelerationStructureKHR(fixture.device, &info, NULL,
                                                          &structures[i]));
        }
        guard_build_alone(1);
        guard_expect_read(&(uint64_t){reference}, 1);
        for (uint32_t i = 0; i < COUNT; i++)
            fixture.vk.DestroyAccelerationStructureKHR(fixture.device, structures[i], NULL);
    }
    fixture_expect_silence(&fixture);
}
