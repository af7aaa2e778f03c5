/* SPDX-License-Identifier: Apache-2.0 */
/* Instances behind pointers, which dispatches of the layer's own copy: not where that would be
 * counted or could be left out, and from memory as it is when the command buffer is submitted. */
#include "tests/snapshots/fixture.h"

#include <stdio.h>
#include <string.h>

enum {
    STRUCTURE_SIZE = 1 << 16,
    SCRATCH_SIZE = 1 << 16,
    INSTANCE_SIZE = sizeof(VkAccelerationStructureInstanceKHR),
};

static struct platform platform;
static struct fixture fixture;
static struct fixture_buffer boxes, structures, scratch, pointers, instance;
static VkAccelerationStructureKHR blas, tlas;

static struct fixture_buffer create_input(VkDeviceSize size)
{
    return fixture_buffer(&fixture, size,
                          VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR);
}

/* Whose transform has no inverse, which a rule of the contents finds. */
static void write_instance(const struct fixture_buffer *buffer, bool is_valid)
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
    memcpy(buffer->bytes, &written, sizeof(written));
    memcpy(pointers.bytes, &buffer->address, sizeof(buffer->address));
}

static void build_top(VkCommandBuffer commands)
{
    const VkAccelerationStructureGeometryKHR geometry = {
        .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_KHR,
        .geometryType = VK_GEOMETRY_TYPE_INSTANCES_KHR,
        .geometry.instances = {
            .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_INSTANCES_DATA_KHR,
            .arrayOfPointers = VK_TRUE,
            .data.deviceAddress = pointers.address,
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

static int open_fixture(void **state)
{
    (void)state;
    fixture_open(&fixture, &platform, &(struct fixture_setup){.has_layer = true});
    boxes = create_input(sizeof(VkAabbPositionsKHR));
    pointers = create_input(sizeof(uint64_t));
    instance = create_input(INSTANCE_SIZE);
    structures = fixture_buffer(&fixture, 2 * STRUCTURE_SIZE,
                                VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_STORAGE_BIT_KHR);
    scratch = fixture_buffer(&fixture, SCRATCH_SIZE, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT);
    blas = fixture_structure(&fixture, &structures, 0, STRUCTURE_SIZE,
                             VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR);
    tlas = fixture_structure(&fixture, &structures, STRUCTURE_SIZE, STRUCTURE_SIZE,
                             VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR);
    VkCommandBuffer commands = fixture_begin(&fixture, 0);
    fixture_build_boxes(&fixture, commands, blas, boxes.address, 1,
                        (scratch.address + 255) & ~(VkDeviceAddress)255);
    fixture_finish(&fixture, commands);
    fixture_expect_silence(&fixture);
    return 0;
}

static int close_fixture(void **state)
{
    (void)state;
    fixture.vk.DestroyAccelerationStructureKHR(fixture.device, blas, NULL);
    fixture.vk.DestroyAccelerationStructureKHR(fixture.device, tlas, NULL);
    fixture_destroy_buffer(&fixture, &boxes);
    fixture_destroy_buffer(&fixture, &pointers);
    fixture_destroy_buffer(&fixture, &instance);
    fixture_destroy_buffer(&fixture, &structures);
    fixture_destroy_buffer(&fixture, &scratch);
    fixture_close(&fixture);
    return 0;
}

/* One message, which says this; it is forgotten. */
static void expect_told(const char *text)
{
    if (fixture.messages.count != 1)
        fail_msg("%u messages: %s", fixture.messages.count, fixture.messages.items[0].text);
    if (!strstr(fixture.messages.items[0].text, text))
        fail_msg("\"%s\" is not in: %s", text, fixture.messages.items[0].text);
    messages_clear(&fixture.messages);
}

/* ---- tests */

static void test_gathers(void **state)
{
    (void)state;
    write_instance(&instance, false);
    VkCommandBuffer commands = fixture_begin(&fixture, 0);
    build_top(commands);
    fixture_finish(&fixture, commands);
    expect_told("transform");
}

/* Builds within a query, and returns the query's value. */
static uint64_t build_within_query(const VkQueryPoolCreateInfo *info)
{
    VkQueryPool queries;
    uint64_t value = 1;
    GET(fixture.vk.CreateQueryPool(fixture.device, info, NULL, &queries));
    write_instance(&instance, false);
    VkCommandBuffer commands = fixture_begin(&fixture, 0);
    fixture.vk.CmdResetQueryPool(commands, queries, 0, 1);
    fixture.vk.CmdBeginQuery(commands, queries, 0, 0);
    fixture_barrier(&fixture, commands);
    build_top(commands);
    fixture.vk.CmdEndQuery(commands, queries, 0);
    fixture_finish(&fixture, commands);
    GET(fixture.vk.GetQueryPoolResults(fixture.device, queries, 0, 1, sizeof(value), &value,
                                       sizeof(value), VK_QUERY_RESULT_64_BIT));
    fixture.vk.DestroyQueryPool(fixture.device, queries, NULL);
    return value;
}

/* The layer's dispatch would count. */
static void test_counts_nothing(void **state)
{
    (void)state;
    const VkQueryPoolCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO,
        .queryType = VK_QUERY_TYPE_PIPELINE_STATISTICS,
        .queryCount = 1,
        .pipelineStatistics = VK_QUERY_PIPELINE_STATISTIC_COMPUTE_SHADER_INVOCATIONS_BIT,
    };
    assert_int_equal(build_within_query(&info), 0);
    expect_told("build 0 (no place for copies)");
}

/* Queries that count other work than that of compute shaders. */
static void test_counts_no_dispatch(void **state)
{
    (void)state;
    VkQueryPoolCreateInfo info = {.sType = VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO,
                                  .queryType = VK_QUERY_TYPE_OCCLUSION,
                                  .queryCount = 1};
    assert_int_equal(build_within_query(&info), 0);
    expect_told("transform");
    info.queryType = VK_QUERY_TYPE_PIPELINE_STATISTICS;
    info.pipelineStatistics = VK_QUERY_PIPELINE_STATISTIC_VERTEX_SHADER_INVOCATIONS_BIT;
    assert_int_equal(build_within_query(&info), 0);
    expect_told("transform");
}

/* A condition would leave the dispatch out, so the layer ends it before, and begins it again
 * after. snapshots_memory records dispatches of the application there. */
static void test_follows_no_condition(void **state)
{
    (void)state;
    if (!fixture.has_conditional_rendering)
        skip();
    struct fixture_buffer condition =
        fixture_buffer(&fixture, 4, VK_BUFFER_USAGE_CONDITIONAL_RENDERING_BIT_EXT);
    const VkConditionalRenderingBeginInfoEXT begin = {
        .sType = VK_STRUCTURE_TYPE_CONDITIONAL_RENDERING_BEGIN_INFO_EXT,
        .buffer = condition.handle,
    };
    write_instance(&instance, false);
    VkCommandBuffer commands = fixture_begin(&fixture, 0);
    fixture.vk.CmdBeginConditionalRenderingEXT(commands, &begin);
    build_top(commands);
    fixture.vk.CmdEndConditionalRenderingEXT(commands);
    fixture_finish(&fixture, commands);
    expect_told("transform");
    commands = fixture_begin(&fixture, 0);
    fixture.vk.CmdBeginConditionalRenderingEXT(commands, &begin);
    fixture.vk.CmdEndConditionalRenderingEXT(commands);
    build_top(commands);
    fixture_finish(&fixture, commands);
    expect_told("transform");
    fixture_destroy_buffer(&fixture, &condition);
}

/* In a secondary command buffer of which `inheritance` says what may be active where it executes.
 */
static void build_in_secondary(const VkCommandBufferInheritanceInfo *inheritance)
{
    const VkCommandBufferAllocateInfo info = {
        .sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
        .commandPool = fixture.pool,
        .level = VK_COMMAND_BUFFER_LEVEL_SECONDARY,
        .commandBufferCount = 1,
    };
    const VkCommandBufferBeginInfo begin = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO,
                                            .pInheritanceInfo = inheritance};
    VkCommandBuffer secondary, commands = fixture_begin(&fixture, 0);
    GET(fixture.vk.AllocateCommandBuffers(fixture.device, &info, &secondary));
    GET(fixture.vk.BeginCommandBuffer(secondary, &begin));
    build_top(secondary);
    GET(fixture.vk.EndCommandBuffer(secondary));
    fixture.vk.CmdExecuteCommands(commands, 1, &secondary);
    fixture_finish(&fixture, commands);
    fixture.vk.FreeCommandBuffers(fixture.device, fixture.pool, 1, &secondary);
}

/* What is inherited only the null driver is told of, which takes anything. */
static void test_inherits_nothing(void **state)
{
    (void)state;
    VkCommandBufferInheritanceConditionalRenderingInfoEXT condition = {
        .sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_INHERITANCE_CONDITIONAL_RENDERING_INFO_EXT,
    };
    VkCommandBufferInheritanceInfo inheritance = {
        .sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_INHERITANCE_INFO,
        .pNext = &condition,
    };
    write_instance(&instance, false);
    build_in_secondary(&inheritance);
    expect_told("transform");
    if (!platform.is_null)
        return;
    inheritance.pipelineStatistics = VK_QUERY_PIPELINE_STATISTIC_VERTEX_SHADER_INVOCATIONS_BIT;
    build_in_secondary(&inheritance);
    expect_told("transform");
    inheritance.pipelineStatistics = VK_QUERY_PIPELINE_STATISTIC_COMPUTE_SHADER_INVOCATIONS_BIT;
    build_in_secondary(&inheritance);
    expect_told("build 0 (no place for copies)");
    inheritance.pipelineStatistics = 0;
    condition.conditionalRenderingEnable = VK_TRUE;
    build_in_secondary(&inheritance);
    expect_told("build 0 (no place for copies)");
}

/* Memory that wasn't there when the command buffer was recorded. */
static void test_later_memory(void **state)
{
    (void)state;
    VkCommandBuffer commands = fixture_begin(&fixture, 0);
    build_top(commands);
    struct fixture_buffer later = create_input(INSTANCE_SIZE);
    write_instance(&later, false);
    fixture_finish(&fixture, commands);
    expect_told("transform");
    commands = fixture_begin(&fixture, 0);
    build_top(commands);
    write_instance(&instance, true);
    fixture_destroy_buffer(&fixture, &later);
    fixture_finish(&fixture, commands);
    fixture_expect_silence(&fixture);
}

int main(int argc, char **argv)
{
    const char *reason = platform_open(&platform, argc > 1 ? argv[1] : "lavapipe");
    if (reason) {
        puts(reason);
        return 77;
    }
    const struct CMUnitTest of_the_null_driver[] = {
        cmocka_unit_test_setup_teardown(test_gathers, open_fixture, close_fixture),
        cmocka_unit_test_setup_teardown(test_inherits_nothing, open_fixture, close_fixture),
        cmocka_unit_test_setup_teardown(test_later_memory, open_fixture, close_fixture),
    };
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_gathers, open_fixture, close_fixture),
        cmocka_unit_test_setup_teardown(test_counts_nothing, open_fixture, close_fixture),
        cmocka_unit_test_setup_teardown(test_counts_no_dispatch, open_fixture, close_fixture),
        cmocka_unit_test_setup_teardown(test_follows_no_condition, open_fixture, close_fixture),
        cmocka_unit_test_setup_teardown(test_inherits_nothing, open_fixture, close_fixture),
        cmocka_unit_test_setup_teardown(test_later_memory, open_fixture, close_fixture),
    };
    return platform.is_null ? cmocka_run_group_tests(of_the_null_driver, NULL, NULL)
                            : cmocka_run_group_tests(tests, NULL, NULL);
}
