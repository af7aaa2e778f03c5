/* SPDX-License-Identifier: Apache-2.0 */
/* A build names addresses, which it resolves when it executes. The buffer that had an address when
 * the command was recorded may be destroyed by then: another buffer on the same memory has the same
 * address, or takes it later. The layer must read what the build reads. */
#include "tests/snapshots/scene.h"

#include <stdio.h>
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

/* Buffers that a driver may put where a destroyed one was: who still uses the destroyed buffer's
 * handle reads their memory. */
struct lures {
    struct memory memory;
    struct placed buffers[LURES];
};

static struct memory memory_allocate(void)
{
    struct memory memory = {
        memory_create(&fixture.vk, fixture.device, fixture.memory_type, MEMORY_SIZE), NULL};
    GET(fixture.vk.MapMemory(fixture.device, memory.handle, 0, VK_WHOLE_SIZE, 0,
                             (void **)&memory.bytes));
    memset(memory.bytes, 0, MEMORY_SIZE);
    return memory;
}

static void memory_free(const struct memory *memory)
{
    fixture.vk.FreeMemory(fixture.device, memory->handle, NULL);
}

static struct placed memory_place(const struct memory *memory, VkDeviceSize size)
{
    struct placed placed;
    const VkBufferCreateInfo info =
        VK(BufferCreateInfo, .size = size,
           .usage = VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR |
                    VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT);
    VkMemoryRequirements requirements;
    GET(fixture.vk.CreateBuffer(fixture.device, &info, NULL, &placed.handle));
    fixture.vk.GetBufferMemoryRequirements(fixture.device, placed.handle, &requirements);
    GET(fixture.vk.BindBufferMemory(fixture.device, placed.handle, memory->handle, 0));
    placed.address = buffer_address(&fixture.vk, fixture.device, placed.handle);
    return placed;
}

static void memory_destroy(const struct placed *placed)
{
    fixture.vk.DestroyBuffer(fixture.device, placed->handle, NULL);
}

static void lures_lay(struct lures *lures)
{
    for (int i = 0; i < LURES; i++)
        lures->buffers[i] = memory_place(&lures->memory, MEMORY_SIZE);
}

static void lures_free(const struct lures *lures)
{
    for (int i = 0; i < LURES; i++)
        memory_destroy(&lures->buffers[i]);
    memory_free(&lures->memory);
}

/* ---- the scene */

static struct device_buffer vertices;

static void open_scene(const char *level)
{
    scene_open(&(struct scene_setup){
        .settings.level = level, .boxes_size = MEMORY_SIZE, .structure_size = MEMORY_SIZE});
    vertices = scene_input(MEMORY_SIZE);
}

static void close_scene(void)
{
    fixture_destroy_buffer(&fixture, &vertices);
    scene_close();
}

static bool judges_inputs(const char *level)
{
    return strcmp(level, "content") == 0;
}

/* ---- what the lures have is the contrary of what the build reads */

static void write_boxes(const struct memory *memory, bool is_valid)
{
    VkAabbPositionsKHR box = {.minX = is_valid ? -1 : 1};
    for (int i = 0; i < BOXES; i++)
        memcpy(memory->bytes + i * sizeof(box), &box, sizeof(box));
}

static void write_indices(const struct memory *memory, bool is_as_before)
{
    const uint32_t indices[CORNERS] = {0, 1, is_as_before ? 2 : 0};
    memcpy(memory->bytes, indices, sizeof(indices));
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
        .geometry = {.geometryType = VK_GEOMETRY_TYPE_TRIANGLES_KHR,
                     .geometry.triangles =
                         VK(AccelerationStructureGeometryTrianglesDataKHR,
                            .vertexFormat = VK_FORMAT_R32G32B32_SFLOAT,
                            .vertexData.deviceAddress = vertices.address,
                            .vertexStride = 3 * sizeof(float), .maxVertex = CORNERS - 1,
                            .indexType = VK_INDEX_TYPE_UINT32, .indexData.deviceAddress = indices)},
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
    void (*write)(const struct memory *memory, bool is_valid);
    void (*build)(VkCommandBuffer commands, VkDeviceAddress address);
    const char *message; /* if it is not valid */
    bool is_update;
} boxes = {write_boxes, build_boxes, "minX", false},
  indices = {write_indices, update_triangle, "03768", true};

static void test_change(const struct input *input, const char *level, enum change change,
                        bool is_valid)
{
    open_scene(level);
    struct lures lures = {.memory = memory_allocate()};
    struct memory memory = memory_allocate();
    struct placed first = memory_place(&memory, MEMORY_SIZE), second;
    if (change != FIRST_IS_REPLACED)
        second = memory_place(&memory, MEMORY_SIZE);
    VkCommandBuffer commands = fixture_begin(&fixture, 0);
    input->write(&memory, true);
    if (input->is_update)
        build_triangle(commands, first.address, false);
    fixture_finish(&fixture, commands);
    input->write(&memory, is_valid);
    input->write(&lures.memory, !is_valid);
    commands = fixture_begin(&fixture, 0);
    input->build(commands, first.address);
    memory_destroy(change == SECOND_IS_DESTROYED ? &second : &first);
    lures_lay(&lures);
    if (change == FIRST_IS_REPLACED)
        second = memory_place(&memory, MEMORY_SIZE);
    assert_int_equal(first.address, change == SECOND_IS_DESTROYED ? first.address : second.address);
    fixture_finish(&fixture, commands);
    expect_told(is_valid || !judges_inputs(level) ? NULL : input->message);
    memory_destroy(change == SECOND_IS_DESTROYED ? &first : &second);
    memory_free(&memory);
    lures_free(&lures);
    close_scene();
}

static void test_changes(void **state)
{
    static const char *const levels[] = {"execution", "content"};
    for (int i = 0; i < 2; i++)
        for (int change = 0; change < CHANGE_COUNT; change++)
            for (int is_valid = 0; is_valid < 2; is_valid++) {
                test_change(&boxes, levels[i], (enum change)change, is_valid);
                test_change(&indices, levels[i], (enum change)change, is_valid);
            }
}

/* Each submission reads from what has the address then. */
static void test_submits_again(void **state)
{
    open_scene("content");
    struct lures lures = {.memory = memory_allocate()};
    struct memory memory = memory_allocate();
    struct placed first = memory_place(&memory, MEMORY_SIZE);
    write_boxes(&memory, true);
    VkCommandBuffer commands = fixture_begin(&fixture, 0);
    build_boxes(commands, first.address);
    scene_submit(commands);
    GET(fixture.vk.QueueWaitIdle(fixture.queue));
    fixture_expect_silence(&fixture);
    memory_destroy(&first);
    lures_lay(&lures);
    struct placed second = memory_place(&memory, MEMORY_SIZE);
    write_boxes(&memory, false);
    GET(fixture_submit(&fixture, commands, VK_NULL_HANDLE));
    GET(fixture.vk.QueueWaitIdle(fixture.queue));
    expect_told("minX");
    memory_destroy(&second);
    memory_free(&memory);
    lures_free(&lures);
    close_scene();
}

static void test_in_secondary(void **state)
{
    open_scene("content");
    struct lures lures = {.memory = memory_allocate()};
    struct memory memory = memory_allocate();
    struct placed first = memory_place(&memory, MEMORY_SIZE);
    write_boxes(&memory, false);
    write_boxes(&lures.memory, true);
    VkCommandBuffer secondary = fixture_begin_secondary(&fixture, 0);
    VkCommandBuffer commands = fixture_begin(&fixture, 0);
    build_boxes(secondary, first.address);
    GET(fixture.vk.EndCommandBuffer(secondary));
    fixture.vk.CmdExecuteCommands(commands, 1, &secondary);
    memory_destroy(&first);
    lures_lay(&lures);
    struct placed second = memory_place(&memory, MEMORY_SIZE);
    fixture_finish(&fixture, commands);
    expect_told("minX");
    fixture.vk.FreeCommandBuffers(fixture.device, fixture.pool, 1, &secondary);
    memory_destroy(&second);
    memory_free(&memory);
    lures_free(&lures);
    close_scene();
}

/* ---- the application's mistakes: where the driver doesn't build, and so reads nothing */

/* The build reads more than the buffer has: what it reads beyond the end isn't known. */
static void test_replaced_by_smaller(void **state)
{
    open_scene("content");
    struct memory memory = memory_allocate();
    struct placed first = memory_place(&memory, MEMORY_SIZE);
    write_boxes(&memory, false);
    VkCommandBuffer commands = fixture_begin(&fixture, 0);
    build_boxes(commands, first.address);
    memory_destroy(&first);
    struct placed second = memory_place(&memory, sizeof(VkAabbPositionsKHR));
    fixture_finish(&fixture, commands);
    fixture_expect_silence(&fixture);
    memory_destroy(&second);
    memory_free(&memory);
    close_scene();
}

/* The memory is freed, and may be unmapped. */
static void test_nothing_is_there(void **state)
{
    open_scene("content");
    struct lures lures = {.memory = memory_allocate()};
    struct memory memory = memory_allocate();
    struct placed first = memory_place(&memory, MEMORY_SIZE);
    write_boxes(&memory, false);
    write_boxes(&lures.memory, false);
    VkCommandBuffer commands = fixture_begin(&fixture, 0);
    build_boxes(commands, first.address);
    memory_destroy(&first);
    memory_free(&memory);
    lures_lay(&lures);
    fixture_finish(&fixture, commands);
    expect_told("11364"); /* the address leads nowhere; nothing of what it led to */
    lures_free(&lures);
    close_scene();
}

/* On the null driver, which can give the address to other memory. */
static void test_on_other_memory(void **state)
{
    struct null_driver_config config = platform.null_driver.default_config();
    config.recycle_addresses = true;
    platform.null_driver.configure(&config);
    for (int is_valid = 0; is_valid < 2; is_valid++) {
        open_scene("content");
        struct memory memory = memory_allocate();
        struct placed first = memory_place(&memory, MEMORY_SIZE);
        write_boxes(&memory, !is_valid);
        VkCommandBuffer commands = fixture_begin(&fixture, 0);
        build_boxes(commands, first.address);
        memory_destroy(&first);
        memory_free(&memory);
        memory = memory_allocate();
        struct placed second = memory_place(&memory, MEMORY_SIZE);
        assert_int_equal(first.address, second.address);
        write_boxes(&memory, is_valid);
        fixture_finish(&fixture, commands);
        expect_told(is_valid ? NULL : "minX");
        memory_destroy(&second);
        memory_free(&memory);
        close_scene();
    }
    platform.null_driver.configure(NULL);
}

int main(int argc, char **argv)
{
    const char *reason = platform_open(&platform, argc > 1 ? argv[1] : "lavapipe");
    if (reason) {
        puts(reason);
        return 77;
    }
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_changes),
        cmocka_unit_test(test_submits_again),
        cmocka_unit_test(test_in_secondary),
    };
    const struct CMUnitTest mistakes[] = {
        cmocka_unit_test(test_replaced_by_smaller),
        cmocka_unit_test(test_nothing_is_there),
    };
    const struct CMUnitTest of_the_null_driver[] = {
        cmocka_unit_test(test_on_other_memory),
    };
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    if (platform.is_null || platform.is_cpu)
        failed += cmocka_run_group_tests(mistakes, NULL, NULL);
    return platform.is_null ? failed + cmocka_run_group_tests(of_the_null_driver, NULL, NULL)
                            : failed;
}
