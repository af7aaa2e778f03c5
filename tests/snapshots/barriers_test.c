/* SPDX-License-Identifier: Apache-2.0 */
/* The barriers that level content adds to a command buffer, as docs/levels.md lists them. On the
 * null driver, which keeps what it gets. */
#include "tests/snapshots/scene.h"

enum {
    BUILDS = VK_PIPELINE_STAGE_ACCELERATION_STRUCTURE_BUILD_BIT_KHR,
    COMPUTE = VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT,
    TRANSFER = VK_PIPELINE_STAGE_TRANSFER_BIT,
    HOST = VK_PIPELINE_STAGE_HOST_BIT,
    SHADER_READ = VK_ACCESS_SHADER_READ_BIT,
    SHADER_WRITE = VK_ACCESS_SHADER_WRITE_BIT,
    TRANSFER_WRITE = VK_ACCESS_TRANSFER_WRITE_BIT,
    BARRIERS_MAX = 64,
};

/* BEHIND: behind the build. OWN: of a buffer that the application did not create. */
enum { BEHIND = 1, OWN = 2 };

struct expected {
    VkPipelineStageFlags src, dst;
    VkAccessFlags src_access, dst_access;
    int flags;
};

/* What each call has: the copies see what the build would see, the host sees the copies, and later
 * builds wait for them. */
static const struct expected start = {BUILDS, COMPUTE, 0, SHADER_READ, 0};
static const struct expected show = {COMPUTE, HOST, SHADER_WRITE, VK_ACCESS_HOST_READ_BIT, OWN};
static const struct expected end = {COMPUTE, BUILDS, 0, 0, BEHIND};

static struct device_buffer instances;

static void open_with(const struct instance_settings *settings)
{
    SCENE_OPEN(.settings = *settings, .boxes_size = 64, .structure_size = 4096, .has_tlas = true);
    instances = scene_input(sizeof(VkAccelerationStructureInstanceKHR));
    scene_write_instance(&instances, true);
}

#define OPEN(...) open_with(&(struct instance_settings){__VA_ARGS__})

static bool is_of_application(VkBuffer buffer)
{
    for (uint32_t i = 0; i < fixture.buffer_count; i++)
        if (fixture.buffers[i].handle == buffer)
            return true;
    return false;
}

static void expect_barrier(const struct null_driver_barrier *barrier,
                           const struct expected *expected)
{
    assert_int_equal(barrier->src, expected->src);
    assert_int_equal(barrier->dst, expected->dst);
    assert_int_equal(barrier->src_access, expected->src_access);
    assert_int_equal(barrier->dst_access, expected->dst_access);
    assert_int_equal(barrier->builds, expected->flags & BEHIND ? 1 : 0);
    assert_int_equal(barrier->buffer != VK_NULL_HANDLE, expected->flags & OWN ? 1 : 0);
    assert_false(is_of_application(barrier->buffer));
}

/* Records a build of the TLAS. */
static void expect_of_build(VkCommandBufferUsageFlags usage, bool is_pointer, uint32_t count,
                            const struct expected *const *expected)
{
    struct null_driver_barrier barriers[BARRIERS_MAX];
    VkCommandBuffer commands = fixture_begin(&fixture, usage);
    platform.null_driver.reset();
    platform.null_driver.take_barriers(barriers, BARRIERS_MAX);
    scene_build_instance(commands, instances.address, is_pointer);
    assert_int_equal(platform.null_driver.take_barriers(barriers, BARRIERS_MAX), count);
    for (uint32_t i = 0; i < count; i++)
        expect_barrier(&barriers[i], expected[i]);
    GET(fixture.vk.EndCommandBuffer(commands));
    scene_close();
}

#define EXPECT_OF_BUILD(usage, is_pointer, ...)                                                    \
    expect_of_build(usage, is_pointer,                                                             \
                    sizeof((const struct expected *[]){__VA_ARGS__}) / sizeof(void *),             \
                    (const struct expected *[]){__VA_ARGS__})

TEST(test_level_execution)
{
    OPEN(.level = "execution");
    expect_of_build(0, false, 0, NULL);
}

TEST(test_level_content)
{
    OPEN(.level = "content");
    EXPECT_OF_BUILD(0, false, &start, &show, &end);
}

/* Executions of one command buffer write to the same memory. */
TEST(test_several_executions_at_once)
{
    static const struct expected repeated = {BUILDS | COMPUTE | TRANSFER, COMPUTE | TRANSFER,
                                             SHADER_WRITE | TRANSFER_WRITE,
                                             SHADER_READ | SHADER_WRITE | TRANSFER_WRITE, 0};
    OPEN(.level = "content");
    EXPECT_OF_BUILD(VK_COMMAND_BUFFER_USAGE_SIMULTANEOUS_USE_BIT, false, &repeated, &show, &end);
}

/* The pointers are copied, and then what they point to. */
TEST(test_pointers)
{
    static const struct expected gathered = {COMPUTE, COMPUTE, SHADER_WRITE, SHADER_READ, OWN};
    OPEN(.level = "content");
    EXPECT_OF_BUILD(0, true, &start, &gathered, &show, &end);
}

/* The build itself reads what the layer wrote. */
TEST(test_guard)
{
    static const struct expected guarded = {COMPUTE, BUILDS, SHADER_WRITE,
                                            VK_ACCESS_MEMORY_READ_BIT, OWN};
    OPEN(.level = "content", .guard = "references");
    EXPECT_OF_BUILD(0, false, &start, &show, &guarded, &end);
}

/* No build reaches the driver. */
TEST(test_backend_cpu)
{
    static const struct expected first = {
        VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, COMPUTE | TRANSFER, VK_ACCESS_MEMORY_WRITE_BIT,
        VK_ACCESS_TRANSFER_READ_BIT | TRANSFER_WRITE | SHADER_READ | SHADER_WRITE, 0};
    static const struct expected last = {COMPUTE | TRANSFER,
                                         VK_PIPELINE_STAGE_ALL_COMMANDS_BIT | HOST,
                                         SHADER_WRITE | TRANSFER_WRITE, VK_ACCESS_HOST_READ_BIT, 0};
    OPEN(.level = "content", .backend = "cpu");
    EXPECT_OF_BUILD(0, false, &first, &last);
}
