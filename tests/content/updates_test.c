/* SPDX-License-Identifier: Apache-2.0 */
/* Updates by command buffers and by the host, mixed: each is measured by the data that its source
 * was last built with when it executes, whoever built it, however often its command buffer runs. */
#include <math.h>
#include <stdlib.h>
#include <time.h>

#include "device_fixture.h"
#include "tests/fixture/make.h"
#include "tests/state/unit_test.h"

enum { TRIANGLES = 3, FLOATS = 9, DATA_SIZE = TRIANGLES * FLOATS * sizeof(float) };

#define DEVICE "VUID-vkCmdBuildAccelerationStructuresKHR-pInfos-"
#define HOST "VUID-vkBuildAccelerationStructuresKHR-pInfos-"
#define WOKEN "03663"
#define PUT_TO_SLEEP "03664"

/* Three triangles, two structures for them, and commands that build from copies of their data. */
static struct {
    struct fixture_build host;
    struct device_build build;
    struct fixture_structure blas, other;
    VkCommandBuffer commands[2];
} scene;

static void open_scene(void)
{
    fixture_triangles(&scene.host, TRIANGLES, VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_UPDATE_BIT_KHR);
    scene.blas = fixture_create_for(&scene.host);
    scene.other = fixture_create(VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR, scene.blas.size);
    device_build_create(&scene.host, DATA_SIZE, &scene.build);
    for (int i = 0; i < 2; i++)
        scene.commands[i] = device_begin(VK_COMMAND_BUFFER_LEVEL_PRIMARY);
    messages_clear(messages);
}

static void close_scene(void)
{
    vk.DeviceWaitIdle(device);
    vk.FreeCommandBuffers(device, command_pool, 2, scene.commands);
    destroy_all();
}

/* Before the instance is there. */
__attribute__((constructor)) static void choose_level(void)
{
    setenv("VK_ASSAY_VALIDATION_LEVEL", "content", 1);
}

#define SCENE_TEST(name) TEST_BETWEEN(name, open_scene, close_scene)

/* Of the second triangle; in the host's data, or in what is copied when commands run. */
static void set_asleep(void *data, bool is_asleep)
{
    ((float *)data)[FLOATS] = is_asleep ? NAN : 1;
}

static void record(int commands, VkAccelerationStructureKHR src)
{
    device_upload(scene.commands[commands], &scene.build);
    device_build(scene.commands[commands], &scene.build, scene.blas.handle, src);
}

static void run(int commands)
{
    device_end(scene.commands[commands]);
    device_run(scene.commands[commands]);
}

/* What came since the last time: one message, or none. */
static void expect(const char *id)
{
    if (messages->count != (id != NULL) || (id && !messages_count(messages, id, "primitive 1")))
        for (uint32_t i = 0; i < messages_kept(messages); i++)
            print_error("%s\n", messages->items[i].text);
    assert_int_equal(messages->count, id != NULL);
    assert_true(!id || messages_count(messages, id, "primitive 1"));
    messages_clear(messages);
}

static void build_by_the_host(VkAccelerationStructureKHR src)
{
    assert_int_equal(fixture_build(VK_NULL_HANDLE, &scene.host, scene.blas.handle, src),
                     VK_SUCCESS);
}

static void submit(int commands)
{
    const VkSubmitInfo info = {.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO,
                               .commandBufferCount = 1,
                               .pCommandBuffers = &scene.commands[commands]};
    assert_int_equal(vk.QueueSubmit(queue, 1, &info, VK_NULL_HANDLE), VK_SUCCESS);
}

/* Behind the data that is copied, by the command itself. */
static void update_with_a_sleeping_triangle(int commands, VkAccelerationStructureKHR src)
{
    const float asleep = NAN;
    vk.CmdUpdateBuffer(scene.commands[commands], scene.build.data.handle, FLOATS * sizeof(float),
                       sizeof(asleep), &asleep);
    device_barrier(scene.commands[commands]);
    device_build(scene.commands[commands], &scene.build, scene.blas.handle, src);
}

/* ---- tests */

SCENE_TEST(test_built_by_the_host)
{
    build_by_the_host(VK_NULL_HANDLE);
    set_asleep(scene.host.data, true);
    record(0, scene.blas.handle);
    expect(NULL);
    run(0);
    expect(DEVICE PUT_TO_SLEEP);
}

SCENE_TEST(test_updated_by_the_host)
{
    set_asleep(scene.host.data, true);
    record(0, VK_NULL_HANDLE);
    run(0);
    expect(NULL);
    build_by_the_host(scene.blas.handle);
    expect(NULL);
    set_asleep(scene.host.data, false);
    fixture_build(VK_NULL_HANDLE, &scene.host, scene.blas.handle, scene.blas.handle);
    expect(HOST WOKEN);
}

SCENE_TEST(test_in_one_command_buffer)
{
    record(0, VK_NULL_HANDLE);
    update_with_a_sleeping_triangle(0, scene.blas.handle);
    expect(NULL);
    run(0);
    expect(DEVICE PUT_TO_SLEEP);
    device_run(scene.commands[0]);
    expect(DEVICE PUT_TO_SLEEP);
}

/* What was last built counts, not what was last updated. */
SCENE_TEST(test_updated_twice)
{
    record(0, VK_NULL_HANDLE);
    run(0);
    set_asleep(scene.host.data, true);
    record(1, scene.blas.handle);
    run(1);
    expect(DEVICE PUT_TO_SLEEP);
    device_run(scene.commands[1]);
    expect(DEVICE PUT_TO_SLEEP);
    set_asleep(scene.build.staging.bytes, false);
    device_run(scene.commands[1]);
    expect(NULL);
}

/* Each execution of the build has data of its own. */
SCENE_TEST(test_built_again_with_other_data)
{
    record(0, VK_NULL_HANDLE);
    record(1, scene.blas.handle);
    run(0);
    run(1);
    expect(NULL);
    set_asleep(scene.build.staging.bytes, true);
    device_run(scene.commands[0]);
    device_run(scene.commands[1]);
    expect(NULL);
    set_asleep(scene.build.staging.bytes, false);
    device_run(scene.commands[1]);
    expect(DEVICE WOKEN);
    device_run(scene.commands[0]);
    device_run(scene.commands[1]);
    expect(NULL);
}

static void copy(VkCommandBuffer commands)
{
    const VkCopyAccelerationStructureInfoKHR info = {
        .sType = VK_STRUCTURE_TYPE_COPY_ACCELERATION_STRUCTURE_INFO_KHR,
        .src = scene.blas.handle,
        .dst = scene.other.handle,
        .mode = VK_COPY_ACCELERATION_STRUCTURE_MODE_CLONE_KHR,
    };
    vk.CmdCopyAccelerationStructureKHR(commands, &info);
    device_barrier(commands);
}

/* A clone was built with what its source was built with then. */
SCENE_TEST(test_cloned)
{
    record(0, VK_NULL_HANDLE);
    copy(scene.commands[0]);
    run(0);
    set_asleep(scene.host.data, true);
    build_by_the_host(VK_NULL_HANDLE);
    record(1, scene.blas.handle);
    record(1, scene.other.handle);
    run(1);
    expect(DEVICE PUT_TO_SLEEP);
}

/* Nobody waits in between. */
SCENE_TEST(test_all_at_once)
{
    record(0, VK_NULL_HANDLE);
    copy(scene.commands[0]);
    update_with_a_sleeping_triangle(1, scene.other.handle);
    for (int i = 0; i < 2; i++)
        device_end(scene.commands[i]);
    submit(0);
    submit(1);
    vk.QueueWaitIdle(queue);
    expect(DEVICE PUT_TO_SLEEP);
}

/* How many primitives an indirect build had is known when its ranges were read. */
SCENE_TEST(test_built_indirectly)
{
    static const char id[] = "VUID-vkCmdBuildAccelerationStructuresKHR-primitiveCount-03769";
    const uint32_t most = TRIANGLES, stride = sizeof(VkAccelerationStructureBuildRangeInfoKHR);
    const uint32_t *const counts = &most;
    struct device_buffer range = device_buffer_create(stride);
    *(VkAccelerationStructureBuildRangeInfoKHR *)range.bytes =
        (VkAccelerationStructureBuildRangeInfoKHR){.primitiveCount = TRIANGLES};
    device_upload(scene.commands[0], &scene.build);
    scene.build.info.mode = VK_BUILD_ACCELERATION_STRUCTURE_MODE_BUILD_KHR;
    scene.build.info.dstAccelerationStructure = scene.blas.handle;
    vk.CmdBuildAccelerationStructuresIndirectKHR(scene.commands[0], 1, &scene.build.info,
                                                 &range.address, &stride, &counts);
    device_barrier(scene.commands[0]);
    run(0);
    record(1, scene.blas.handle);
    run(1);
    expect(NULL);
    ((VkAccelerationStructureBuildRangeInfoKHR *)range.bytes)->primitiveCount = TRIANGLES - 1;
    device_run(scene.commands[0]);
    device_run(scene.commands[1]);
    assert_int_equal(messages->count, 1);
    assert_int_equal(messages_count(messages, id, "has primitiveCount 3"), 1);
}

/* What an application destroys it knows to be complete, however it came to know. */
SCENE_TEST(test_told_at_destruction)
{
    static const struct timespec pause = {.tv_nsec = 10 * 1000 * 1000};
    record(0, VK_NULL_HANDLE);
    run(0);
    set_asleep(scene.host.data, true);
    record(1, scene.blas.handle);
    device_end(scene.commands[1]);
    submit(1);
    /* Two minutes at least: a busy machine may take long to complete the submission. */
    for (int i = 0; i < 12000 && !messages->count; i++) {
        nanosleep(&pause, NULL);
        struct fixture_structure other =
            fixture_create(VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR, scene.blas.size);
        fixture_destroy(&other);
    }
    expect(DEVICE PUT_TO_SLEEP);
}
