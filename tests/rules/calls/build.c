/* SPDX-License-Identifier: Apache-2.0 */
/* VkAccelerationStructureBuildGeometryInfoKHR: its members, structures, scratch and updates. */
#include "tests/rules/calls/placing.h"
#include "tests/rules/case.h"

static const VkBaseInStructure stray = {.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO};
static const VkBaseInStructure unknown = {.sType = (VkStructureType)2000000123};
#include "build.inc"

/* On the host it has been built, and lost its memory since. */
static void leave_update_src_unbound(struct scene *scene)
{
    struct device_buffer buffer;
    if (scene->command == COMMAND_HOST) {
        buffer = place_buffer(scene);
        place_src(scene, UPDATE, &buffer, 0);
        scene_destroy(scene, (uint64_t)buffer.memory);
        return;
    }
    buffer = scene_create_buffer(scene, place_size(scene, UPDATE), ACCEL_USAGE);
    scene->infos[UPDATE].srcAccelerationStructure =
        scene_accel_in(scene, &buffer, 0, buffer.size, scene->infos[UPDATE].type);
}

enum { MANY_GEOMETRIES = 40 };

/* INDEXED, of so many geometries that each is alike; its dst and scratch as they were. */
static void give_many_geometries(struct scene *scene)
{
    static VkAccelerationStructureGeometryKHR geometries[MANY_GEOMETRIES];
    static VkAccelerationStructureBuildRangeInfoKHR ranges[MANY_GEOMETRIES];

    for (uint32_t i = 0; i < MANY_GEOMETRIES; i++) {
        geometries[i] = scene->geometries[INDEXED][0];
        ranges[i] = scene->ranges[INDEXED][0];
    }
    scene->infos[INDEXED].geometryCount = MANY_GEOMETRIES;
    scene->infos[INDEXED].pGeometries = geometries;
    scene->range_pointers[INDEXED] = ranges;
    const struct device_buffer scratch = scene_buffer(scene, 1 << 20, SCRATCH_USAGE);
    scene->infos[INDEXED].scratchData.deviceAddress = scene_address(scene, &scratch, 0);
}

static void give_many_geometries_and_room(struct scene *scene)
{
    const struct device_buffer buffer = scene_buffer(scene, 1 << 20, ACCEL_USAGE);
    give_many_geometries(scene);
    scene->infos[INDEXED].dstAccelerationStructure = scene_accel_in(
        scene, &buffer, 0, buffer.size, VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR);
}
#include "build_state.inc"

static uint64_t alignment_of(const struct scene *scene)
{
    return scene->fixture->limits.minAccelerationStructureScratchOffsetAlignment;
}

static void give_exact_size(struct scene *scene, uint32_t build, VkDeviceSize less)
{
    const VkDeviceSize size = scene_scratch_size(scene, build);
    if (size <= less) {
        scene_skip(scene, "the driver wants no scratch");
        return;
    }
    const struct device_buffer buffer = scene_buffer(scene, size - less, SCRATCH_USAGE);
    scene->infos[build].scratchData.deviceAddress = scene_address(scene, &buffer, 0);
}

/* The same addresses, and a buffer over all of them. */
static void cross_within_aliasing_buffer(struct scene *scene)
{
    const VkDeviceSize half = 65536;
    struct device_buffer whole = scene_create_buffer(scene, 2 * half, SCRATCH_USAGE);
    struct device_buffer first = scene_create_buffer(scene, half, SCRATCH_USAGE);
    const struct test_memory memory = scene_allocate(scene, 2 * half);

    scene_bind(scene, &whole, &memory, 0);
    scene_bind(scene, &first, &memory, 0);
    if (whole.address != first.address) {
        scene_skip(scene, "aliasing buffers have different addresses");
        return;
    }
    scene->infos[AABBS].scratchData.deviceAddress = first.address + half - alignment_of(scene);
}

#include "scratch.inc"

/* What counts is the last build of the source, which has room for either. */
static void build_source_twice(struct scene *scene)
{
    const struct device_buffer buffer = place_buffer(scene);
    const VkAccelerationStructureKHR source = scene_accel_in(
        scene, &buffer, 0, PLACE_SIZE, VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR);

    for (uint32_t i = 0; i < 2; i++) {
        const uint32_t build = scene_reserve_build(scene, INDEXED);
        if (i == 0) {
            scene->infos[build].flags = 0;
            scene->geometries[build][0].geometry.triangles.maxVertex = 20;
            scene_give_objects(scene, build);
        }
        scene->infos[build].dstAccelerationStructure = source;
        scene_build_before(scene, build, 1);
    }
    scene->infos[UPDATE].srcAccelerationStructure = source;
}

#include "update.inc"
