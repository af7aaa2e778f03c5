/* SPDX-License-Identifier: Apache-2.0 */
/* Instances behind pointers, which dispatches of the layer's own copy: not where that would be
 * counted or could be left out, and from memory as it is when the command buffer is submitted. */
#include "tests/snapshots/scene.h"

#include <string.h>

enum {
    STRUCTURE_SIZE = 1 << 16,
    INSTANCE_SIZE = sizeof(VkAccelerationStructureInstanceKHR),
};

static struct device_buffer pointers, instance;

static void write_instance(const struct device_buffer *buffer, bool is_valid)
{
    scene_write_instance(buffer, is_valid);
    memcpy(pointers.bytes, &buffer->address, sizeof(buffer->address));
}

static void build_top(VkCommandBuffer commands)
{
    scene_build_instance(commands, pointers.address, true);
}

static void open_scene_at(const char *level)
{
    SCENE_OPEN(.settings.level = level, .boxes_size = sizeof(VkAabbPositionsKHR),
               .structure_size = STRUCTURE_SIZE, .has_tlas = true);
    pointers = scene_input(sizeof(uint64_t));
    instance = scene_input(INSTANCE_SIZE);
    VkCommandBuffer commands = scene_record_boxes(0, 1);
    fixture_finish(&fixture, commands);
    fixture_expect_silence(&fixture);
}

static void open_scene(void)
{
    open_scene_at("content");
}

SCENE_TEST(test_gathers)
{
    write_instance(&instance, false);
    VkCommandBuffer commands = fixture_begin(&fixture, 0);
    build_top(commands);
    fixture_finish(&fixture, commands);
    expect_messages(1, "transform");
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

/* What the null driver, which counts nothing and has no conditions, can't show. */
#define DEVICE_TEST(name) TEST_BETWEEN_IF(name, open_scene, scene_close, !platform.is_null)

/* The layer's dispatch would count. Those of the driver do. */
DEVICE_TEST(test_counts_nothing)
{
    const STRUCT(VkQueryPoolCreateInfo, info, .queryType = VK_QUERY_TYPE_PIPELINE_STATISTICS,
                 .queryCount = 1,
                 .pipelineStatistics = VK_QUERY_PIPELINE_STATISTIC_COMPUTE_SHADER_INVOCATIONS_BIT);
    scene_close();
    open_scene_at("execution");
    const uint64_t of_driver = build_within_query(&info);
    scene_close();
    open_scene();
    assert_int_equal(build_within_query(&info), of_driver);
    expect_messages(1, "build 0 (no place for copies)");
}

/* Queries that count other work than that of compute shaders. */
DEVICE_TEST(test_counts_no_dispatch)
{
    STRUCT(VkQueryPoolCreateInfo, info, .queryType = VK_QUERY_TYPE_OCCLUSION, .queryCount = 1);
    assert_int_equal(build_within_query(&info), 0);
    expect_messages(1, "transform");
    info.queryType = VK_QUERY_TYPE_PIPELINE_STATISTICS;
    info.pipelineStatistics = VK_QUERY_PIPELINE_STATISTIC_VERTEX_SHADER_INVOCATIONS_BIT;
    assert_int_equal(build_within_query(&info), 0);
    expect_messages(1, "transform");
}

/* A condition would leave the dispatch out, so the layer ends it before, and begins it again
 * after. snapshots_memory records dispatches of the application there. */
DEVICE_TEST(test_follows_no_condition)
{
    if (!instance_fixture_has_conditions(&fixture.instance))
        skip();
    struct device_buffer condition =
        fixture_buffer(&fixture, 4, VK_BUFFER_USAGE_CONDITIONAL_RENDERING_BIT_EXT);
    const STRUCT(VkConditionalRenderingBeginInfoEXT, begin, .buffer = condition.handle);
    write_instance(&instance, false);
    VkCommandBuffer commands = fixture_begin(&fixture, 0);
    fixture.vk.CmdBeginConditionalRenderingEXT(commands, &begin);
    build_top(commands);
    fixture.vk.CmdEndConditionalRenderingEXT(commands);
    fixture_finish(&fixture, commands);
    expect_messages(1, "transform");
    commands = fixture_begin(&fixture, 0);
    fixture.vk.CmdBeginConditionalRenderingEXT(commands, &begin);
    fixture.vk.CmdEndConditionalRenderingEXT(commands);
    build_top(commands);
    fixture_finish(&fixture, commands);
    expect_messages(1, "transform");
    fixture_destroy_buffer(&fixture, &condition);
}

/* In a secondary command buffer of which `inheritance` says what may be active where it executes.
 */
static void build_in_secondary(const VkCommandBufferInheritanceInfo *inheritance)
{
    VkCommandBuffer secondary = commands_begin(&fixture.vk, fixture.device, fixture.pool,
                                               VK_COMMAND_BUFFER_LEVEL_SECONDARY, 0, inheritance);
    VkCommandBuffer commands = fixture_begin(&fixture, 0);
    build_top(secondary);
    GET(fixture.vk.EndCommandBuffer(secondary));
    fixture.vk.CmdExecuteCommands(commands, 1, &secondary);
    fixture_finish(&fixture, commands);
    fixture.vk.FreeCommandBuffers(fixture.device, fixture.pool, 1, &secondary);
}

/* What is inherited only the null driver is told of, which takes anything. */
SCENE_TEST(test_inherits_nothing)
{
    STRUCT(VkCommandBufferInheritanceConditionalRenderingInfoEXT, condition);
    STRUCT(VkCommandBufferInheritanceInfo, inheritance, .pNext = &condition);
    write_instance(&instance, false);
    build_in_secondary(&inheritance);
    expect_messages(1, "transform");
    if (!platform.is_null)
        return;
    inheritance.pipelineStatistics = VK_QUERY_PIPELINE_STATISTIC_VERTEX_SHADER_INVOCATIONS_BIT;
    build_in_secondary(&inheritance);
    expect_messages(1, "transform");
    inheritance.pipelineStatistics = VK_QUERY_PIPELINE_STATISTIC_COMPUTE_SHADER_INVOCATIONS_BIT;
    build_in_secondary(&inheritance);
    expect_messages(1, "build 0 (no place for copies)");
    inheritance.pipelineStatistics = 0;
    condition.conditionalRenderingEnable = VK_TRUE;
    build_in_secondary(&inheritance);
    expect_messages(1, "build 0 (no place for copies)");
}

/* Memory that wasn't there when the command buffer was recorded. */
SCENE_TEST(test_later_memory)
{
    VkCommandBuffer commands = fixture_begin(&fixture, 0);
    build_top(commands);
    struct device_buffer later = scene_input(INSTANCE_SIZE);
    write_instance(&later, false);
    fixture_finish(&fixture, commands);
    expect_messages(1, "transform");
    commands = fixture_begin(&fixture, 0);
    build_top(commands);
    write_instance(&instance, true);
    fixture_destroy_buffer(&fixture, &later);
    fixture_finish(&fixture, commands);
    fixture_expect_silence(&fixture);
}
