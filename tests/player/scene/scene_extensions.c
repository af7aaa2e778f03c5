/* SPDX-License-Identifier: Apache-2.0 */
/* Valid builds of extensions, for cases to break: of spheres, of linear swept spheres, with motion.
 */
#include "tests/player/scene/scene.h"

#include <string.h>

static void add_build(struct scene *scene, VkGeometryTypeKHR type, const void *data)
{
    scene_add_build(scene, UNINDEXED);
    scene->infos[SPHERES].geometryCount = 1;
    scene->geometries[SPHERES][0] =
        MAKE(VkAccelerationStructureGeometryKHR, .pNext = data, .geometryType = type);
    scene->ranges[SPHERES][0].primitiveCount = 4;
    scene_give_objects(scene, SPHERES);
}

void scene_add_spheres(struct scene *scene)
{
    scene->spheres = MAKE(
        VkAccelerationStructureGeometrySpheresDataNV, .vertexFormat = VK_FORMAT_R32G32B32_SFLOAT,
        .vertexData.deviceAddress = scene_address(scene, &scene->vertices, 0), .vertexStride = 12,
        .radiusFormat = VK_FORMAT_R32_SFLOAT,
        .radiusData.deviceAddress = scene_address(scene, &scene->boxes, 0), .radiusStride = 4,
        .indexType = VK_INDEX_TYPE_UINT32,
        .indexData.deviceAddress = scene_address(scene, &scene->indices, 0), .indexStride = 4);
    add_build(scene, VK_GEOMETRY_TYPE_SPHERES_NV, &scene->spheres);
}

void scene_add_swept_spheres(struct scene *scene)
{
    scene->swept_spheres = MAKE(
        VkAccelerationStructureGeometryLinearSweptSpheresDataNV,
        .vertexFormat = VK_FORMAT_R32G32B32_SFLOAT,
        .vertexData.deviceAddress = scene_address(scene, &scene->vertices, 0), .vertexStride = 12,
        .radiusFormat = VK_FORMAT_R16_SFLOAT,
        .radiusData.deviceAddress = scene_address(scene, &scene->boxes, 0), .radiusStride = 4,
        .indexType = VK_INDEX_TYPE_UINT16,
        .indexData.deviceAddress = scene_address(scene, &scene->indices, SCENE_BUFFER_SIZE / 2),
        .indexStride = 2, .indexingMode = VK_RAY_TRACING_LSS_INDEXING_MODE_LIST_NV,
        .endCapsMode = VK_RAY_TRACING_LSS_PRIMITIVE_END_CAPS_MODE_CHAINED_NV);
    add_build(scene, VK_GEOMETRY_TYPE_LINEAR_SWEPT_SPHERES_NV, &scene->swept_spheres);
}

/* ---- motion ---- */

#define MOTION VK_BUILD_ACCELERATION_STRUCTURE_MOTION_BIT_NV

/* A moving build may take more than the same one without. */
static void give_motion_objects(struct scene *scene, uint32_t build)
{
    VkAccelerationStructureBuildGeometryInfoKHR *info = &scene->infos[build];
    const VkBuildAccelerationStructureFlagsKHR flags = info->flags;
    info->flags |= MOTION;
    scene_give_objects(scene, build);
    info->flags = flags;
}

void scene_give_motion_dst(struct scene *scene, uint32_t build)
{
    give_motion_objects(scene, build);
    const STRUCT(VkAccelerationStructureMotionInfoNV, motion_info, .maxInstances = 3);
    const STRUCT(VkAccelerationStructureCreateInfoKHR, create_info, .pNext = &motion_info,
                 .createFlags = VK_ACCELERATION_STRUCTURE_CREATE_MOTION_BIT_NV,
                 .buffer = scene->dst_buffers[build].handle, .size = scene->dst_buffers[build].size,
                 .type = scene->infos[build].type);
    scene->infos[build].dstAccelerationStructure = scene_create_accel(scene, &create_info);
}

/* ---- instances ---- */

VkAccelerationStructureInstanceKHR *scene_instance(struct scene *scene, uint32_t index)
{
    return (VkAccelerationStructureInstanceKHR *)(void *)scene->instances.bytes + index;
}

void scene_refer(struct scene *scene, uint32_t index, VkAccelerationStructureKHR accel)
{
    scene_instance(scene, index)->accelerationStructureReference = scene_reference(scene, accel);
}

VkAccelerationStructureKHR scene_built(struct scene *scene, uint32_t model)
{
    const uint32_t build = scene_reserve_build(scene, model);
    scene_build_before(scene, build, 1);
    return scene->infos[build].dstAccelerationStructure;
}

void scene_use_instance_pointers(struct scene *scene)
{
    uint64_t *pointers = (void *)(scene->instances.bytes + SCENE_BUFFER_SIZE / 2);
    memset(pointers, 0, SCENE_BUFFER_SIZE / 2);
    for (uint32_t i = 0; i < 8; i++)
        pointers[i] =
            scene_address(scene, &scene->instances, i * sizeof(VkAccelerationStructureInstanceKHR));
    scene->geometries[TLAS][0].geometry.instances.arrayOfPointers = VK_TRUE;
    scene->ranges[TLAS][0].primitiveOffset = SCENE_BUFFER_SIZE / 2;
}
