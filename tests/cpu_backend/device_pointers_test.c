/* SPDX-License-Identifier: Apache-2.0 */
/* Arrays of pointers in builds of command buffers on backend cpu, through the loader: instances are
 * gathered at that point of the command buffer, and what the application has bound stays bound. */
#include "device_fixture.h"

#include <string.h>

static const uint32_t fill_code[] = {
#include "fill_comp.h"
};

/* ---- four pointers to instances that lie apart: the second, null, the first, and a wild one */

enum { COUNT = 4, APART = 128 };

static struct {
    struct fixture_build triangles, pairs;
    struct fixture_structure blas, tlas;
    struct device_build build;
    struct device_buffer instances, pointers;
} scene;

static void open_scene(void)
{
    fixture_triangles(&scene.triangles, 1, 0);
    scene.blas = fixture_create_for(&scene.triangles);
    GET(fixture_build(VK_NULL_HANDLE, &scene.triangles, scene.blas.handle, VK_NULL_HANDLE));
    const VkAccelerationStructureKHR blases[] = {scene.blas.handle, scene.blas.handle};
    fixture_instances(&scene.pairs, blases, 2, 0);
    scene.pairs.range.primitiveCount = COUNT;
    scene.tlas = fixture_create_for(&scene.pairs);
    device_build_create(&scene.pairs, 1, &scene.build);
    scene.instances = device_buffer_create(COUNT * APART);
    scene.pointers = device_buffer_create(COUNT * sizeof(uint64_t));
    const VkAccelerationStructureInstanceKHR *from = scene.pairs.data;
    const uint64_t pointers[COUNT] = {scene.instances.address + APART, 0,
                                      scene.instances.address + 2 * APART, 0x123450};
    memcpy(scene.instances.bytes + 2 * APART, &from[0], sizeof(from[0]));
    memcpy(scene.instances.bytes + APART, &from[1], sizeof(from[1]));
    memcpy(scene.pointers.bytes, pointers, sizeof(pointers));
    scene.build.geometry.geometry.instances.arrayOfPointers = VK_TRUE;
    scene.build.geometry.geometry.instances.data.deviceAddress = scene.pointers.address;
}

static void expect_instances(void)
{
    const AssayHit upper = fixture_trace(scene.tlas.handle, 2.25f, 0.25f);
    const AssayHit lower = fixture_trace(scene.tlas.handle, 0.25f, 0.25f);
    assert_true(upper.isHit && lower.isHit);
    assert_int_equal(upper.instance, 0);
    assert_int_equal(upper.customIndex, 101);
    assert_int_equal(lower.instance, 2);
    assert_int_equal(lower.customIndex, 100);
}

/* ---- tests */

TEST_BETWEEN(test_gathered, open_scene, close_noisy_test)
{
    VkCommandBuffer commands = device_begin(PRIMARY);
    device_build(commands, &scene.build, scene.tlas.handle, VK_NULL_HANDLE);
    device_finish(commands);
    memset(scene.instances.bytes, 0, COUNT * APART); /* too late to matter */
    expect_instances();
    /* Content tells of the null pointer and the wild one, where it is asked. */
}

TEST_BETWEEN(test_gathered_by_indirect_build, open_scene, close_noisy_test)
{
    struct device_buffer range = device_buffer_create(64);
    const VkAccelerationStructureBuildRangeInfoKHR two = {.primitiveCount = 2,
                                                          .primitiveOffset = 2 * sizeof(uint64_t)};
    const uint32_t stride = sizeof(two), most = COUNT;
    const uint32_t *const maxima = &most;
    memcpy(range.bytes, &two, sizeof(two));
    VkCommandBuffer commands = device_begin(PRIMARY);
    scene.build.info.dstAccelerationStructure = scene.tlas.handle;
    vk.CmdBuildAccelerationStructuresIndirectKHR(commands, 1, &scene.build.info, &range.address,
                                                 &stride, &maxima);
    device_finish(commands);
    const AssayHit lower = fixture_trace(scene.tlas.handle, 0.25f, 0.25f);
    assert_true(lower.isHit);
    assert_int_equal(lower.instance, 0);
    assert_int_equal(lower.customIndex, 100);
    assert_false(fixture_trace(scene.tlas.handle, 2.25f, 0.25f).isHit);
}

/* ---- a pipeline of the application's own */

struct constants {
    VkDeviceAddress target;
    uint32_t value;
};

enum { CONSTANTS_AT = 16 };

struct fill {
    VkPipelineLayout layout;
    VkPipeline pipeline;
};

static struct fill create_fill(void)
{
    struct fill fill = {
        constants_layout_create(&vk, device, CONSTANTS_AT, sizeof(struct constants))};
    fill.pipeline = compute_pipeline_create(&vk, device, fill.layout, fill_code, sizeof(fill_code));
    OWN(DestroyPipelineLayout, fill.layout);
    OWN(DestroyPipeline, fill.pipeline);
    return fill;
}

TEST_BETWEEN(test_bound_state_stays, open_scene, close_noisy_test)
{
    const struct fill fill = create_fill();
    struct device_buffer target = device_buffer_create(4);
    const struct constants constants = {target.address, 0xabcdef};
    VkCommandBuffer commands = device_begin(PRIMARY);
    vk.CmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, fill.pipeline);
    vk.CmdPushConstants(commands, fill.layout, VK_SHADER_STAGE_COMPUTE_BIT, CONSTANTS_AT,
                        sizeof(constants), &constants);
    device_build(commands, &scene.build, scene.tlas.handle, VK_NULL_HANDLE);
    vk.CmdDispatch(commands, 1, 1, 1);
    device_finish(commands);
    assert_int_equal(*(uint32_t *)target.bytes, constants.value);
    expect_instances();
}

/* Builds follow no condition, and so what gathers for them must not; all else does. */
TEST_BETWEEN(test_condition_stays, open_scene, close_noisy_test)
{
    if (!instance_fixture_has_conditions(&instance))
        skip();
    const struct fill fill = create_fill();
    struct device_buffer condition = device_buffer_create(16), target = device_buffer_create(4);
    const STRUCT(VkConditionalRenderingBeginInfoEXT, begin, .buffer = condition.handle, .offset = 8,
                 .flags = VK_CONDITIONAL_RENDERING_INVERTED_BIT_EXT);
    const struct constants constants = {target.address, 0xabcdef};
    memset(condition.bytes, 0, 16);
    memset(condition.bytes + 8, 0xff, 4);
    memset(target.bytes, 0, 4);
    VkCommandBuffer commands = device_begin(PRIMARY);
    vk.CmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, fill.pipeline);
    vk.CmdPushConstants(commands, fill.layout, VK_SHADER_STAGE_COMPUTE_BIT, CONSTANTS_AT,
                        sizeof(constants), &constants);
    vk.CmdBeginConditionalRenderingEXT(commands, &begin);
    device_build(commands, &scene.build, scene.tlas.handle, VK_NULL_HANDLE);
    vk.CmdDispatch(commands, 1, 1, 1);
    vk.CmdEndConditionalRenderingEXT(commands);
    device_finish(commands);
    assert_int_equal(*(uint32_t *)target.bytes, 0);
    expect_instances();
}
