/* SPDX-License-Identifier: Apache-2.0 */
/* Instances, and builds that read them in each way. */
#include "tests/snapshots/guard_scene.h"

#include <string.h>

struct guard_scene guard_scene;

void guard_open(const char *guard)
{
    SCENE_OPEN(.settings = {.guard = guard, .queue_count = platform.is_null ? 2 : 1},
               .boxes_size = sizeof(VkAabbPositionsKHR), .structure_size = STRUCTURE_SIZE,
               .has_tlas = true);
    guard_scene = (struct guard_scene){
        .instances = fixture_buffer(
            &fixture, GUARD_INSTANCES * INSTANCE_SIZE,
            VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT |
                VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR),
        .pointers = scene_input(GUARD_INSTANCES * sizeof(uint64_t)),
        .range = fixture_buffer(&fixture, sizeof(VkAccelerationStructureBuildRangeInfoKHR),
                                VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT),
        .spare = guard_buffer(),
    };
    VkCommandBuffer commands = scene_record_boxes(0, 1);
    fixture_finish(&fixture, commands);
    fixture_expect_silence(&fixture);
    if (platform.is_null)
        platform.null_driver.set_reads_instances(true);
}

void guard_open_references(void)
{
    guard_open("references");
}

void guard_close(void)
{
    if (platform.is_null)
        platform.null_driver.set_reads_instances(false);
    scene_close();
}

/* ---- structures */

uint64_t guard_address(VkAccelerationStructureKHR structure)
{
    return structure_address(&fixture.vk, fixture.device, structure);
}

struct device_buffer guard_buffer(void)
{
    return fixture_buffer(&fixture, STRUCTURE_SIZE,
                          VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_STORAGE_BIT_KHR);
}

VkAccelerationStructureKHR guard_make(const struct device_buffer *buffer)
{
    return fixture_structure(&fixture, buffer, 0, STRUCTURE_SIZE,
                             VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR);
}

uint64_t guard_wild(void)
{
    return 0x7f0123456700;
}

void guard_destroy(VkAccelerationStructureKHR structure)
{
    assert_true(fixture.structures[--fixture.structure_count] == structure);
    fixture.vk.DestroyAccelerationStructureKHR(fixture.device, structure, NULL);
}

void guard_build_boxes(VkCommandBuffer commands, VkAccelerationStructureKHR structure)
{
    fixture_build_boxes(&fixture, commands, structure, scene.boxes.address, 1,
                        scene.scratch_address);
    fixture_barrier(&fixture, commands);
}

VkAccelerationStructureKHR guard_build_another(const struct device_buffer *buffer)
{
    VkAccelerationStructureKHR structure = guard_make(buffer);
    VkCommandBuffer commands = fixture_begin(&fixture, 0);
    guard_build_boxes(commands, structure);
    fixture_finish(&fixture, commands);
    return structure;
}

uint64_t guard_of_another_device(void)
{
    struct fixture here = fixture;
    struct fixture other;
    uint64_t reference;
    const struct instance_settings settings = {.level = "content", .guard = "references"};
    fixture_open(&other, &platform, &settings);
    fixture = other;
    /* Beside buffers that this device does not have, so that its addresses are others. */
    for (int i = 0; i < 4; i++)
        guard_buffer();
    struct device_buffer buffer = guard_buffer();
    reference = guard_address(guard_make(&buffer));
    fixture_close(&fixture);
    fixture = here;
    return reference;
}

/* ---- instances */

void guard_write(const uint64_t *references, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++) {
        struct device_buffer at = guard_scene.instances;
        at.bytes += (size_t)i * INSTANCE_SIZE;
        scene_write_instance(&at, true);
        memcpy(at.bytes + INSTANCE_SIZE - sizeof(uint64_t), &references[i], sizeof(uint64_t));
        guard_point(i, guard_scene.instances.address + (VkDeviceSize)i * INSTANCE_SIZE);
    }
}

uint64_t guard_refer_to(VkAccelerationStructureKHR structure)
{
    const uint64_t reference = guard_address(structure);
    guard_write(&reference, 1);
    return reference;
}

void guard_point(uint32_t pointer, uint64_t address)
{
    memcpy(guard_scene.pointers.bytes + pointer * sizeof(address), &address, sizeof(address));
}

void guard_change_reference(VkCommandBuffer commands, uint64_t reference)
{
    fixture.vk.CmdUpdateBuffer(commands, guard_scene.instances.handle,
                               INSTANCE_SIZE - sizeof(reference), sizeof(reference), &reference);
    fixture_barrier(&fixture, commands);
}

/* ---- builds */

void guard_build_at(VkCommandBuffer commands, uint32_t offset, uint32_t count)
{
    struct fixture_build build =
        scene_describe_instances(guard_scene.instances.address, false, count);
    build.range.primitiveOffset = offset;
    fixture_build(&fixture, commands, &build);
}

void guard_build(VkCommandBuffer commands, uint32_t count)
{
    guard_build_at(commands, 0, count);
}

void guard_build_pointers(VkCommandBuffer commands, uint32_t count)
{
    const struct fixture_build build =
        scene_describe_instances(guard_scene.pointers.address, true, count);
    fixture_build(&fixture, commands, &build);
}

void guard_build_moving(VkCommandBuffer commands, bool are_pointers, uint32_t count)
{
    struct fixture_build build = scene_describe_instances(
        are_pointers ? guard_scene.pointers.address : guard_scene.instances.address, are_pointers,
        count);
    build.info.flags = VK_BUILD_ACCELERATION_STRUCTURE_MOTION_BIT_NV;
    fixture_build(&fixture, commands, &build);
}

/* The range is what the device reads: fewer instances than the host knows, from an offset on. */
void guard_build_indirect(VkCommandBuffer commands, uint32_t count)
{
    struct fixture_build build = scene_describe_instances(guard_scene.instances.address, false, 0);
    const VkAccelerationStructureBuildRangeInfoKHR range = {.primitiveCount = count,
                                                            .primitiveOffset = INSTANCE_SIZE};
    const uint32_t stride = sizeof(range), most = GUARD_INSTANCES, *counts = &most;
    build.info.sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_BUILD_GEOMETRY_INFO_KHR;
    build.info.geometryCount = 1;
    build.info.pGeometries = &build.geometry;
    memmove(guard_scene.instances.bytes + INSTANCE_SIZE, guard_scene.instances.bytes,
            (size_t)count * INSTANCE_SIZE);
    memcpy(guard_scene.range.bytes, &range, sizeof(range));
    fixture.vk.CmdBuildAccelerationStructuresIndirectKHR(
        commands, 1, &build.info, &guard_scene.range.address, &stride, &counts);
}

void guard_build_alone(uint32_t count)
{
    VkCommandBuffer commands = fixture_begin(&fixture, 0);
    guard_build(commands, count);
    fixture_finish(&fixture, commands);
}

/* ---- expectations */

void guard_run(VkCommandBuffer commands, uint64_t reads)
{
    commands_run(&fixture.vk, fixture.device, fixture.queue, commands);
    guard_expect_read(&reads, 1);
}

void guard_finish(VkCommandBuffer commands, uint64_t reads)
{
    fixture_finish(&fixture, commands);
    guard_expect_read(&reads, 1);
}

void guard_expect_read(const uint64_t *references, uint32_t count)
{
    uint64_t read[2 * GUARD_INSTANCES];
    if (!platform.is_null)
        return;
    assert_int_equal(platform.null_driver.take_references(read, 2 * GUARD_INSTANCES), count);
    for (uint32_t i = 0; i < count; i++)
        assert_int_equal(read[i], references[i]);
}

void guard_expect(const char *text, const char *other)
{
    struct messages *messages = &fixture.instance.messages;
    bool is_there = false;
    for (uint32_t i = 0; i < messages_kept(messages); i++)
        is_there |= strstr(messages->items[i].text, text) && strstr(messages->items[i].text, other);
    if (!is_there)
        fail_msg("no message has \"%s\" and \"%s\"; %u messages: %s", text, other, messages->count,
                 messages->count ? messages->items[0].text : "");
    messages_clear(messages);
}
