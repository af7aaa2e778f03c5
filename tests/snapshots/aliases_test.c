/* SPDX-License-Identifier: Apache-2.0 */
/* A build names addresses, which it resolves when it executes. The buffer that had an address when
 * the command was recorded may be destroyed by then: another buffer on the same memory has the same
 * address, or takes it later. The layer must read what the build reads. */
#include "tests/snapshots/scene.h"

#include <string.h>

enum {
    BOXES = 2,
    CORNERS = 3,
    MEMORY_SIZE = 1 << 16,
    LURES = 4,
};

/* ---- memory that buffers share, so that they have the same address */

/* Mapped, and all zeros. */
struct memory {
    VkDeviceMemory handle;
    unsigned char *bytes;
};

/* A buffer at the begin of a memory, which builds may read. */
struct placed {
    VkBuffer handle;
    VkDeviceAddress address;
};

static struct memory memory;
static struct placed first, second; /* in `memory` */

/* Buffers that a driver may put where a destroyed one was: who still uses the destroyed buffer's
 * handle reads their memory. */
static struct memory lure_memory;
static struct placed lures[LURES];

static struct device_buffer vertices;

static struct memory memory_allocate(void)
{
    struct memory allocated = {
        memory_create(&fixture.vk, fixture.device, fixture.memory_type, MEMORY_SIZE), NULL};
    GET(fixture.vk.MapMemory(fixture.device, allocated.handle, 0, VK_WHOLE_SIZE, 0,
                             (void **)&allocated.bytes));
    memset(allocated.bytes, 0, MEMORY_SIZE);
    return allocated;
}

static void memory_free(struct memory *freed)
{
    fixture.vk.FreeMemory(fixture.device, freed->handle, NULL);
    freed->handle = VK_NULL_HANDLE;
}

static struct placed memory_place(const struct memory *in, VkDeviceSize size)
{
    struct placed placed;
    const STRUCT(VkBufferCreateInfo, info, .size = size,
                 .usage = VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR |
                          VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT);
    VkMemoryRequirements requirements;
    GET(fixture.vk.CreateBuffer(fixture.device, &info, NULL, &placed.handle));
    fixture.vk.GetBufferMemoryRequirements(fixture.device, placed.handle, &requirements);
    GET(fixture.vk.BindBufferMemory(fixture.device, placed.handle, in->handle, 0));
    placed.address = buffer_address(&fixture.vk, fixture.device, placed.handle);
    return placed;
}

static void memory_destroy(struct placed *placed)
{
    fixture.vk.DestroyBuffer(fixture.device, placed->handle, NULL);
    placed->handle = VK_NULL_HANDLE;
}

static void lures_lay(void)
{
    for (int i = 0; i < LURES; i++)
        lures[i] = memory_place(&lure_memory, MEMORY_SIZE);
}

/* The second buffer takes the place of the first. */
static void replace_first(VkDeviceSize size)
{
    memory_destroy(&first);
    lures_lay();
    second = memory_place(&memory, size);
}

/* ---- the scene, with the first buffer */

static void open_scene_at(const char *level)
{
    SCENE_OPEN(.settings.level = level, .boxes_size = MEMORY_SIZE, .structure_size = MEMORY_SIZE);
    vertices = scene_input(MEMORY_SIZE);
    lure_memory = memory_allocate();
    memory = memory_allocate();
    first = memory_place(&memory, MEMORY_SIZE);
}

static void open_scene(void)
{
    open_scene_at("content");
}

static void close_scene(void)
{
    memory_destroy(&first);
    memory_destroy(&second);
    for (int i = 0; i < LURES; i++)
        memory_destroy(&lures[i]);
    memory_free(&memory);
    memory_free(&lure_memory);
    scene_close();
}

#define ALIAS_TEST(name) TEST_BETWEEN_IF(name, open_scene, close_scene, true)

/* ---- what the lures have is the contrary of what the build reads */

static void write_boxes(const struct memory *to, bool is_valid)
{
    VkAabbPositionsKHR box = {.minX = is_valid ? -1 : 1};
    for (int i = 0; i < BOXES; i++)
        memcpy(to->bytes + i * sizeof(box), &box, sizeof(box));
}

static void write_indices(const struct memory *to, bool is_as_before)
{
    const uint32_t indices[CORNERS] = {0, 1, is_as_before ? 2 : 0};
    memcpy(to->bytes, indices, sizeof(indices));
}

/* ---- builds */

static void build_boxes(VkCommandBuffer commands, VkDeviceAddress address)
{
    fixture_build_boxes(&fixture, commands, scene.blas, address, BOXES, scene.scratch_address);
    fixture_barrier(&fixture, commands);
}

/* A triangle whose indices are at the address; an update of the BLAS, or its first build. */
static void build_triangle(VkCommandBuffer commands, VkDeviceAddress indices, bool is_update)
{
    const struct fixture_build build = {
        .geometry =
            triangles_geometry(vertices.address, CORNERS - 1, VK_INDEX_TYPE_UINT32, indices),
        .info = {.type = VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR,
                 .flags = VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_UPDATE_BIT_KHR,
                 .mode = is_update ? VK_BUILD_ACCELERATION_STRUCTURE_MODE_UPDATE_KHR
                                   : VK_BUILD_ACCELERATION_STRUCTURE_MODE_BUILD_KHR,
                 .srcAccelerationStructure = is_update ? scene.blas : VK_NULL_HANDLE,
                 .dstAccelerationStructure = scene.blas,
                 .scratchData.deviceAddress = scene.scratch_address},
        .range.primitiveCount = 1,
    };
    fixture_build(&fixture, commands, &build);
    fixture_barrier(&fixture, commands);
}

static void update_triangle(VkCommandBuffer commands, VkDeviceAddress indices)
{
    build_triangle(commands, indices, true);
}

/* One message with the text, or none if it is NULL. */
static void expect_told(const char *text)
{
    if (text)
        expect_messages(1, text);
    else
        fixture_expect_silence(&fixture);
}

/* ---- two buffers on the same memory */

/* What the test does with the buffers between recording and submission. */
enum change {
    FIRST_IS_DESTROYED,
    SECOND_IS_DESTROYED,
    FIRST_IS_REPLACED, /* by the second, which is created then */
    CHANGE_COUNT,
};

/* What a build reads at an address: boxes, or the indices of an update. */
static const struct input {
    void (*write)(const struct memory *to, bool is_valid);
    void (*build)(VkCommandBuffer commands, VkDeviceAddress address);
    const char *message; /* if it is not valid */
    bool is_update;
} boxes = {write_boxes, build_boxes, "minX", false},
  indices = {write_indices, update_triangle, "03768", true};

static void test_change(const struct input *input, const char *level, enum change change,
                        bool is_valid)
{
    open_scene_at(level);
    if (change != FIRST_IS_REPLACED)
        second = memory_place(&memory, MEMORY_SIZE);
    VkCommandBuffer commands = fixture_begin(&fixture, 0);
    input->write(&memory, true);
    if (input->is_update)
        build_triangle(commands, first.address, false);
    fixture_finish(&fixture, commands);
    input->write(&memory, is_valid);
    input->write(&lure_memory, !is_valid);
    commands = fixture_begin(&fixture, 0);
    input->build(commands, first.address);
    if (change == FIRST_IS_REPLACED) {
        replace_first(MEMORY_SIZE);
    } else {
        memory_destroy(change == SECOND_IS_DESTROYED ? &second : &first);
        lures_lay();
    }
    assert_int_equal(first.address, change == SECOND_IS_DESTROYED ? first.address : second.address);
    fixture_finish(&fixture, commands);
    expect_told(is_valid || strcmp(level, "content") != 0 ? NULL : input->message);
    close_scene();
}

TEST(test_changes)
{
    static const char *const levels[] = {"execution", "content"};
    for (int i = 0; i < 2; i++)
        for (int change = 0; change < CHANGE_COUNT; change++)
            for (int is_valid = 0; is_valid < 2; is_valid++) {
                test_change(&boxes, levels[i], (enum change)change, is_valid);
                test_change(&indices, levels[i], (enum change)change, is_valid);
            }
}

/* Boxes at the first buffer's address. */
static VkCommandBuffer record_boxes(void)
{
    VkCommandBuffer commands = fixture_begin(&fixture, 0);
    build_boxes(commands, first.address);
    return commands;
}

/* Each submission reads from what has the address then. */
ALIAS_TEST(test_submits_again)
{
    write_boxes(&memory, true);
    VkCommandBuffer commands = record_boxes();
    scene_submit(commands);
    GET(fixture.vk.QueueWaitIdle(fixture.queue));
    fixture_expect_silence(&fixture);
    replace_first(MEMORY_SIZE);
    write_boxes(&memory, false);
    GET(fixture_submit(&fixture, commands, VK_NULL_HANDLE));
    GET(fixture.vk.QueueWaitIdle(fixture.queue));
    expect_told("minX");
}

ALIAS_TEST(test_in_secondary)
{
    write_boxes(&memory, false);
    write_boxes(&lure_memory, true);
    VkCommandBuffer secondary = fixture_begin_secondary(&fixture, 0);
    VkCommandBuffer commands = fixture_begin(&fixture, 0);
    build_boxes(secondary, first.address);
    GET(fixture.vk.EndCommandBuffer(secondary));
    fixture.vk.CmdExecuteCommands(commands, 1, &secondary);
    replace_first(MEMORY_SIZE);
    fixture_finish(&fixture, commands);
    expect_told("minX");
    fixture.vk.FreeCommandBuffers(fixture.device, fixture.pool, 1, &secondary);
}

/* ---- the application's mistakes: where the driver doesn't build, and so reads nothing */

#define MISTAKE_TEST(name)                                                                         \
    TEST_BETWEEN_IF(name, open_scene, close_scene, platform.is_null || platform.is_cpu)

/* The build reads more than the buffer has: what it reads beyond the end isn't known. */
MISTAKE_TEST(test_replaced_by_smaller)
{
    write_boxes(&memory, false);
    VkCommandBuffer commands = record_boxes();
    memory_destroy(&first);
    second = memory_place(&memory, sizeof(VkAabbPositionsKHR));
    fixture_finish(&fixture, commands);
    fixture_expect_silence(&fixture);
}

/* The memory is freed, and may be unmapped. */
MISTAKE_TEST(test_nothing_is_there)
{
    write_boxes(&memory, false);
    write_boxes(&lure_memory, false);
    VkCommandBuffer commands = record_boxes();
    memory_destroy(&first);
    memory_free(&memory);
    lures_lay();
    fixture_finish(&fixture, commands);
    expect_told("11364"); /* the address leads nowhere; nothing of what it led to */
}

/* On the null driver, which can give the address to other memory. */
TEST_IF(test_on_other_memory, platform.is_null)
{
    struct null_driver_config config = platform.null_driver.default_config();
    config.recycle_addresses = true;
    platform.null_driver.configure(&config);
    for (int is_valid = 0; is_valid < 2; is_valid++) {
        open_scene();
        write_boxes(&memory, !is_valid);
        VkCommandBuffer commands = record_boxes();
        memory_destroy(&first);
        memory_free(&memory);
        memory = memory_allocate();
        second = memory_place(&memory, MEMORY_SIZE);
        assert_int_equal(first.address, second.address);
        write_boxes(&memory, is_valid);
        fixture_finish(&fixture, commands);
        expect_told(is_valid ? NULL : "minX");
        close_scene();
    }
    platform.null_driver.configure(NULL);
}
