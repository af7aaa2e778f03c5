/* SPDX-License-Identifier: Apache-2.0 */
/* Valid builds of extensions, for cases to break: of spheres, of linear swept spheres, with motion,
 * of clusters and of partitioned structures. */
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

/* ---- clusters and partitioned structures, and what their builds use ---- */

enum { COUNT = 4, DST_SIZE = 1 << 16, SCRATCH_SIZE = 1 << 16, ARRAYS_SIZE = 4096, SIZES_AT = 2048 };
enum { INFOS_AT = 64, INFO_STRIDE = 128, INSTANCES = 16, PARTITION_SRC_AT = 1 << 15 };

bool command_builds_at_addresses(enum build_command command)
{
    const char *name = build_command_name(command);
    return strstr(name, "ClusterAcc") != NULL || strstr(name, "Partitioned") != NULL;
}

void scene_use_cluster_op(struct scene *scene, VkClusterAccelerationStructureOpTypeNV type)
{
    struct scene_life *life = &scene->life;
    VkClusterAccelerationStructureInputInfoNV *input = &life->cluster.input;
    input->opType = type;
    if (type == VK_CLUSTER_ACCELERATION_STRUCTURE_OP_TYPE_MOVE_OBJECTS_NV)
        input->opInput.pMoveObjects = &life->cluster_moves;
    else if (type == VK_CLUSTER_ACCELERATION_STRUCTURE_OP_TYPE_BUILD_CLUSTERS_BOTTOM_LEVEL_NV)
        input->opInput.pClustersBottomLevel = &life->cluster_bottom_level;
    else
        input->opInput.pTriangleClusters = &life->cluster_triangles;
}

void scene_use_cluster_mode(struct scene *scene, VkClusterAccelerationStructureOpModeNV mode)
{
    scene->life.cluster.input.opMode = mode;
}

static void open_cluster(struct scene *scene)
{
    struct scene_life *life = &scene->life;
    life->cluster_triangles =
        MAKE(VkClusterAccelerationStructureTriangleClusterInputNV,
             .vertexFormat = VK_FORMAT_R32G32B32_SFLOAT, .maxClusterUniqueGeometryCount = 1,
             .maxClusterTriangleCount = 64, .maxClusterVertexCount = 64,
             .maxTotalTriangleCount = 64, .maxTotalVertexCount = 64);
    life->cluster_bottom_level =
        MAKE(VkClusterAccelerationStructureClustersBottomLevelInputNV, .maxTotalClusterCount = 4,
             .maxClusterCountPerAccelerationStructure = 2);
    life->cluster_moves = MAKE(VkClusterAccelerationStructureMoveObjectsInputNV,
                               .type = VK_CLUSTER_ACCELERATION_STRUCTURE_TYPE_TRIANGLE_CLUSTER_NV,
                               .maxMovedBytes = 4096);
    const struct device_buffer *arrays = &life->cluster_arrays, *input = &life->cluster_input;
    life->cluster = MAKE(
        VkClusterAccelerationStructureCommandsInfoNV,
        .input =
            MAKE(VkClusterAccelerationStructureInputInfoNV, .maxAccelerationStructureCount = COUNT,
                 .opMode = VK_CLUSTER_ACCELERATION_STRUCTURE_OP_MODE_IMPLICIT_DESTINATIONS_NV),
        .dstImplicitData = life->cluster_dst.address, .scratchData = life->cluster_scratch.address,
        .dstAddressesArray = {arrays->address, sizeof(VkDeviceAddress), SIZES_AT},
        .dstSizesArray = {arrays->address + SIZES_AT, sizeof(uint32_t), SIZES_AT},
        .srcInfosArray = {input->address + INFOS_AT, INFO_STRIDE, COUNT * INFO_STRIDE},
        .srcInfosCount = input->address);
    scene_use_cluster_op(scene,
                         VK_CLUSTER_ACCELERATION_STRUCTURE_OP_TYPE_BUILD_TRIANGLE_CLUSTER_NV);
}

void scene_open_clusters(struct scene *scene)
{
    struct scene_life *life = &scene->life;
    life->cluster_input = scene_buffer(scene, SCENE_BUFFER_SIZE, INPUT_USAGE);
    life->cluster_dst = scene_buffer(scene, DST_SIZE, ACCEL_USAGE);
    life->cluster_arrays = scene_buffer(scene, ARRAYS_SIZE, SCRATCH_USAGE);
    life->cluster_scratch = scene_buffer(scene, SCRATCH_SIZE, SCRATCH_USAGE);
    memset(life->cluster_input.bytes, 0, SCENE_BUFFER_SIZE);
    memset(life->cluster_arrays.bytes, 0, ARRAYS_SIZE);
    open_cluster(scene);
    life->partition_flags = MAKE(VkPartitionedAccelerationStructureFlagsNV);
    life->partition =
        MAKE(VkBuildPartitionedAccelerationStructureInfoNV,
             .input = MAKE(VkPartitionedAccelerationStructureInstancesInputNV,
                           .instanceCount = INSTANCES, .maxInstancePerPartitionCount = INSTANCES,
                           .partitionCount = COUNT, .maxInstanceInGlobalPartitionCount = INSTANCES),
             .dstAccelerationStructureData = life->cluster_dst.address,
             .scratchData = life->cluster_scratch.address,
             .srcInfos = life->cluster_input.address + INFOS_AT,
             .srcInfosCount = life->cluster_input.address);
}

void scene_use_partition_descriptor(struct scene *scene)
{
    struct scene_life *life = &scene->life;
    const struct device_buffer buffer = scene_buffer(scene, DST_SIZE, ACCEL_USAGE);
    life->objects[0] = life->objects[1] = buffer.address;
    life->partition_descriptor =
        MAKE(VkWriteDescriptorSetPartitionedAccelerationStructureNV,
             .accelerationStructureCount = 2, .pAccelerationStructures = life->objects);
    life->write.descriptorType = VK_DESCRIPTOR_TYPE_PARTITIONED_ACCELERATION_STRUCTURE_NV;
    life->write.pNext = &life->partition_descriptor;
}

void scene_query_input_sizes(struct scene *scene)
{
    const struct scene_life *life = &scene->life;
    STRUCT(VkAccelerationStructureBuildSizesInfoKHR, sizes);
    scene->vk->GetClusterAccelerationStructureBuildSizesNV(scene->fixture->device,
                                                           &life->cluster.input, &sizes);
    scene->vk->GetPartitionedAccelerationStructuresBuildSizesNV(scene->fixture->device,
                                                                &life->partition.input, &sizes);
}
