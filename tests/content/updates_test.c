/* SPDX-License-Identifier: Apache-2.0 */
/* Updates by command buffers and by the host, mixed: each is measured by the data that its source
 * was last built with when it executes, whoever built it, however often its command buffer runs. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "device_fixture.h"

static struct device_fixture device;
static struct fixture *const fixture = &device.fixture;

enum { TRIANGLES = 3, FLOATS = 9, DATA_SIZE = TRIANGLES * FLOATS * sizeof(float) };

#define DEVICE "VUID-vkCmdBuildAccelerationStructuresKHR-pInfos-"
#define HOST "VUID-vkBuildAccelerationStructuresKHR-pInfos-"
#define WOKEN "03663"
#define PUT_TO_SLEEP "03664"

/* Three triangles, two structures for them, and commands that build from copies of their data. */
struct scene {
    struct fixture_build host;
    struct device_build build;
    struct fixture_structure blas, other;
    VkCommandBuffer commands[2];
};

static void open_scene(struct scene *scene)
{
    fixture_triangles(&scene->host, TRIANGLES,
                      VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_UPDATE_BIT_KHR);
    scene->blas = fixture_create_for(fixture, &scene->host);
    scene->other =
        fixture_create(fixture, VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR, scene->blas.size);
    device_build_create(&device, &scene->host, DATA_SIZE, &scene->build);
    for (int i = 0; i < 2; i++)
        scene->commands[i] = device_begin(&device, VK_COMMAND_BUFFER_LEVEL_PRIMARY);
    messages_clear(&fixture->instance_fixture.messages);
}

static void close_scene(struct scene *scene)
{
    fixture->vk.DeviceWaitIdle(fixture->device);
    fixture->vk.FreeCommandBuffers(fixture->device, device.pool, 2, scene->commands);
    device_build_destroy(&device, &scene->build);
    fixture_destroy(fixture, &scene->other);
    fixture_destroy(fixture, &scene->blas);
    fixture_free(&scene->host);
}

/* Of the second triangle; in the host's data, or in what is copied when commands run. */
static void set_asleep(void *data, bool is_asleep)
{
    ((float *)data)[FLOATS] = is_asleep ? NAN : 1;
}

static void record(struct scene *scene, int commands, VkAccelerationStructureKHR src)
{
    device_upload(&device, scene->commands[commands], &scene->build);
    device_build(&device, scene->commands[commands], &scene->build, scene->blas.handle, src);
}

static void run(struct scene *scene, int commands)
{
    device_end(&device, scene->commands[commands]);
    device_run(&device, scene->commands[commands]);
}

/* What came since the last time: one message, or none. */
static void expect(const char *id)
{
    struct messages *messages = &fixture->instance_fixture.messages;
    if (messages->count != (id != NULL) || (id && !messages_count(messages, id, "primitive 1")))
        for (uint32_t i = 0; i < messages_kept(messages); i++)
            print_error("%s\n", messages->items[i].text);
    assert_int_equal(messages->count, id != NULL);
    assert_true(!id || messages_count(messages, id, "primitive 1"));
    messages_clear(messages);
}

/* ---- tests */

static void test_built_by_the_host(void **state)
{
    struct scene scene;
    (void)state;
    open_scene(&scene);
    assert_int_equal(
        fixture_build(fixture, VK_NULL_HANDLE, &scene.host, scene.blas.handle, VK_NULL_HANDLE),
        VK_SUCCESS);
    set_asleep(scene.host.data, true);
    record(&scene, 0, scene.blas.handle);
    expect(NULL);
    run(&scene, 0);
    expect(DEVICE PUT_TO_SLEEP);
    close_scene(&scene);
}

static void test_updated_by_the_host(void **state)
{
    struct scene scene;
    (void)state;
    open_scene(&scene);
    set_asleep(scene.host.data, true);
    record(&scene, 0, VK_NULL_HANDLE);
    run(&scene, 0);
    expect(NULL);
    assert_int_equal(
        fixture_build(fixture, VK_NULL_HANDLE, &scene.host, scene.blas.handle, scene.blas.handle),
        VK_SUCCESS);
    expect(NULL);
    set_asleep(scene.host.data, false);
    fixture_build(fixture, VK_NULL_HANDLE, &scene.host, scene.blas.handle, scene.blas.handle);
    expect(HOST WOKEN);
    close_scene(&scene);
}

static void test_in_one_command_buffer(void **state)
{
    struct scene scene;
    (void)state;
    open_scene(&scene);
    const float asleep = NAN;
    record(&scene, 0, VK_NULL_HANDLE);
    fixture->vk.CmdUpdateBuffer(scene.commands[0], scene.build.data.handle, FLOATS * sizeof(float),
                                sizeof(asleep), &asleep);
    device_barrier(&device, scene.commands[0]);
    device_build(&device, scene.commands[0], &scene.build, scene.blas.handle, scene.blas.handle);
    expect(NULL);
    run(&scene, 0);
    expect(DEVICE PUT_TO_SLEEP);
    device_run(&device, scene.commands[0]);
    expect(DEVICE PUT_TO_SLEEP);
    close_scene(&scene);
}

/* What was last built counts, not what was last updated. */
static void test_updated_twice(void **state)
{
    struct scene scene;
    (void)state;
    open_scene(&scene);
    record(&scene, 0, VK_NULL_HANDLE);
    run(&scene, 0);
    set_asleep(scene.host.data, true);
    record(&scene, 1, scene.blas.handle);
    run(&scene, 1);
    expect(DEVICE PUT_TO_SLEEP);
    device_run(&device, scene.commands[1]);
    expect(DEVICE PUT_TO_SLEEP);
    set_asleep(scene.build.staging.bytes, false);
    device_run(&device, scene.commands[1]);
    expect(NULL);
    close_scene(&scene);
}

/* Each execution of the build has data of its own. */
static void test_built_again_with_other_data(void **state)
{
    struct scene scene;
    (void)state;
    open_scene(&scene);
    record(&scene, 0, VK_NULL_HANDLE);
    record(&scene, 1, scene.blas.handle);
    run(&scene, 0);
    run(&scene, 1);
    expect(NULL);
    set_asleep(scene.build.staging.bytes, true);
    device_run(&device, scene.commands[0]);
    device_run(&device, scene.commands[1]);
    expect(NULL);
    set_asleep(scene.build.staging.bytes, false);
    device_run(&device, scene.commands[1]);
    expect(DEVICE WOKEN);
    device_run(&device, scene.commands[0]);
    device_run(&device, scene.commands[1]);
    expect(NULL);
    close_scene(&scene);
}

static void copy(struct scene *scene, VkCommandBuffer commands)
{
    const VkCopyAccelerationStructureInfoKHR info = {
        .sType = VK_STRUCTURE_TYPE_COPY_ACCELERATION_STRUCTURE_INFO_KHR,
        .src = scene->blas.handle,
        .dst = scene->other.handle,
        .mode = VK_COPY_ACCELERATION_STRUCTURE_MODE_CLONE_KHR,
    };
    fixture->vk.CmdCopyAccelerationStructureKHR(commands, &info);
    device_barrier(&device, commands);
}

/* A clone was built with what its source was built with then. */
static void test_cloned(void **state)
{
    struct scene scene;
    (void)state;
    open_scene(&scene);
    record(&scene, 0, VK_NULL_HANDLE);
    copy(&scene, scene.commands[0]);
    run(&scene, 0);
    set_asleep(scene.host.data, true);
    assert_int_equal(
        fixture_build(fixture, VK_NULL_HANDLE, &scene.host, scene.blas.handle, VK_NULL_HANDLE),
        VK_SUCCESS);
    record(&scene, 1, scene.blas.handle);
    record(&scene, 1, scene.other.handle);
    run(&scene, 1);
    expect(DEVICE PUT_TO_SLEEP);
    close_scene(&scene);
}

/* Nobody waits in between. */
static void test_all_at_once(void **state)
{
    struct scene scene;
    (void)state;
    open_scene(&scene);
    record(&scene, 0, VK_NULL_HANDLE);
    copy(&scene, scene.commands[0]);
    const float asleep = NAN;
    fixture->vk.CmdUpdateBuffer(scene.commands[1], scene.build.data.handle, FLOATS * sizeof(float),
                                sizeof(asleep), &asleep);
    device_barrier(&device, scene.commands[1]);
    device_build(&device, scene.commands[1], &scene.build, scene.blas.handle, scene.other.handle);
    for (int i = 0; i < 2; i++)
        device_end(&device, scene.commands[i]);
    for (int i = 0; i < 2; i++) {
        const VkSubmitInfo submit = {.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO,
                                     .commandBufferCount = 1,
                                     .pCommandBuffers = &scene.commands[i]};
        assert_int_equal(fixture->vk.QueueSubmit(device.queue, 1, &submit, VK_NULL_HANDLE),
                         VK_SUCCESS);
    }
    fixture->vk.QueueWaitIdle(device.queue);
    expect(DEVICE PUT_TO_SLEEP);
    close_scene(&scene);
}

/* How many primitives an indirect build had is known when its ranges were read. */
static void test_built_indirectly(void **state)
{
    static const char id[] = "VUID-vkCmdBuildAccelerationStructuresKHR-primitiveCount-03769";
    const struct messages *messages = &fixture->instance_fixture.messages;
    const uint32_t most = TRIANGLES, stride = sizeof(VkAccelerationStructureBuildRangeInfoKHR);
    const uint32_t *const counts = &most;
    struct scene scene;
    (void)state;
    open_scene(&scene);
    struct device_buffer range = device_buffer_create(&device, stride);
    *(VkAccelerationStructureBuildRangeInfoKHR *)range.bytes =
        (VkAccelerationStructureBuildRangeInfoKHR){.primitiveCount = TRIANGLES};
    device_upload(&device, scene.commands[0], &scene.build);
    scene.build.info.mode = VK_BUILD_ACCELERATION_STRUCTURE_MODE_BUILD_KHR;
    scene.build.info.dstAccelerationStructure = scene.blas.handle;
    fixture->vk.CmdBuildAccelerationStructuresIndirectKHR(scene.commands[0], 1, &scene.build.info,
                                                          &range.address, &stride, &counts);
    device_barrier(&device, scene.commands[0]);
    run(&scene, 0);
    record(&scene, 1, scene.blas.handle);
    run(&scene, 1);
    expect(NULL);
    ((VkAccelerationStructureBuildRangeInfoKHR *)range.bytes)->primitiveCount = TRIANGLES - 1;
    device_run(&device, scene.commands[0]);
    device_run(&device, scene.commands[1]);
    assert_int_equal(messages->count, 1);
    assert_int_equal(messages_count(messages, id, "has primitiveCount 3"), 1);
    device_buffer_destroy(&device, &range);
    close_scene(&scene);
}

/* What an application destroys it knows to be complete, however it came to know. */
static void test_told_at_destruction(void **state)
{
    static const struct timespec pause = {.tv_nsec = 10 * 1000 * 1000};
    struct scene scene;
    (void)state;
    open_scene(&scene);
    record(&scene, 0, VK_NULL_HANDLE);
    run(&scene, 0);
    set_asleep(scene.host.data, true);
    record(&scene, 1, scene.blas.handle);
    device_end(&device, scene.commands[1]);
    const VkSubmitInfo submit = {.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO,
                                 .commandBufferCount = 1,
                                 .pCommandBuffers = &scene.commands[1]};
    assert_int_equal(fixture->vk.QueueSubmit(device.queue, 1, &submit, VK_NULL_HANDLE), VK_SUCCESS);
    /* Two minutes at least: a busy machine may take long to complete the submission. */
    for (int i = 0; i < 12000 && !fixture->instance_fixture.messages.count; i++) {
        nanosleep(&pause, NULL);
        struct fixture_structure other = fixture_create(
            fixture, VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR, scene.blas.size);
        fixture_destroy(fixture, &other);
    }
    expect(DEVICE PUT_TO_SLEEP);
    close_scene(&scene);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_built_by_the_host),
        cmocka_unit_test(test_updated_by_the_host),
        cmocka_unit_test(test_in_one_command_buffer),
        cmocka_unit_test(test_updated_twice),
        cmocka_unit_test(test_built_again_with_other_data),
        cmocka_unit_test(test_cloned),
        cmocka_unit_test(test_all_at_once),
        cmocka_unit_test(test_built_indirectly),
        cmocka_unit_test(test_told_at_destruction),
    };
    setenv("VK_ASSAY_VALIDATION_LEVEL", "content", 1);
    const char *reason = argc == 2 ? device_fixture_open(&device, argv[1]) : "name a platform";
    if (reason) {
        printf("skipped: %s\n", reason);
        return 77;
    }
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    device_fixture_close(&device);
    return failed;
}
