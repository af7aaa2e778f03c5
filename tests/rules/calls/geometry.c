/* SPDX-License-Identifier: Apache-2.0 */
/* Geometries: their members, chains, addresses and build ranges. */
#include "tests/rules/calls/placing.h"
#include "tests/rules/case.h"

static const VkFormat formats_that_all_have[] = {
    VK_FORMAT_R32G32_SFLOAT,       VK_FORMAT_R32G32B32_SFLOAT, VK_FORMAT_R16G16_SFLOAT,
    VK_FORMAT_R16G16B16A16_SFLOAT, VK_FORMAT_R16G16_SNORM,     VK_FORMAT_R16G16B16A16_SNORM,
};

static void use_every_mandatory_format(struct scene *scene)
{
    for (size_t i = 0; i < sizeof(formats_that_all_have) / sizeof(formats_that_all_have[0]); i++) {
        const uint32_t build = i == 0 ? (uint32_t)INDEXED : scene_add_build(scene, INDEXED);
        scene->geometries[build][0].geometry.triangles.vertexFormat = formats_that_all_have[i];
    }
}
#include "geometry.inc"

static const VkBaseInStructure stray = {.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO};
static const VkBaseInStructure unknown = {.sType = (VkStructureType)2000000123};

static const STRUCT(VkAccelerationStructureGeometryMotionTrianglesDataNV, some_motion);
static const STRUCT(VkAccelerationStructureGeometryMotionTrianglesDataNV, motion_twice,
                    .pNext = &some_motion);
static const STRUCT(VkAccelerationStructureTrianglesOpacityMicromapEXT, micromap,
                    .indexType = VK_INDEX_TYPE_NONE_KHR);
static const STRUCT(VkAccelerationStructureTrianglesOpacityMicromapEXT, micromap_and_stray,
                    .pNext = (void *)&stray, .indexType = VK_INDEX_TYPE_NONE_KHR);
static const STRUCT(VkAccelerationStructureTrianglesDisplacementMicromapNV, displacement,
                    .displacementBiasAndScaleFormat = VK_FORMAT_R32G32_SFLOAT,
                    .displacementVectorFormat = VK_FORMAT_R32G32B32_SFLOAT,
                    .indexType = VK_INDEX_TYPE_NONE_KHR);
static const STRUCT(VkAccelerationStructureGeometrySpheresDataNV, some_spheres);
static const STRUCT(VkAccelerationStructureGeometrySpheresDataNV, spheres_twice,
                    .pNext = &some_spheres);
/* Each of these points to itself. */
static const STRUCT(VkAccelerationStructureGeometryMotionTrianglesDataNV, motion_loop,
                    .pNext = &motion_loop);

/* The motion data points to real vertices, where the address has to be good. */
static void triangles_motion_filled(struct scene *scene)
{
    static VkAccelerationStructureGeometryMotionTrianglesDataNV filled;
    filled = some_motion;
    filled.vertexData.deviceAddress = scene_address(scene, &scene->vertices, 0);
    scene->geometries[INDEXED][0].geometry.triangles.pNext = &filled;
    scene_give_motion_dst(scene, INDEXED);
    scene->infos[INDEXED].flags = VK_BUILD_ACCELERATION_STRUCTURE_MOTION_BIT_NV;
}
#include "chain.inc"

/* In the middle of an allocation of which only the first bytes are a buffer's. */
static struct device_buffer buffer_with_nothing_behind(struct scene *scene)
{
    struct device_buffer buffer = scene_create_buffer(scene, 4096, INPUT_USAGE);
    const struct test_memory memory = scene_allocate(scene, 65536);
    scene_bind(scene, &buffer, &memory, 0);
    return buffer;
}

/* Eight bytes, behind which there is another buffer. */
static VkDeviceAddress of_bytes_before_another_buffer(struct scene *scene)
{
    struct device_buffer buffer = scene_create_buffer(scene, 4096, INPUT_USAGE);
    struct device_buffer next = scene_create_buffer(scene, 4096, INPUT_USAGE);
    const struct test_memory memory = scene_allocate(scene, 65536);
    scene_bind(scene, &buffer, &memory, 0);
    scene_bind(scene, &next, &memory, 4096);
    return buffer.address + 4096 - 8;
}

/* Two buffers at one address, of which one may be read by builds. */
static VkDeviceAddress of_aliasing_buffers(struct scene *scene)
{
    struct device_buffer input = scene_create_buffer(scene, 4096, INPUT_USAGE);
    struct device_buffer storage = scene_create_buffer(scene, 8192, SCRATCH_USAGE);
    const struct test_memory memory = scene_allocate(scene, 65536);
    scene_bind(scene, &input, &memory, 0);
    scene_bind(scene, &storage, &memory, 0);
    return input.address;
}

/* The buffer that was there is gone, another one is bound to the same memory. */
static VkDeviceAddress recycled(struct scene *scene)
{
    struct device_buffer first = scene_create_buffer(scene, 4096, SCRATCH_USAGE);
    struct device_buffer second = scene_create_buffer(scene, 4096, INPUT_USAGE);
    const struct test_memory memory = scene_allocate(scene, 65536);
    scene_bind(scene, &first, &memory, 0);
    scene_destroy(scene, (uint64_t)first.handle);
    scene_bind(scene, &second, &memory, 0);
    return second.address;
}

#include "address.inc"
#include "alignment.inc"

/* A maximum says how many are read at most, so that a count of 0 in device memory excuses nothing.
 */
static void lose_vertices_below_a_maximum(struct scene *scene)
{
    static const uint32_t maxima[SCENE_GEOMETRIES] = {1, 1};
    scene->TRIANGLES(UNINDEXED, 0).vertexData.deviceAddress = 0;
    scene->ranges[UNINDEXED][0].primitiveCount = 0;
    scene->count_pointers[UNINDEXED] = maxima;
}
#include "empty.inc"

#include "range.inc"

#define ADDRESS(build) indirect_addresses[build]

enum { STEP = sizeof(VkAccelerationStructureBuildRangeInfoKHR) };

static void set_dst_size(struct scene *scene, uint32_t build, VkDeviceSize less)
{
    const struct device_buffer buffer = place_buffer(scene);
    scene->infos[build].dstAccelerationStructure = scene_accel_in(
        scene, &buffer, 0, place_size(scene, build) - less, scene->infos[build].type);
}
#include "indirect.inc"
