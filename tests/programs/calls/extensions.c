/* SPDX-License-Identifier: Apache-2.0 */
/* Dense geometry, motion, spheres and displacement. */
#include "tests/player/calls/case.h"
#include "tests/player/scene/placing.h"

/* The build that the functions below add. */
enum { DENSE = SCENE_BASE_BUILDS };

static void add_build(struct scene *scene, const struct device_buffer *buffer)
{
    scene_add_build(scene, UNINDEXED);
    scene->infos[DENSE].geometryCount = 1;
    scene->dense =
        MAKE(VkAccelerationStructureDenseGeometryFormatTrianglesDataAMDX,
             .compressedData.deviceAddress = scene_address(scene, buffer, 0), .dataSize = 1024,
             .numTriangles = 64, .numVertices = 96, .maxPrimitiveIndex = 63, .maxGeometryIndex = 1,
             .format = VK_COMPRESSED_TRIANGLE_FORMAT_DGF1_AMDX);
    scene->geometries[DENSE][0] =
        MAKE(VkAccelerationStructureGeometryKHR, .pNext = &scene->dense,
             .geometryType = VK_GEOMETRY_TYPE_DENSE_GEOMETRY_FORMAT_TRIANGLES_AMDX);
    /* So that the sizes are those of so many triangles; no range is given. */
    scene->ranges[DENSE][0].primitiveCount = scene->dense.numTriangles;
    scene_give_objects(scene, DENSE);
    if (scene->command != COMMAND_HOST) /* which requires a pointer */
        scene->range_pointers[DENSE] = NULL;
}

#define MOTION VK_BUILD_ACCELERATION_STRUCTURE_MOTION_BIT_NV

static void chain_motion(struct scene *scene, uint64_t address)
{
    scene->motion = MAKE(VkAccelerationStructureGeometryMotionTrianglesDataNV,
                         .vertexData.deviceAddress = address);
    scene->geometries[INDEXED][0].geometry.triangles.pNext = &scene->motion;
    scene_give_motion_dst(scene, INDEXED);
    scene->infos[INDEXED].flags = MOTION;
}

static const VkBaseInStructure info_for_creation = {
    .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_MOTION_INFO_NV};

#include "extensions.inc"
