/* SPDX-License-Identifier: Apache-2.0 */
/* A BLAS of boxes, and a TLAS of an instance of it. */
#include "tests/snapshots/scene.h"

#include <string.h>

struct platform platform;
struct fixture fixture;
struct scene scene;

enum { SCRATCH_ALIGNMENT = 256 };

void scene_open(const struct scene_setup *setup)
{
    const VkDeviceSize size = setup->structure_size;
    struct instance_settings settings = setup->settings;
    if (!settings.level)
        settings.level = "content";
    fixture_open(&fixture, &platform, &settings);
    scene = (struct scene){
        .boxes = scene_input(setup->boxes_size),
        .structures = fixture_buffer(&fixture, (1 + setup->has_tlas) * size,
                                     VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_STORAGE_BIT_KHR),
        .scratch = fixture_buffer(&fixture, size, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT),
    };
    scene.scratch_address =
        (scene.scratch.address + SCRATCH_ALIGNMENT - 1) / SCRATCH_ALIGNMENT * SCRATCH_ALIGNMENT;
    scene.blas = fixture_structure(&fixture, &scene.structures, 0, size,
                                   VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR);
    if (setup->has_tlas)
        scene.tlas = fixture_structure(&fixture, &scene.structures, size, size,
                                       VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR);
}

void scene_close(void)
{
    fixture_close(&fixture);
}

struct device_buffer scene_input(VkDeviceSize size)
{
    return fixture_buffer(&fixture, size,
                          VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR);
}

void scene_build_boxes(VkCommandBuffer commands, uint32_t count)
{
    fixture_build_boxes(&fixture, commands, scene.blas, scene.boxes.address, count,
                        scene.scratch_address);
    fixture_barrier(&fixture, commands);
}

VkCommandBuffer scene_record_boxes(VkCommandBufferUsageFlags flags, uint32_t count)
{
    VkCommandBuffer commands = fixture_begin(&fixture, flags);
    scene_build_boxes(commands, count);
    return commands;
}

void scene_submit(VkCommandBuffer commands)
{
    GET(fixture.vk.EndCommandBuffer(commands));
    GET(fixture_submit(&fixture, commands, VK_NULL_HANDLE));
}

void scene_write_instance(const struct device_buffer *buffer, bool is_valid)
{
    VkAccelerationStructureInstanceKHR written = {
        .mask = 0xff,
        .accelerationStructureReference =
            structure_address(&fixture.vk, fixture.device, scene.blas),
    };
    for (int i = 0; i < 3; i++)
        written.transform.matrix[i][i] = is_valid ? 1 : 0;
    memcpy(buffer->bytes, &written, sizeof(written));
}

struct fixture_build scene_describe_instances(VkDeviceAddress data, bool are_pointers,
                                              uint32_t count)
{
    return (struct fixture_build){
        .geometry = instances_geometry(data, are_pointers),
        .info = {.type = VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR,
                 .dstAccelerationStructure = scene.tlas,
                 .scratchData.deviceAddress = scene.scratch_address},
        .range.primitiveCount = count,
    };
}

void scene_build_instance(VkCommandBuffer commands, VkDeviceAddress data, bool is_pointer)
{
    const struct fixture_build build = scene_describe_instances(data, is_pointer, 1);
    fixture_build(&fixture, commands, &build);
}

void scene_invalidate_box(uint32_t i)
{
    ((VkAabbPositionsKHR *)scene.boxes.bytes)[i] = (VkAabbPositionsKHR){.minX = 1, .maxX = -1};
}

void expect_messages(uint32_t count, const char *text)
{
    struct messages *messages = &fixture.instance.messages;
    for (uint32_t i = 0; i < messages_kept(messages); i++)
        assert_has(messages->items[i].text, text);
    assert_int_equal(messages->count, count);
    messages_clear(messages);
}

const char *unit_test_open(const char *name)
{
    return platform_open(&platform, name ? name : "null");
}
