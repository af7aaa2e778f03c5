/* SPDX-License-Identifier: Apache-2.0 */
/* Updates by command buffers and by the host, mixed: each is measured by the data that its source
 * was last built with when it executes, whoever built it, however often its command buffer runs. */
#include <math.h>
#include <stdlib.h>

#include "device_fixture.h"

enum { TRIANGLES = 3, FLOATS = 9 };

#define DEVICE "VUID-vkCmdBuildAccelerationStructuresKHR-pInfos-"
#define HOST "VUID-vkBuildAccelerationStructuresKHR-pInfos-"
#define WOKEN "03663"
#define PUT_TO_SLEEP "03664"

/* Three triangles, two structures for them, and commands that build from copies of their data. */
static struct fixture_build host;
static struct device_build build;
static struct fixture_structure blas, other;
static VkCommandBuffer commands[2];

static void open_scene(void)
{
    fixture_triangles(&host, TRIANGLES, UPDATABLE);
    blas = fixture_create_for(&host);
    other = fixture_create_blas(blas.size);
    device_build_create(&host, &build);
    for (int i = 0; i < 2; i++)
        commands[i] = device_begin(PRIMARY);
    messages_clear(messages);
}

static void close_scene(void)
{
    vk.DeviceWaitIdle(device);
    vk.FreeCommandBuffers(device, command_pool, 2, commands);
    destroy_all();
}

/* Before the instance is there. */
__attribute__((constructor)) static void choose_level(void)
{
    setenv("VK_ASSAY_VALIDATION_LEVEL", "content", 1);
}

#define SCENE_TEST(name) TEST_BETWEEN(name, open_scene, close_scene)

/* Makes the second triangle inactive or active, in the host's data or in data that commands copy.
 */
static void set_asleep(void *data, bool is_asleep)
{
    ((float *)data)[FLOATS] = is_asleep ? NAN : 1;
}

static void record(int i, VkAccelerationStructureKHR src)
{
    device_upload(commands[i], &build);
    device_build(commands[i], &build, blas.handle, src);
}

static void run(int i)
{
    device_end(commands[i]);
    device_run(commands[i]);
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
    GET(host_build(&host, blas.handle, src));
}

static void submit(int i)
{
    GET(commands_submit(&vk, queue, commands[i], VK_NULL_HANDLE));
}

/* Behind the data that is copied, by the command itself. */
static void update_with_a_sleeping_triangle(int i, VkAccelerationStructureKHR src)
{
    const float asleep = NAN;
    vk.CmdUpdateBuffer(commands[i], build.data.handle, FLOATS * sizeof(float), sizeof(asleep),
                       &asleep);
    device_barrier(commands[i]);
    device_build(commands[i], &build, blas.handle, src);
}

/* ---- tests */

SCENE_TEST(test_built_by_the_host)
{
    build_by_the_host(VK_NULL_HANDLE);
    set_asleep(host.data, true);
    record(0, blas.handle);
    expect(NULL);
    run(0);
    expect(DEVICE PUT_TO_SLEEP);
}

SCENE_TEST(test_updated_by_the_host)
{
    set_asleep(host.data, true);
    record(0, VK_NULL_HANDLE);
    run(0);
    expect(NULL);
    build_by_the_host(blas.handle);
    expect(NULL);
    set_asleep(host.data, false);
    host_build(&host, blas.handle, blas.handle);
    expect(HOST WOKEN);
}

SCENE_TEST(test_in_one_command_buffer)
{
    record(0, VK_NULL_HANDLE);
    update_with_a_sleeping_triangle(0, blas.handle);
    expect(NULL);
    run(0);
    expect(DEVICE PUT_TO_SLEEP);
    device_run(commands[0]);
    expect(DEVICE PUT_TO_SLEEP);
}

/* What was last built counts, not what was last updated. */
SCENE_TEST(test_updated_twice)
{
    record(0, VK_NULL_HANDLE);
    run(0);
    set_asleep(host.data, true);
    record(1, blas.handle);
    run(1);
    expect(DEVICE PUT_TO_SLEEP);
    device_run(commands[1]);
    expect(DEVICE PUT_TO_SLEEP);
    set_asleep(build.staging.bytes, false);
    device_run(commands[1]);
    expect(NULL);
}

/* Each execution of the build has data of its own. */
SCENE_TEST(test_built_again_with_other_data)
{
    record(0, VK_NULL_HANDLE);
    record(1, blas.handle);
    run(0);
    run(1);
    expect(NULL);
    set_asleep(build.staging.bytes, true);
    device_run(commands[0]);
    device_run(commands[1]);
    expect(NULL);
    set_asleep(build.staging.bytes, false);
    device_run(commands[1]);
    expect(DEVICE WOKEN);
    device_run(commands[0]);
    device_run(commands[1]);
    expect(NULL);
}

static void record_clone(void)
{
    device_copy(commands[0], blas.handle, other.handle, CLONE);
    device_barrier(commands[0]);
}

/* A clone was built with what its source was built with then. */
SCENE_TEST(test_cloned)
{
    record(0, VK_NULL_HANDLE);
    record_clone();
    run(0);
    set_asleep(host.data, true);
    build_by_the_host(VK_NULL_HANDLE);
    record(1, blas.handle);
    record(1, other.handle);
    run(1);
    expect(DEVICE PUT_TO_SLEEP);
}

/* The host does not wait in between. */
SCENE_TEST(test_all_at_once)
{
    record(0, VK_NULL_HANDLE);
    record_clone();
    update_with_a_sleeping_triangle(1, other.handle);
    for (int i = 0; i < 2; i++)
        device_end(commands[i]);
    submit(0);
    submit(1);
    vk.QueueWaitIdle(queue);
    expect(DEVICE PUT_TO_SLEEP);
}

/* How many primitives an indirect build had is known when its ranges were read. */
SCENE_TEST(test_built_indirectly)
{
    static const char id[] = "VUID-vkCmdBuildAccelerationStructuresKHR-primitiveCount-03769";
    device_upload(commands[0], &build);
    build.info.dstAccelerationStructure = blas.handle;
    const struct device_buffer range =
        device_build_indirect(commands[0], &build.info, TRIANGLES, &host.range);
    run(0);
    record(1, blas.handle);
    run(1);
    expect(NULL);
    ((VkAccelerationStructureBuildRangeInfoKHR *)(range.bytes + RANGE_AT))->primitiveCount =
        TRIANGLES - 1;
    device_run(commands[0]);
    device_run(commands[1]);
    assert_int_equal(messages->count, 1);
    assert_int_equal(messages_count(messages, id, "has primitiveCount 3"), 1);
}

/* What an application destroys it knows to be complete, however it came to know. */
/* The layer looks for the end of a submission only when the application has observed it. */
SCENE_TEST(test_told_at_the_wait)
{
    record(0, VK_NULL_HANDLE);
    run(0);
    set_asleep(host.data, true);
    record(1, blas.handle);
    device_end(commands[1]);
    submit(1);
    struct fixture_structure passing = fixture_create_blas(blas.size);
    destroy((uint64_t)passing.handle);
    destroy((uint64_t)passing.storage.handle);
    destroy((uint64_t)passing.storage.memory);
    expect(NULL);
    GET(vk.QueueWaitIdle(queue));
    expect(DEVICE PUT_TO_SLEEP);
}
