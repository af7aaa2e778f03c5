/* SPDX-License-Identifier: Apache-2.0 */
/* Updates of device builds are compared with the inputs of their own source, whatever else their
 * command buffer updates, and however often it executes a secondary one. */
#include <math.h>
#include <string.h>

#include "tests/fixture/copies.h"
#include "tests/snapshots/scene.h"

enum {
    TRIANGLES = 2,
    VERTEX = 3 * sizeof(float),
    INDICES_AT = 1024, /* in each input buffer, after the vertices */
    STRUCTURE_SIZE = 1 << 16,
};

/* Two structures with an input buffer each, and one that is deserialized from the first. */
static struct {
    struct device_buffer inputs[2], memory;
    VkAccelerationStructureKHR built[2], loaded;
} updated;

static const float active[TRIANGLES * 3][3] = {{0}, {1}, {0, 1}, {2}, {3}, {2, 1}};

static void write_inputs(const struct device_buffer *input)
{
    const uint32_t indices[TRIANGLES * 3] = {0, 1, 2, 3, 4, 5};
    memcpy(input->bytes, active, sizeof(active));
    memcpy(input->bytes + INDICES_AT, indices, sizeof(indices));
}

static VkAccelerationStructureKHR create_structure(uint32_t i)
{
    return fixture_structure(&fixture, &scene.structures, (VkDeviceSize)i * STRUCTURE_SIZE,
                             STRUCTURE_SIZE, VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR);
}

static void open_scene(void)
{
    SCENE_OPEN(.boxes_size = 64, .structure_size = 4 * STRUCTURE_SIZE);
    for (uint32_t i = 0; i < 2; i++) {
        updated.inputs[i] =
            fixture_buffer(&fixture, 2 * INDICES_AT,
                           VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR |
                               VK_BUFFER_USAGE_TRANSFER_DST_BIT);
        write_inputs(&updated.inputs[i]);
        updated.built[i] = create_structure(i);
    }
    updated.loaded = create_structure(2);
    updated.memory = fixture_buffer(&fixture, 4 * STRUCTURE_SIZE, 0);
}

/* An update if `src` is not VK_NULL_HANDLE. Reads the inputs `i`. */
static void record_build(VkCommandBuffer commands, VkAccelerationStructureKHR dst,
                         VkAccelerationStructureKHR src, uint32_t i)
{
    const VkDeviceAddress address = updated.inputs[i].address;
    const struct fixture_build build = {
        .geometry = triangles_geometry(address, TRIANGLES * 3 - 1, VK_INDEX_TYPE_UINT32,
                                       address + INDICES_AT),
        .info = {.type = VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR,
                 .flags = VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_UPDATE_BIT_KHR,
                 .mode = src ? VK_BUILD_ACCELERATION_STRUCTURE_MODE_UPDATE_KHR
                             : VK_BUILD_ACCELERATION_STRUCTURE_MODE_BUILD_KHR,
                 .srcAccelerationStructure = src,
                 .dstAccelerationStructure = dst,
                 .scratchData.deviceAddress = scene.scratch_address},
        .range.primitiveCount = TRIANGLES,
    };
    fixture_build(&fixture, commands, &build);
    fixture_barrier(&fixture, commands);
}

static void deserialize(void)
{
    const VkDeviceAddress memory = (updated.memory.address + 255) / 256 * 256;
    const VkCopyAccelerationStructureToMemoryInfoKHR save =
        serialize_info(updated.built[0], memory);
    const VkCopyMemoryToAccelerationStructureInfoKHR load =
        deserialize_info(memory, updated.loaded);
    VkCommandBuffer commands = fixture_begin(&fixture, 0);
    record_build(commands, updated.built[0], VK_NULL_HANDLE, 0);
    fixture.vk.CmdCopyAccelerationStructureToMemoryKHR(commands, &save);
    fixture_finish(&fixture, commands);
    commands = fixture_begin(&fixture, 0);
    fixture.vk.CmdCopyMemoryToAccelerationStructureKHR(commands, &load);
    fixture_finish(&fixture, commands);
}

static void set_first_x(const struct device_buffer *input, float x)
{
    memcpy(input->bytes, &x, sizeof(x));
}

static void set_first_index(const struct device_buffer *input, uint32_t index)
{
    memcpy(input->bytes + INDICES_AT, &index, sizeof(index));
}

/* What differs between a build and its update. */
static const struct mistake {
    const char *id;
    float built_x, updated_x;
    uint32_t updated_index;
} mistakes[] = {
    {"VUID-vkCmdBuildAccelerationStructuresKHR-pInfos-03663", NAN, 0, 0},
    {"VUID-vkCmdBuildAccelerationStructuresKHR-pInfos-03664", 0, NAN, 0},
    {"VUID-vkCmdBuildAccelerationStructuresKHR-pInfos-03768", 0, 0, 3},
    {NULL, NAN, NAN, 0},
};

static void expect_mistake(const struct mistake *mistake)
{
    if (mistake->id)
        expect_messages(1, mistake->id);
    else
        fixture_expect_silence(&fixture);
}

/* The inputs of a deserialized structure are unknown; those of other builds are known. */
SCENE_TEST(test_builds_behind_an_update_of_a_deserialized_structure)
{
    deserialize();
    for (uint32_t i = 0; i < sizeof(mistakes) / sizeof(mistakes[0]); i++) {
        set_first_x(&updated.inputs[1], mistakes[i].built_x);
        set_first_index(&updated.inputs[1], 0);
        VkCommandBuffer commands = fixture_begin(&fixture, 0);
        record_build(commands, updated.loaded, updated.loaded, 0);
        record_build(commands, updated.built[1], VK_NULL_HANDLE, 1);
        fixture_finish(&fixture, commands);
        fixture_expect_silence(&fixture);
        set_first_x(&updated.inputs[1], mistakes[i].updated_x);
        set_first_index(&updated.inputs[1], mistakes[i].updated_index);
        commands = fixture_begin(&fixture, 0);
        record_build(commands, updated.loaded, updated.loaded, 0);
        record_build(commands, updated.built[1], updated.built[1], 1);
        fixture_finish(&fixture, commands);
        expect_mistake(&mistakes[i]);
    }
}

static void record_first_x(VkCommandBuffer commands, uint32_t i, float x)
{
    fixture.vk.CmdUpdateBuffer(commands, updated.inputs[i].handle, 0, sizeof(x), &x);
    fixture_barrier(&fixture, commands);
}

static VkCommandBuffer begin_repeated(void)
{
    return fixture_begin_secondary(&fixture, VK_COMMAND_BUFFER_USAGE_SIMULTANEOUS_USE_BIT);
}

/* Executes a secondary command buffer twice. Its second execution reads an inactive triangle, and
 * overwrites what the first one copied. */
static void run_twice(VkCommandBuffer secondary)
{
    GET(fixture.vk.EndCommandBuffer(secondary));
    VkCommandBuffer commands = fixture_begin(&fixture, 0);
    fixture.vk.CmdExecuteCommands(commands, 1, &secondary);
    fixture_barrier(&fixture, commands);
    record_first_x(commands, 0, NAN);
    fixture.vk.CmdExecuteCommands(commands, 1, &secondary);
    fixture_finish(&fixture, commands);
    expect_messages(1, "1 followed by another of the same command buffer in the submission");
}

/* The last execution of the build is what the update changes. */
SCENE_TEST(test_build_of_a_repeated_secondary)
{
    VkCommandBuffer secondary = begin_repeated();
    record_build(secondary, updated.built[0], VK_NULL_HANDLE, 0);
    run_twice(secondary);
    set_first_x(&updated.inputs[0], 0);
    VkCommandBuffer commands = fixture_begin(&fixture, 0);
    record_build(commands, updated.built[0], updated.built[0], 0);
    fixture_finish(&fixture, commands);
    expect_messages(1, mistakes[0].id);
}

/* The second execution of the update has another source than the first. */
SCENE_TEST(test_update_of_a_repeated_secondary)
{
    const VkCopyAccelerationStructureInfoKHR clone = copy_info(
        updated.built[1], updated.built[0], VK_COPY_ACCELERATION_STRUCTURE_MODE_CLONE_KHR);
    set_first_x(&updated.inputs[1], NAN);
    VkCommandBuffer commands = fixture_begin(&fixture, 0);
    record_build(commands, updated.built[0], VK_NULL_HANDLE, 0);
    record_build(commands, updated.built[1], VK_NULL_HANDLE, 1);
    fixture_finish(&fixture, commands);
    VkCommandBuffer secondary = begin_repeated();
    record_build(secondary, updated.loaded, updated.built[0], 0);
    fixture.vk.CmdCopyAccelerationStructureKHR(secondary, &clone);
    run_twice(secondary);
}
