/* SPDX-License-Identifier: Apache-2.0 */
/* Offsets in shared memory. */
#include "placing.h"

enum { ACCEL_ALIGNMENT = 256 };

struct test_buffer place_buffer(struct scene *scene)
{
    return scene_buffer(scene, PLACE_SIZE, PLACE_USAGE);
}

VkDeviceSize place_size(const struct scene *scene, uint32_t build)
{
    return scene_sizes(scene, build).accelerationStructureSize;
}

VkDeviceSize place_behind(VkDeviceSize size)
{
    return (size + ACCEL_ALIGNMENT - 1) / ACCEL_ALIGNMENT * ACCEL_ALIGNMENT;
}

VkDeviceSize place_within(VkDeviceSize size)
{
    return (size - 1) / ACCEL_ALIGNMENT * ACCEL_ALIGNMENT;
}

static VkDeviceSize scratch_alignment(const struct scene *scene)
{
    return scene->world->limits.minAccelerationStructureScratchOffsetAlignment;
}

VkDeviceSize place_scratch_behind(const struct scene *scene, VkDeviceSize size)
{
    const VkDeviceSize alignment = scratch_alignment(scene);
    return (size + alignment - 1) / alignment * alignment;
}

VkDeviceSize place_scratch_within(const struct scene *scene, VkDeviceSize size)
{
    const VkDeviceSize alignment = scratch_alignment(scene);
    return (size - 1) / alignment * alignment;
}

static VkAccelerationStructureKHR place(struct scene *scene, uint32_t build,
                                        const struct test_buffer *buffer, VkDeviceSize offset)
{
    return scene_accel_in(scene, buffer, offset, place_size(scene, build),
                          scene->infos[build].type);
}

void place_dst(struct scene *scene, uint32_t build, const struct test_buffer *buffer,
               VkDeviceSize offset)
{
    scene->infos[build].dstAccelerationStructure = place(scene, build, buffer, offset);
}

void place_src(struct scene *scene, uint32_t build, const struct test_buffer *buffer,
               VkDeviceSize offset)
{
    scene->infos[build].srcAccelerationStructure = place(scene, build, buffer, offset);
    if (scene->infos[build].mode == VK_BUILD_ACCELERATION_STRUCTURE_MODE_UPDATE_KHR)
        scene_build_source(scene, build);
}

void place_scratch(struct scene *scene, uint32_t build, const struct test_buffer *buffer,
                   VkDeviceSize offset)
{
    scene->infos[build].scratchData.deviceAddress = scene_address(scene, buffer, offset);
}

/* As many indices or boxes as there are primitives, all zeros: the host's are looked at. */
static void grow_input(struct scene *scene, uint32_t build)
{
    VkAccelerationStructureGeometryKHR *geometry = &scene->geometries[build][0];
    const struct test_buffer input =
        scene_buffer(scene, (VkDeviceSize)scene->ranges[build][0].primitiveCount * 32, INPUT_USAGE);
    if (geometry->geometryType == VK_GEOMETRY_TYPE_AABBS_KHR)
        geometry->geometry.aabbs.data.hostAddress = input.host;
    else
        geometry->geometry.triangles.indexData.hostAddress = input.host;
}

void place_grow(struct scene *scene, uint32_t build, VkDeviceSize size)
{
    if (scene->command == COMMAND_HOST && scene->world->platform->is_cpu)
        scene_skip(scene, "its input isn't there, and the backend reads it");
    while (place_size(scene, build) <= size)
        scene->ranges[build][0].primitiveCount *= 2;
    if (scene->command == COMMAND_HOST)
        grow_input(scene, build);
    const VkDeviceSize scratch_size = scene_scratch_size(scene, build);
    const struct test_buffer scratch = scene_buffer(scene, scratch_size, SCRATCH_USAGE);
    place_scratch(scene, build, &scratch, 0);
}
