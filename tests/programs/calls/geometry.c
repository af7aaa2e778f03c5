/* SPDX-License-Identifier: Apache-2.0 */
/* Geometries: their members, chains, addresses and build ranges. */
#include "tests/player/calls/case.h"
#include "tests/player/scene/placing.h"

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

/* In the middle of an allocation of which only the first bytes are a buffer's. */
static struct device_buffer buffer_with_nothing_behind(struct scene *scene)
{
    struct device_buffer buffer = scene_create_buffer(scene, 4096, INPUT_USAGE);
    const struct test_memory memory = scene_allocate(scene, 65536);
    scene_bind(scene, &buffer, &memory, 0);
    return buffer;
}

/* A maximum says how many are read at most, so that a count of 0 in device memory excuses nothing.
 */
static void lose_vertices_below_a_maximum(struct scene *scene)
{
    static const uint32_t maxima[SCENE_GEOMETRIES] = {1, 1};
    scene->TRIANGLES(UNINDEXED, 0).vertexData.deviceAddress = 0;
    scene->ranges[UNINDEXED][0].primitiveCount = 0;
    scene->count_pointers[UNINDEXED] = maxima;
}

#define ADDRESS(build) indirect_addresses[build]

enum { STEP = sizeof(VkAccelerationStructureBuildRangeInfoKHR) };

#include "geometry.inc"
