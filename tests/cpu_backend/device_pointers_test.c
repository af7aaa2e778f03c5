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
} pointed;

static void open_scene(void)
{
    fixture_triangles(&pointed.triangles, 1, 0);
    pointed.blas = fixture_create_for(&pointed.triangles);
    GET(host_build(&pointed.triangles, pointed.blas.handle, VK_NULL_HANDLE));
    const VkAccelerationStructureKHR blases[] = {pointed.blas.handle, pointed.blas.handle};
    fixture_instances(&pointed.pairs, blases, 2, 0);
    pointed.pairs.range.primitiveCount = COUNT;
    pointed.tlas = fixture_create_for(&pointed.pairs);
    device_build_create(&pointed.pairs, &pointed.build);
    pointed.instances = device_buffer_create(COUNT * APART);
    pointed.pointers = device_buffer_create(COUNT * sizeof(uint64_t));
    const VkAccelerationStructureInstanceKHR *from = pointed.pairs.data;
    const uint64_t pointers[COUNT] = {pointed.instances.address + APART, 0,
                                      pointed.instances.address + 2 * APART, 0x123450};
    memcpy(pointed.instances.bytes + 2 * APART, &from[0], sizeof(from[0]));
    memcpy(pointed.instances.bytes + APART, &from[1], sizeof(from[1]));
    memcpy(pointed.pointers.bytes, pointers, sizeof(pointers));
    pointed.build.geometry.geometry.instances.arrayOfPointers = VK_TRUE;
    pointed.build.geometry.geometry.instances.data.deviceAddress = pointed.pointers.address;
}

static void expect_instances(void)
{
    const AssayHit upper = fixture_trace(pointed.tlas.handle, 2.25f, 0.25f);
    const AssayHit lower = fixture_trace(pointed.tlas.handle, 0.25f, 0.25f);
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
    device_build(commands, &pointed.build, pointed.tlas.handle, VK_NULL_HANDLE);
    device_finish(commands);
    memset(pointed.instances.bytes, 0, COUNT * APART); /* too late to matter */
    expect_instances();
    /* Content tells of the null pointer and the wild one, where it is asked. */
}

TEST_BETWEEN(test_gathered_by_indirect_build, open_scene, close_noisy_test)
{
    const VkAccelerationStructureBuildRangeInfoKHR two = {.primitiveCount = 2,
                                                          .primitiveOffset = 2 * sizeof(uint64_t)};
    VkCommandBuffer commands = device_begin(PRIMARY);
    pointed.build.info.dstAccelerationStructure = pointed.tlas.handle;
    device_build_indirect(commands, &pointed.build.info, COUNT, &two);
    device_finish(commands);
    const AssayHit lower = fixture_trace(pointed.tlas.handle, 0.25f, 0.25f);
    assert_true(lower.isHit);
    assert_int_equal(lower.instance, 0);
    assert_int_equal(lower.customIndex, 100);
    assert_false(fixture_trace(pointed.tlas.handle, 2.25f, 0.25f).isHit);
}

/* ---- a pipeline of the application's own */

struct constants {
    VkDeviceAddress target;
    uint32_t value;
};

enum { CONSTANTS_AT = 16 };

/* Begins commands with the pipeline bound, which is to write a value to the target. */
static VkCommandBuffer begin_with_fill(const struct constants *constants)
{
    const VkPipelineLayout layout =
        constants_layout_create(&vk, device, CONSTANTS_AT, sizeof(*constants));
    OWN(DestroyPipelineLayout, layout);
    const VkPipeline pipeline =
        compute_pipeline_create(&vk, device, layout, fill_code, sizeof(fill_code));
    OWN(DestroyPipeline, pipeline);
    VkCommandBuffer commands = device_begin(PRIMARY);
    vk.CmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline);
    vk.CmdPushConstants(commands, layout, VK_SHADER_STAGE_COMPUTE_BIT, CONSTANTS_AT,
                        sizeof(*constants), constants);
    return commands;
}

TEST_BETWEEN(test_bound_state_stays, open_scene, close_noisy_test)
{
    struct device_buffer target = device_buffer_create(4);
    const struct constants constants = {target.address, 0xabcdef};
    VkCommandBuffer commands = begin_with_fill(&constants);
    device_build(commands, &pointed.build, pointed.tlas.handle, VK_NULL_HANDLE);
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
    struct device_buffer condition = device_buffer_create(16), target = device_buffer_create(4);
    const STRUCT(VkConditionalRenderingBeginInfoEXT, begin, .buffer = condition.handle, .offset = 8,
                 .flags = VK_CONDITIONAL_RENDERING_INVERTED_BIT_EXT);
    const struct constants constants = {target.address, 0xabcdef};
    memset(condition.bytes, 0, 16);
    memset(condition.bytes + 8, 0xff, 4);
    memset(target.bytes, 0, 4);
    VkCommandBuffer commands = begin_with_fill(&constants);
    vk.CmdBeginConditionalRenderingEXT(commands, &begin);
    device_build(commands, &pointed.build, pointed.tlas.handle, VK_NULL_HANDLE);
    vk.CmdDispatch(commands, 1, 1, 1);
    vk.CmdEndConditionalRenderingEXT(commands);
    device_finish(commands);
    assert_int_equal(*(uint32_t *)target.bytes, 0);
    expect_instances();
}
