/* SPDX-License-Identifier: Apache-2.0 */
/* Valid builds of spheres and of linear swept spheres, for cases to break. */
#include "scene_spheres.h"

static void add_build(struct scene *scene, VkGeometryTypeKHR type, const void *data)
{
    scene_add_build(scene, UNINDEXED);
    scene->infos[SPHERES].geometryCount = 1;
    scene->geometries[SPHERES][0] = (VkAccelerationStructureGeometryKHR){
        .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_KHR,
        .pNext = data,
        .geometryType = type,
    };
    scene->ranges[SPHERES][0].primitiveCount = 4;
    scene_give_objects(scene, SPHERES);
}

void scene_add_spheres(struct scene *scene)
{
    scene->spheres = (VkAccelerationStructureGeometrySpheresDataNV){
        .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_SPHERES_DATA_NV,
        .vertexFormat = VK_FORMAT_R32G32B32_SFLOAT,
        .vertexData.deviceAddress = scene_address(scene, &scene->vertices, 0),
        .vertexStride = 12,
        .radiusFormat = VK_FORMAT_R32_SFLOAT,
        .radiusData.deviceAddress = scene_address(scene, &scene->boxes, 0),
        .radiusStride = 4,
        .indexType = VK_INDEX_TYPE_UINT32,
        .indexData.deviceAddress = scene_address(scene, &scene->indices, 0),
        .indexStride = 4,
    };
    add_build(scene, VK_GEOMETRY_TYPE_SPHERES_NV, &scene->spheres);
}

void scene_add_swept_spheres(struct scene *scene)
{
    scene->swept_spheres = (VkAccelerationStructureGeometryLinearSweptSpheresDataNV){
        .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_LINEAR_SWEPT_SPHERES_DATA_NV,
        .vertexFormat = VK_FORMAT_R32G32B32_SFLOAT,
        .vertexData.deviceAddress = scene_address(scene, &scene->vertices, 0),
        .vertexStride = 12,
        .radiusFormat = VK_FORMAT_R16_SFLOAT,
        .radiusData.deviceAddress = scene_address(scene, &scene->boxes, 0),
        .radiusStride = 4,
        .indexType = VK_INDEX_TYPE_UINT16,
        .indexData.deviceAddress = scene_address(scene, &scene->indices, SCENE_BUFFER_SIZE / 2),
        .indexStride = 2,
        .indexingMode = VK_RAY_TRACING_LSS_INDEXING_MODE_LIST_NV,
        .endCapsMode = VK_RAY_TRACING_LSS_PRIMITIVE_END_CAPS_MODE_CHAINED_NV,
    };
    add_build(scene, VK_GEOMETRY_TYPE_LINEAR_SWEPT_SPHERES_NV, &scene->swept_spheres);
}
