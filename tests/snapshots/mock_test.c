/* SPDX-License-Identifier: Apache-2.0 */
/* A driver that completes submissions and executes nothing: what its builds read is not known, and
 * one warning says so. */
#include "tests/snapshots/fixture.h"

#include <stdio.h>
#include <string.h>

#include "layer/assay.h"

enum { BUFFER_SIZE = 1 << 16 };

static struct platform platform;
static struct fixture fixture;
static struct fixture_buffer boxes, structures, scratch, instances;
static VkAccelerationStructureKHR blas, tlas;

static void open_fixture(const char *level)
{
    const VkBufferUsageFlags input =
        VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR;
    fixture_open(&fixture, &platform, &(struct fixture_setup){.has_layer = true, .level = level});
    boxes = fixture_buffer(&fixture, BUFFER_SIZE, input);
    instances = fixture_buffer(&fixture, BUFFER_SIZE, input);
    structures = fixture_buffer(&fixture, 2 * BUFFER_SIZE,
                                VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_STORAGE_BIT_KHR);
    scratch = fixture_buffer(&fixture, BUFFER_SIZE, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT);
    blas = fixture_structure(&fixture, &structures, 0, BUFFER_SIZE,
                             VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR);
    tlas = fixture_structure(&fixture, &structures, BUFFER_SIZE, BUFFER_SIZE,
                             VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR);
}

static void close_fixture(void)
{
    fixture.vk.DestroyAccelerationStructureKHR(fixture.device, blas, NULL);
    fixture.vk.DestroyAccelerationStructureKHR(fixture.device, tlas, NULL);
    fixture_destroy_buffer(&fixture, &boxes);
    fixture_destroy_buffer(&fixture, &instances);
    fixture_destroy_buffer(&fixture, &structures);
    fixture_destroy_buffer(&fixture, &scratch);
    fixture_close(&fixture);
}

static void write_instance(bool is_valid)
{
    const VkAccelerationStructureDeviceAddressInfoKHR info = {
        .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_DEVICE_ADDRESS_INFO_KHR,
        .accelerationStructure = blas,
    };
    VkAccelerationStructureInstanceKHR written = {
        .mask = 0xff,
        .accelerationStructureReference =
            fixture.vk.GetAccelerationStructureDeviceAddressKHR(fixture.device, &info),
    };
    for (int i = 0; i < 3; i++)
        written.transform.matrix[i][i] = is_valid ? 1 : 0;
    memcpy(instances.bytes, &written, sizeof(written));
}

static void build_top(VkCommandBuffer commands)
{
    const VkAccelerationStructureGeometryKHR geometry = {
        .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_KHR,
        .geometryType = VK_GEOMETRY_TYPE_INSTANCES_KHR,
        .geometry.instances = {
            .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_INSTANCES_DATA_KHR,
            .data.deviceAddress = instances.address,
        }};
    const VkAccelerationStructureBuildGeometryInfoKHR info = {
        .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_BUILD_GEOMETRY_INFO_KHR,
        .type = VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR,
        .dstAccelerationStructure = tlas,
        .geometryCount = 1,
        .pGeometries = &geometry,
        .scratchData.deviceAddress = (scratch.address + 255) & ~(VkDeviceAddress)255,
    };
    const VkAccelerationStructureBuildRangeInfoKHR range = {.primitiveCount = 1}, *ranges = &range;
    fixture.vk.CmdBuildAccelerationStructuresKHR(commands, 1, &info, &ranges);
}

static VkCommandBuffer record(void)
{
    VkCommandBuffer commands = fixture_begin(&fixture, 0);
    fixture_build_boxes(&fixture, commands, blas, boxes.address, 1,
                        (scratch.address + 255) & ~(VkDeviceAddress)255);
    fixture_barrier(&fixture, commands);
    build_top(commands);
    GET(fixture.vk.EndCommandBuffer(commands));
    return commands;
}

static void run(VkCommandBuffer commands)
{
    GET(fixture_submit(&fixture, commands, VK_NULL_HANDLE));
    GET(fixture.vk.QueueWaitIdle(fixture.queue));
}

/* One message with the text; it is forgotten. */
static void expect_told(const char *text)
{
    if (fixture.messages.count != 1)
        fail_msg("%u messages: %s", fixture.messages.count, fixture.messages.items[0].text);
    if (!strstr(fixture.messages.items[0].text, text))
        fail_msg("\"%s\" is not in: %s", text, fixture.messages.items[0].text);
    messages_clear(&fixture.messages);
}

/* ---- tests */

/* Memory that nobody has written would be an instance whose transform has no inverse. */
static void test_warns_once(void **state)
{
    (void)state;
    platform.null_driver.set_executes_nothing(true);
    open_fixture("content");
    write_instance(true);
    VkCommandBuffer commands = record(), others = record();
    run(commands);
    expect_told("without executing the commands that copy");
    run(commands);
    run(others);
    fixture_expect_silence(&fixture);
    close_fixture();
}

/* What the device wrote for one execution says nothing of the next one. */
static void test_marks_are_of_one_execution(void **state)
{
    (void)state;
    platform.null_driver.set_executes_nothing(false);
    open_fixture("content");
    write_instance(false);
    VkCommandBuffer commands = record();
    run(commands);
    expect_told("transform");
    platform.null_driver.set_executes_nothing(true);
    run(commands);
    expect_told("without executing the commands that copy");
    platform.null_driver.set_executes_nothing(false);
    run(commands);
    expect_told("transform");
    close_fixture();
}

/* Where no rule looks at the data, the backend says so when a structure is asked for. */
static void test_backend_warns(void **state)
{
    (void)state;
    if (!platform.is_cpu)
        skip();
    platform.null_driver.set_executes_nothing(true);
    open_fixture("execution");
    write_instance(true);
    run(record());
    fixture_expect_silence(&fixture);
    PFN_vkTraceRaysASSAY trace =
        (PFN_vkTraceRaysASSAY)fixture.get_device_proc_addr(fixture.device, "vkTraceRaysASSAY");
    const AssayRay ray = {.direction = {1, 0, 0}, .tMax = 1};
    AssayHit hit;
    const AssayTraceInfo info = {.accelerationStructure = (uint64_t)tlas,
                                 .rayCount = 1,
                                 .raySize = sizeof(ray),
                                 .hitSize = sizeof(hit),
                                 .rays = &ray,
                                 .hits = &hit};
    assert_non_null(trace);
    assert_int_not_equal(trace(fixture.device, &info), VK_SUCCESS);
    expect_told("backend = cpu can't build");
    close_fixture();
}

int main(int argc, char **argv)
{
    const char *reason = platform_open(&platform, argc > 1 ? argv[1] : "null");
    if (reason) {
        puts(reason);
        return 77;
    }
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_warns_once),
        cmocka_unit_test(test_marks_are_of_one_execution),
        cmocka_unit_test(test_backend_warns),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
