/* SPDX-License-Identifier: Apache-2.0 */
/* Builds of one geometry of an extension, from buffers of their own. */
#include "input_scene.h"

#include <string.h>

void input_scene_open(struct input_scene *scene, VkGeometryTypeKHR type, const void *chain)
{
    memset(scene, 0, sizeof(*scene));
    scene->vertices = device_buffer_create(INPUT_SIZE);
    scene->radii = device_buffer_create(INPUT_SIZE);
    scene->indices = device_buffer_create(INPUT_SIZE);
    scene->build.geometry =
        MAKE(VkAccelerationStructureGeometryKHR, .pNext = chain, .geometryType = type);
    scene->build.info = MAKE(VkAccelerationStructureBuildGeometryInfoKHR,
                             .type = VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR,
                             .geometryCount = 1, .pGeometries = &scene->build.geometry);
}

void input_scene_create(struct input_scene *scene)
{
    enum { ALIGNMENT = 256 };
    scene->blas = fixture_create_for(&scene->build);
    scene->scratch = device_buffer_create(fixture_scratch_size(&scene->build) + ALIGNMENT);
    scene->build.info.scratchData.deviceAddress =
        (scene->scratch.address + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT;
    scene->build.info.dstAccelerationStructure = scene->blas.handle;
}

static void record_indirect(struct input_scene *scene, VkCommandBuffer commands,
                            const VkAccelerationStructureBuildRangeInfoKHR *ranges,
                            struct device_buffer *buffer)
{
    const uint32_t stride = sizeof(*ranges), *counts = &scene->build.range.primitiveCount;
    *buffer = device_buffer_create(sizeof(*ranges));
    if (ranges)
        memcpy(buffer->bytes, ranges, sizeof(*ranges));
    vk.CmdBuildAccelerationStructuresIndirectKHR(commands, 1, &scene->build.info, &buffer->address,
                                                 &stride, &counts);
}

void input_scene_build(struct input_scene *scene,
                       const VkAccelerationStructureBuildRangeInfoKHR *ranges, bool is_indirect)
{
    struct device_buffer buffer = {0};
    VkCommandBuffer commands = device_begin(VK_COMMAND_BUFFER_LEVEL_PRIMARY);
    if (is_indirect)
        record_indirect(scene, commands, ranges, &buffer);
    else
        vk.CmdBuildAccelerationStructuresKHR(commands, 1, &scene->build.info, &ranges);
    device_barrier(commands);
    device_finish(commands);
    memset(scene->vertices.bytes, 0xff, INPUT_SIZE);
    memset(scene->radii.bytes, 0xff, INPUT_SIZE);
    memset(scene->indices.bytes, 0xff, INPUT_SIZE);
}

AssayHit input_scene_trace(const struct input_scene *scene, float y, float z)
{
    return fixture_trace(scene->blas.handle, y, z);
}

void input_scene_expect_hit(const struct input_scene *scene, float y, float z, float t,
                            uint32_t primitive)
{
    const AssayHit hit = input_scene_trace(scene, y, z);
    assert_true(hit.isHit);
    assert_false(hit.isAabb);
    assert_float_equal(hit.t, t, 1e-5);
    assert_int_equal(hit.primitive, primitive);
}

void input_scene_expect_miss(const struct input_scene *scene, float y, float z)
{
    assert_false(input_scene_trace(scene, y, z).isHit);
}
