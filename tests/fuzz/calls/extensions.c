/* SPDX-License-Identifier: Apache-2.0 */
/* Geometries of extensions, and what they chain: motion, spheres, dense geometry, micromaps; builds
 * and copies of micromaps, and of VK_NV_ray_tracing. */
#include <string.h>

#include "calls.h"
#include "tests/fixture/make.h"

/* ---- chains */

VkIndexType take_index_type(struct calls *calls)
{
    static const VkIndexType types[] = {VK_INDEX_TYPE_NONE_KHR, VK_INDEX_TYPE_UINT32,
                                        VK_INDEX_TYPE_UINT16, VK_INDEX_TYPE_UINT8_KHR,
                                        (VkIndexType)77};
    return TAKE(calls, types);
}

static VkFormat take_format(struct calls *calls)
{
    static const VkFormat formats[] = {VK_FORMAT_R32G32B32_SFLOAT, VK_FORMAT_R32_SFLOAT,
                                       VK_FORMAT_R16G16_SFLOAT, VK_FORMAT_R16_SFLOAT,
                                       VK_FORMAT_UNDEFINED};
    return TAKE(calls, formats);
}

static VkMicromapUsageEXT take_usage(struct calls *calls)
{
    VkMicromapUsageEXT usage = {.count = take_count(calls)};
    usage.subdivisionLevel = take(calls) % 16;
    usage.format = 1u + take(calls) % 3;
    return usage;
}

static void *opacity_ext(struct calls *calls, struct build_arguments *arguments, bool is_host)
{
    VkAccelerationStructureTrianglesOpacityMicromapEXT *opacity =
        build_block(arguments, sizeof(*opacity));
    VkMicromapUsageEXT *usage = build_block(arguments, sizeof(*usage));
    *usage = take_usage(calls);
    *opacity =
        MAKE(VkAccelerationStructureTrianglesOpacityMicromapEXT,
             .indexType = take_index_type(calls), .usageCountsCount = 1, .pUsageCounts = usage);
    opacity->micromap = PICK(VkMicromapEXT, calls, MICROMAPS);
    opacity->baseTriangle = take(calls);
    opacity->indexBuffer = take_data(calls, is_host, 0);
    opacity->indexStride = take_stride(calls, 4);
    return opacity;
}

static void *opacity_khr(struct calls *calls, struct build_arguments *arguments)
{
    VkAccelerationStructureTrianglesOpacityMicromapKHR *opacity =
        build_block(arguments, sizeof(*opacity));
    *opacity = MAKE(VkAccelerationStructureTrianglesOpacityMicromapKHR,
                    .indexType = take_index_type(calls));
    opacity->micromap = PICK(VkAccelerationStructureKHR, calls, STRUCTURES);
    opacity->baseTriangle = take(calls);
    opacity->indexBuffer = take_address(calls, 0);
    opacity->indexStride = take_stride(calls, 4);
    return opacity;
}

static void *displacement(struct calls *calls, struct build_arguments *arguments, bool is_host)
{
    VkAccelerationStructureTrianglesDisplacementMicromapNV *micromap =
        build_block(arguments, sizeof(*micromap));
    VkMicromapUsageEXT *usage = build_block(arguments, sizeof(*usage));
    *usage = take_usage(calls);
    *micromap = MAKE(VkAccelerationStructureTrianglesDisplacementMicromapNV,
                     .displacementBiasAndScaleFormat = VK_FORMAT_R32G32_SFLOAT,
                     .displacementVectorFormat = VK_FORMAT_R32G32B32_SFLOAT,
                     .displacementBiasAndScaleStride = 8, .displacementVectorStride = 12,
                     .usageCountsCount = 1, .pUsageCounts = usage,
                     .micromap = PICK(VkMicromapEXT, calls, MICROMAPS));
    micromap->displacementBiasAndScaleBuffer = take_data(calls, is_host, 0);
    micromap->displacementVectorBuffer = take_data(calls, is_host, 0);
    micromap->displacedMicromapPrimitiveFlags = take_data(calls, is_host, 0);
    micromap->displacedMicromapPrimitiveFlagsStride = take_stride(calls, 1);
    micromap->indexType = take_index_type(calls);
    micromap->indexBuffer = take_data(calls, is_host, 0);
    micromap->indexStride = take_stride(calls, 4);
    return micromap;
}

void *geometry_chain(struct calls *calls, struct build_arguments *arguments, bool is_host)
{
    VkAccelerationStructureGeometryMotionTrianglesDataNV *motion;
    uint8_t kind = take(calls);
    switch (kind % 6) {
    case 0:
        motion = build_block(arguments, sizeof(*motion));
        motion->sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_MOTION_TRIANGLES_DATA_NV;
        motion->vertexData = take_data(calls, is_host, 0);
        return motion;
    case 1:
        return opacity_ext(calls, arguments, is_host);
    case 2:
        return opacity_khr(calls, arguments);
    case 3:
        return displacement(calls, arguments, is_host);
    case 4:
        return (void *)(NOWHERE + 16);
    default:
        return calls->host; /* of no known type, and ends at once */
    }
}

/* ---- geometries */

/* Spheres are described as swept ones are, up to the modes. */
static void *spheres(struct calls *calls, struct build_arguments *arguments, bool is_host,
                     bool is_swept)
{
    STRUCT(VkAccelerationStructureGeometryLinearSweptSpheresDataNV, data);
    const size_t size =
        is_swept ? sizeof(data) : sizeof(VkAccelerationStructureGeometrySpheresDataNV);
    if (!is_swept)
        data.sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_SPHERES_DATA_NV;
    data.vertexFormat = take_format(calls);
    data.vertexData = take_data(calls, is_host, 0);
    data.vertexStride = take_stride(calls, 12);
    data.radiusFormat = VK_FORMAT_R32_SFLOAT;
    data.radiusData = take_data(calls, is_host, 0);
    data.radiusStride = take_stride(calls, 4);
    data.indexType = take_index_type(calls);
    data.indexData = take_data(calls, is_host, 0);
    data.indexStride = take_stride(calls, 4);
    if (is_swept)
        data.indexingMode = (VkRayTracingLssIndexingModeNV)(take(calls) % 3);
    return memcpy(build_block(arguments, size), &data, size);
}

static void *dense(struct calls *calls, struct build_arguments *arguments, bool is_host)
{
    VkAccelerationStructureDenseGeometryFormatTrianglesDataAMDX *data =
        build_block(arguments, sizeof(*data));
    data->sType =
        VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_DENSE_GEOMETRY_FORMAT_TRIANGLES_DATA_AMDX;
    data->compressedData = take_data(calls, is_host, 0);
    data->dataSize = 128u * take_count(calls);
    data->numTriangles = take_count(calls);
    data->numVertices = take_count(calls);
    data->maxPrimitiveIndex = take(calls);
    data->maxGeometryIndex = take(calls);
    return data;
}

static void *micromap_data(struct calls *calls, struct build_arguments *arguments)
{
    VkAccelerationStructureGeometryMicromapDataKHR *data = build_block(arguments, sizeof(*data));
    VkMicromapUsageKHR *usage = build_block(arguments, sizeof(*usage));
    const VkMicromapUsageEXT taken = take_usage(calls);
    *usage = (VkMicromapUsageKHR){taken.count, taken.subdivisionLevel,
                                  (VkOpacityMicromapFormatKHR)taken.format};
    data->sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_MICROMAP_DATA_KHR;
    data->usageCountsCount = 1;
    data->pUsageCounts = usage;
    data->data = take_address(calls, 0);
    data->triangleArray = take_address(calls, 0);
    data->triangleArrayStride = 8;
    return data;
}

bool geometry_of_extension(struct calls *calls, struct build_arguments *arguments, bool is_host,
                           uint8_t kind, VkAccelerationStructureGeometryKHR *geometry)
{
    switch (kind) {
    case 12:
        geometry->geometryType = VK_GEOMETRY_TYPE_SPHERES_NV;
        geometry->pNext = spheres(calls, arguments, is_host, false);
        return true;
    case 13:
        geometry->geometryType = VK_GEOMETRY_TYPE_LINEAR_SWEPT_SPHERES_NV;
        geometry->pNext = spheres(calls, arguments, is_host, true);
        return true;
    case 14:
        geometry->geometryType = VK_GEOMETRY_TYPE_DENSE_GEOMETRY_FORMAT_TRIANGLES_AMDX;
        geometry->pNext = dense(calls, arguments, is_host);
        return true;
    case 15:
        geometry->geometryType = VK_GEOMETRY_TYPE_MICROMAP_KHR;
        geometry->pNext = micromap_data(calls, arguments);
        return true;
    default:
        return false;
    }
}

/* ---- micromaps */

void make_micromap_info(struct calls *calls, bool is_host, VkMicromapUsageEXT *usage,
                        VkMicromapBuildInfoEXT *info)
{
    *usage = take_usage(calls);
    *info = MAKE(VkMicromapBuildInfoEXT, .type = (VkMicromapTypeEXT)(take(calls) % 2),
                 .usageCountsCount = 1, .pUsageCounts = usage, .triangleArrayStride = 8);
    info->dstMicromap = PICK(VkMicromapEXT, calls, MICROMAPS);
    info->data = take_data(calls, is_host, 0);
    info->triangleArray = take_data(calls, is_host, 0);
    if (is_host)
        info->scratchData.hostAddress = calls->result;
    else
        info->scratchData.deviceAddress = take_address(calls, 2);
}

void call_build_micromap(struct calls *calls)
{
    VkCommandBuffer commands = pick_any_commands(calls);
    VkMicromapUsageEXT usage;
    VkMicromapBuildInfoEXT info;
    make_micromap_info(calls, false, &usage, &info);
    if (commands)
        calls->vk.CmdBuildMicromapsEXT(commands, 1, &info);
}

void call_copy_micromap(struct calls *calls)
{
    VkCommandBuffer commands = pick_any_commands(calls);
    const VkMicromapEXT src = PICK(VkMicromapEXT, calls, MICROMAPS);
    const VkMicromapEXT dst = PICK(VkMicromapEXT, calls, MICROMAPS);
    const uint8_t kind = take(calls);
    const STRUCT(VkCopyMicromapInfoEXT, copy, .src = src, .dst = dst,
                 .mode = kind & 2 ? VK_COPY_MICROMAP_MODE_COMPACT_EXT
                                  : VK_COPY_MICROMAP_MODE_CLONE_EXT);
    STRUCT(VkCopyMemoryToMicromapInfoEXT, from_memory, .dst = dst,
           .mode = VK_COPY_MICROMAP_MODE_DESERIALIZE_EXT);
    from_memory.src.deviceAddress = take_address(calls, 0);
    if (commands && kind & 1)
        calls->vk.CmdCopyMemoryToMicromapEXT(commands, &from_memory);
    else if (commands)
        calls->vk.CmdCopyMicromapEXT(commands, &copy);
}

void call_host_micromap(struct calls *calls)
{
    VkMicromapUsageEXT usage;
    VkMicromapBuildInfoEXT info;
    make_micromap_info(calls, true, &usage, &info);
    calls->vk.BuildMicromapsEXT(calls->device, VK_NULL_HANDLE, 1, &info);
}

/* ---- VK_NV_ray_tracing */

static VkGeometryNV take_geometry_nv(struct calls *calls)
{
    STRUCT(VkGeometryNV, geometry,
           .geometryType =
               take(calls) % 2 ? VK_GEOMETRY_TYPE_TRIANGLES_KHR : VK_GEOMETRY_TYPE_AABBS_KHR,
           .geometry.triangles = MAKE(VkGeometryTrianglesNV, .vertexStride = 12),
           .geometry.aabbs = MAKE(VkGeometryAABBNV, .stride = 24));
    VkGeometryTrianglesNV *triangles = &geometry.geometry.triangles;
    VkGeometryAABBNV *boxes = &geometry.geometry.aabbs;
    boxes->aabbData = triangles->vertexData = PICK(VkBuffer, calls, BUFFERS);
    boxes->offset = triangles->vertexOffset = take_offset(calls);
    boxes->numAABBs = triangles->vertexCount = take_count(calls);
    if (geometry.geometryType == VK_GEOMETRY_TYPE_AABBS_KHR)
        return geometry;
    triangles->vertexFormat = take_format(calls);
    triangles->indexType = take_index_type(calls);
    if (triangles->indexType != VK_INDEX_TYPE_NONE_KHR) {
        triangles->indexData = PICK(VkBuffer, calls, BUFFERS);
        triangles->indexCount = take_count(calls);
        triangles->indexOffset = take_offset(calls);
    }
    return geometry;
}

static VkAccelerationStructureInfoNV take_info_nv(struct calls *calls, const VkGeometryNV *geometry)
{
    STRUCT(VkAccelerationStructureInfoNV, info,
           .type = VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_NV, .geometryCount = 1,
           .pGeometries = geometry);
    bool is_top_level = take(calls) % 3 == 1;
    info.flags = take(calls);
    if (is_top_level) {
        info.type = VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_NV;
        info.geometryCount = 0;
        info.instanceCount = take_count(calls);
    }
    return info;
}

void call_create_nv(struct calls *calls)
{
    struct slot *slot = pick(calls, NV_STRUCTURES);
    const VkGeometryNV geometry = take_geometry_nv(calls);
    const STRUCT(VkAccelerationStructureCreateInfoNV, info, .info = take_info_nv(calls, &geometry));
    CREATE(calls, slot, 0, CreateAccelerationStructureNV, &info);
}

void call_bind_nv(struct calls *calls)
{
    const struct slot *slot = pick(calls, NV_STRUCTURES);
    const VkDeviceMemory memory = PICK(VkDeviceMemory, calls, MEMORIES);
    const STRUCT(VkBindAccelerationStructureMemoryInfoNV, info,
                 .accelerationStructure = HANDLE_OF(VkAccelerationStructureNV, slot),
                 .memory = memory, .memoryOffset = take_offset(calls));
    uint64_t handle;
    calls->vk.BindAccelerationStructureMemoryNV(calls->device, 1, &info);
    if (take(calls) % 2)
        calls->vk.GetAccelerationStructureHandleNV(calls->device, info.accelerationStructure,
                                                   sizeof(handle), &handle);
}

void call_build_nv(struct calls *calls)
{
    VkCommandBuffer commands = pick_any_commands(calls);
    const VkGeometryNV geometry = take_geometry_nv(calls);
    const VkAccelerationStructureInfoNV info = take_info_nv(calls, &geometry);
    const struct slot *dst = pick(calls, NV_STRUCTURES), *src = pick(calls, NV_STRUCTURES);
    const uint8_t byte = take(calls);
    const VkBuffer instances = PICK(VkBuffer, calls, BUFFERS);
    const VkDeviceSize offset = byte & 2 ? take_offset(calls) : 0;
    const VkBuffer scratch = PICK(VkBuffer, calls, BUFFERS);
    const VkDeviceSize scratch_offset = take_offset(calls);
    if (commands)
        calls->vk.CmdBuildAccelerationStructureNV(
            commands, byte == 254 ? NULL : &info, byte & 1 ? instances : VK_NULL_HANDLE, offset,
            byte & 4 ? VK_TRUE : VK_FALSE, HANDLE_OF(VkAccelerationStructureNV, dst),
            byte & 4 ? HANDLE_OF(VkAccelerationStructureNV, src) : VK_NULL_HANDLE, scratch,
            scratch_offset);
}

void call_copy_nv(struct calls *calls)
{
    VkCommandBuffer commands = pick_any_commands(calls);
    const struct slot *dst = pick(calls, NV_STRUCTURES), *src = pick(calls, NV_STRUCTURES);
    const VkCopyAccelerationStructureModeKHR mode = take(calls) % 3;
    if (commands)
        calls->vk.CmdCopyAccelerationStructureNV(commands,
                                                 HANDLE_OF(VkAccelerationStructureNV, dst),
                                                 HANDLE_OF(VkAccelerationStructureNV, src), mode);
}
