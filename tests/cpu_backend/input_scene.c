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
    scene->blas = fixture_create_for(&scene->build);
    scene->build.info.scratchData.deviceAddress = device_scratch_create(&scene->build);
    scene->build.info.dstAccelerationStructure = scene->blas.handle;
}

void input_scene_build(struct input_scene *scene,
                       const VkAccelerationStructureBuildRangeInfoKHR *ranges, bool is_indirect)
{
    VkCommandBuffer commands = device_begin(PRIMARY);
    if (is_indirect)
        device_build_indirect(commands, &scene->build.info, scene->build.range.primitiveCount,
                              ranges);
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
    expect_hit_at(hit, t, primitive);
    assert_false(hit.isAabb);
}

void input_scene_expect_miss(const struct input_scene *scene, float y, float z)
{
    assert_false(input_scene_trace(scene, y, z).isHit);
}
