/* SPDX-License-Identifier: Apache-2.0 */
/* A driver that completes submissions and executes nothing: what its builds read is not known, and
 * one warning says so. */
#include "tests/snapshots/scene.h"

#include "tests/fixture/trace.h"

enum { BUFFER_SIZE = 1 << 16 };

static struct device_buffer instances;

static void open_scene(const char *level, bool is_valid)
{
    SCENE_OPEN(.settings.level = level, .boxes_size = BUFFER_SIZE, .structure_size = BUFFER_SIZE,
               .has_tlas = true);
    instances = scene_input(BUFFER_SIZE);
    scene_write_instance(&instances, is_valid);
}

static VkCommandBuffer record(void)
{
    VkCommandBuffer commands = scene_record_boxes(0, 1);
    scene_build_instance(commands, instances.address, false);
    GET(fixture.vk.EndCommandBuffer(commands));
    return commands;
}

static void run(VkCommandBuffer commands)
{
    GET(fixture_submit(&fixture, commands, VK_NULL_HANDLE));
    GET(fixture.vk.QueueWaitIdle(fixture.queue));
}

/* Memory that nobody has written would be an instance whose transform has no inverse. */
TEST(test_warns_once)
{
    platform.null_driver.set_executes_nothing(true);
    open_scene("content", true);
    VkCommandBuffer commands = record(), others = record();
    run(commands);
    expect_messages(1, "without executing the commands that copy");
    run(commands);
    run(others);
    fixture_expect_silence(&fixture);
    scene_close();
}

/* What the device wrote for one execution says nothing of the next one. */
TEST(test_marks_are_of_one_execution)
{
    platform.null_driver.set_executes_nothing(false);
    open_scene("content", false);
    VkCommandBuffer commands = record();
    run(commands);
    expect_messages(1, "transform");
    platform.null_driver.set_executes_nothing(true);
    run(commands);
    expect_messages(1, "without executing the commands that copy");
    platform.null_driver.set_executes_nothing(false);
    run(commands);
    expect_messages(1, "transform");
    scene_close();
}

/* Where no rule looks at the data, the backend says so when a structure is asked for. */
TEST(test_backend_warns)
{
    if (!platform.is_cpu)
        skip();
    platform.null_driver.set_executes_nothing(true);
    open_scene("execution", true);
    run(record());
    fixture_expect_silence(&fixture);
    PFN_vkTraceRaysASSAY trace = (PFN_vkTraceRaysASSAY)fixture.instance.get_device_proc_addr(
        fixture.device, "vkTraceRaysASSAY");
    const AssayRay ray = {.direction = {1, 0, 0}, .tMax = 1};
    AssayHit hit;
    const AssayTraceInfo info =
        trace_info((uint64_t)scene.tlas, ASSAY_ACCURACY_FAST, 1, &ray, &hit);
    assert_non_null(trace);
    assert_int_not_equal(trace(fixture.device, &info), VK_SUCCESS);
    expect_messages(1, "backend = cpu can't build");
    scene_close();
}
