/* SPDX-License-Identifier: Apache-2.0 */
/* Instances behind pointers, which dispatches of the layer's own copy: not where that would be
 * counted or could be left out, and from memory as it is when the command buffer is submitted. */
#include "stage.h"

#include <stdio.h>
#include <string.h>

enum {
    STRUCTURE_SIZE = 1 << 16,
    SCRATCH_SIZE = 1 << 16,
    INSTANCE_SIZE = sizeof(VkAccelerationStructureInstanceKHR),
};

static struct platform platform;
static struct stage stage;
static struct stage_buffer boxes, structures, scratch, pointers, instance;
static VkAccelerationStructureKHR blas, tlas;

static struct stage_buffer create_input(VkDeviceSize size)
{
    return stage_buffer(&stage, size,
                        VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR);
}

/* Whose transform has no inverse, which a rule of the contents finds. */
static void write_instance(const struct stage_buffer *buffer, bool is_valid)
{
    const VkAccelerationStructureDeviceAddressInfoKHR info = {
        .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_DEVICE_ADDRESS_INFO_KHR,
        .accelerationStructure = blas,
    };
    VkAccelerationStructureInstanceKHR written = {
        .mask = 0xff,
        .accelerationStructureReference =
            stage.vk.GetAccelerationStructureDeviceAddressKHR(stage.device, &info),
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
    stage.vk.CmdBuildAccelerationStructuresKHR(commands, 1, &info, &ranges);
}

static int open_stage(void **state)
{
    (void)state;
    stage_open(&stage, &platform, &(struct stage_setup){.has_layer = true});
    boxes = create_input(sizeof(VkAabbPositionsKHR));
    pointers = create_input(sizeof(uint64_t));
    instance = create_input(INSTANCE_SIZE);
    structures = stage_buffer(&stage, 2 * STRUCTURE_SIZE,
                              VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_STORAGE_BIT_KHR);
    scratch = stage_buffer(&stage, SCRATCH_SIZE, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT);
    blas = stage_structure(&stage, &structures, 0, STRUCTURE_SIZE,
                           VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR);
    tlas = stage_structure(&stage, &structures, STRUCTURE_SIZE, STRUCTURE_SIZE,
                           VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR);
    VkCommandBuffer commands = stage_begin(&stage, 0);
    stage_build_boxes(&stage, commands, blas, boxes.address, 1,
                      (scratch.address + 255) & ~(VkDeviceAddress)255);
    stage_finish(&stage, commands);
    stage_expect_silence(&stage);
    return 0;
}

static int close_stage(void **state)
{
    (void)state;
    stage.vk.DestroyAccelerationStructureKHR(stage.device, blas, NULL);
    stage.vk.DestroyAccelerationStructureKHR(stage.device, tlas, NULL);
    stage_destroy_buffer(&stage, &boxes);
    stage_destroy_buffer(&stage, &pointers);
    stage_destroy_buffer(&stage, &instance);
    stage_destroy_buffer(&stage, &structures);
    stage_destroy_buffer(&stage, &scratch);
    stage_close(&stage);
    return 0;
}

/* One message, which says this; it is forgotten. */
static void expect_told(const char *text)
{
    if (stage.messages.count != 1)
        fail_msg("%u messages: %s", stage.messages.count, stage.messages.items[0].text);
    if (!strstr(stage.messages.items[0].text, text))
        fail_msg("\"%s\" is not in: %s", text, stage.messages.items[0].text);
    messages_clear(&stage.messages);
}

/* ---- tests */

static void test_gathers(void **state)
{
    (void)state;
    write_instance(&instance, false);
    VkCommandBuffer commands = stage_begin(&stage, 0);
    build_top(commands);
    stage_finish(&stage, commands);
    expect_told("transform");
}

/* Builds within a query, and returns the query's value. */
static uint64_t build_within_query(const VkQueryPoolCreateInfo *info)
{
    VkQueryPool queries;
    uint64_t value = 1;
    GET(stage.vk.CreateQueryPool(stage.device, info, NULL, &queries));
    write_instance(&instance, false);
    VkCommandBuffer commands = stage_begin(&stage, 0);
    stage.vk.CmdResetQueryPool(commands, queries, 0, 1);
    stage.vk.CmdBeginQuery(commands, queries, 0, 0);
    stage_barrier(&stage, commands);
    build_top(commands);
    stage.vk.CmdEndQuery(commands, queries, 0);
    stage_finish(&stage, commands);
    GET(stage.vk.GetQueryPoolResults(stage.device, queries, 0, 1, sizeof(value), &value,
                                     sizeof(value), VK_QUERY_RESULT_64_BIT));
    stage.vk.DestroyQueryPool(stage.device, queries, NULL);
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
    if (!stage.has_conditional_rendering)
        skip();
    struct stage_buffer condition =
        stage_buffer(&stage, 4, VK_BUFFER_USAGE_CONDITIONAL_RENDERING_BIT_EXT);
    const VkConditionalRenderingBeginInfoEXT begin = {
        .sType = VK_STRUCTURE_TYPE_CONDITIONAL_RENDERING_BEGIN_INFO_EXT,
        .buffer = condition.handle,
    };
    write_instance(&instance, false);
    VkCommandBuffer commands = stage_begin(&stage, 0);
    stage.vk.CmdBeginConditionalRenderingEXT(commands, &begin);
    build_top(commands);
    stage.vk.CmdEndConditionalRenderingEXT(commands);
    stage_finish(&stage, commands);
    expect_told("transform");
    commands = stage_begin(&stage, 0);
    stage.vk.CmdBeginConditionalRenderingEXT(commands, &begin);
    stage.vk.CmdEndConditionalRenderingEXT(commands);
    build_top(commands);
    stage_finish(&stage, commands);
    expect_told("transform");
    stage_destroy_buffer(&stage, &condition);
}

/* In a secondary command buffer of which `inheritance` says what may be active where it executes.
 */
static void build_in_secondary(const VkCommandBufferInheritanceInfo *inheritance)
{
    const VkCommandBufferAllocateInfo info = {
        .sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
        .commandPool = stage.pool,
        .level = VK_COMMAND_BUFFER_LEVEL_SECONDARY,
        .commandBufferCount = 1,
    };
    const VkCommandBufferBeginInfo begin = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO,
                                            .pInheritanceInfo = inheritance};
    VkCommandBuffer secondary, commands = stage_begin(&stage, 0);
    GET(stage.vk.AllocateCommandBuffers(stage.device, &info, &secondary));
    GET(stage.vk.BeginCommandBuffer(secondary, &begin));
    build_top(secondary);
    GET(stage.vk.EndCommandBuffer(secondary));
    stage.vk.CmdExecuteCommands(commands, 1, &secondary);
    stage_finish(&stage, commands);
    stage.vk.FreeCommandBuffers(stage.device, stage.pool, 1, &secondary);
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
    VkCommandBuffer commands = stage_begin(&stage, 0);
    build_top(commands);
    struct stage_buffer later = create_input(INSTANCE_SIZE);
    write_instance(&later, false);
    stage_finish(&stage, commands);
    expect_told("transform");
    commands = stage_begin(&stage, 0);
    build_top(commands);
    write_instance(&instance, true);
    stage_destroy_buffer(&stage, &later);
    stage_finish(&stage, commands);
    stage_expect_silence(&stage);
}

int main(int argc, char **argv)
{
    const char *reason = platform_open(&platform, argc > 1 ? argv[1] : "lavapipe");
    if (reason) {
        puts(reason);
        return 77;
    }
    const struct CMUnitTest of_the_null_driver[] = {
        cmocka_unit_test_setup_teardown(test_gathers, open_stage, close_stage),
        cmocka_unit_test_setup_teardown(test_inherits_nothing, open_stage, close_stage),
        cmocka_unit_test_setup_teardown(test_later_memory, open_stage, close_stage),
    };
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_gathers, open_stage, close_stage),
        cmocka_unit_test_setup_teardown(test_counts_nothing, open_stage, close_stage),
        cmocka_unit_test_setup_teardown(test_counts_no_dispatch, open_stage, close_stage),
        cmocka_unit_test_setup_teardown(test_follows_no_condition, open_stage, close_stage),
        cmocka_unit_test_setup_teardown(test_inherits_nothing, open_stage, close_stage),
        cmocka_unit_test_setup_teardown(test_later_memory, open_stage, close_stage),
    };
    return platform.is_null ? cmocka_run_group_tests(of_the_null_driver, NULL, NULL)
                            : cmocka_run_group_tests(tests, NULL, NULL);
}
