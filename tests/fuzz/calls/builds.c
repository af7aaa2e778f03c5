/* SPDX-License-Identifier: Apache-2.0 */
/* The arguments of builds, each array a block of its own, so that whoever reads behind one or keeps
 * one is found out. */
#include <stdlib.h>
#include <string.h>

#include "calls.h"

enum { GEOMETRIES_MAX = 4, BLOCKS = 64 };

void *build_block(struct build_arguments *arguments, size_t size)
{
    void *block = calls_allocate(size);
    if (arguments->block_count == BLOCKS)
        abort();
    arguments->blocks[arguments->block_count++] = block;
    return block;
}

void build_arguments_free(struct build_arguments *arguments)
{
    for (uint32_t i = 0; i < arguments->block_count; i++)
        free(arguments->blocks[i]);
    free(arguments);
}

/* ---- geometries */

static VkAccelerationStructureGeometryTrianglesDataKHR take_triangles(struct calls *calls,
                                                                      bool is_host)
{
    static const VkFormat formats[] = {
        VK_FORMAT_R32G32B32_SFLOAT,   VK_FORMAT_R32G32_SFLOAT, VK_FORMAT_R16G16B16A16_SFLOAT,
        VK_FORMAT_R16G16B16A16_SNORM, VK_FORMAT_R16G16_SNORM,  VK_FORMAT_R16G16_SFLOAT,
        VK_FORMAT_R64G64B64_SFLOAT,   VK_FORMAT_UNDEFINED,     (VkFormat)0x7ffffff0};
    VkAccelerationStructureGeometryTrianglesDataKHR triangles =
        MAKE(VkAccelerationStructureGeometryTrianglesDataKHR, .vertexFormat = TAKE(calls, formats));
    triangles.indexType = take_index_type(calls);
    triangles.vertexStride = take_stride(calls, 12);
    triangles.vertexData = take_data(calls, is_host, 0);
    triangles.maxVertex = take_count(calls);
    if (triangles.indexType != VK_INDEX_TYPE_NONE_KHR)
        triangles.indexData = take_data(calls, is_host, 0);
    if (take(calls) % 4 == 1)
        triangles.transformData = take_data(calls, is_host, 0);
    return triangles;
}

static void take_geometry(struct calls *calls, struct build_arguments *arguments, bool is_host,
                          bool is_top_level, VkAccelerationStructureGeometryKHR *geometry)
{
    uint8_t kind = (uint8_t)(take(calls) + (is_top_level ? 2 : 0));
    *geometry = MAKE(VkAccelerationStructureGeometryKHR, .flags = kind >> 6);
    if (geometry_of_extension(calls, arguments, is_host, kind % 16, geometry))
        return;
    if (kind % 4 == 1) {
        geometry->geometryType = VK_GEOMETRY_TYPE_TRIANGLES_KHR;
        geometry->geometry.triangles = take_triangles(calls, is_host);
        if (kind & 32)
            geometry->geometry.triangles.pNext = geometry_chain(calls, arguments, is_host);
    } else if (kind % 4 == 2) {
        geometry->geometryType = VK_GEOMETRY_TYPE_INSTANCES_KHR;
        geometry->geometry.instances =
            MAKE(VkAccelerationStructureGeometryInstancesDataKHR,
                 .arrayOfPointers = (kind & 32) != 0, .data = take_data(calls, is_host, 0));
    } else {
        geometry->geometryType = kind % 4 == 3 ? (VkGeometryTypeKHR)78 : VK_GEOMETRY_TYPE_AABBS_KHR;
        geometry->geometry.aabbs =
            MAKE(VkAccelerationStructureGeometryAabbsDataKHR, .data = take_data(calls, is_host, 0));
        geometry->geometry.aabbs.stride = take_stride(calls, 24);
    }
}

/* A misaligned copy of the geometries, which ends where its block ends. */
static const void *misplace(struct build_arguments *arguments, const void *geometries, size_t size)
{
    const size_t offset = 4;
    unsigned char *block = build_block(arguments, offset + size);
    memcpy(block + offset, geometries, size);
    return block + offset;
}

static void point_to_geometries(struct build_arguments *arguments,
                                VkAccelerationStructureBuildGeometryInfoKHR *info,
                                VkAccelerationStructureGeometryKHR *geometries, uint8_t how)
{
    const VkAccelerationStructureGeometryKHR **pointers =
        build_block(arguments, info->geometryCount * sizeof(void *));
    for (uint32_t i = 0; i < info->geometryCount; i++)
        pointers[i] = &geometries[i];
    if (how & 1)
        info->ppGeometries = pointers;
    else
        info->pGeometries = geometries;
    if (how == 254 && info->geometryCount)
        pointers[0] = NULL;
    if (how == 252)
        info->pGeometries = NULL;
    if (how == 250)
        info->pGeometries = (const void *)(NOWHERE + 8);
    if (how == 248)
        info->pGeometries =
            misplace(arguments, geometries, info->geometryCount * sizeof(*geometries));
}

/* Ranges that lead nowhere, or lie where no structure may, come to an end there. */
static const VkAccelerationStructureBuildRangeInfoKHR *
take_ranges(struct calls *calls, struct build_arguments *arguments, uint32_t count)
{
    VkAccelerationStructureBuildRangeInfoKHR *ranges =
        build_block(arguments, count * sizeof(*ranges));
    for (uint32_t i = 0; i < count; i++) {
        uint8_t byte = take(calls);
        ranges[i].primitiveCount = byte ? take_build_count(calls) : 1;
        if (byte & 1)
            ranges[i].primitiveOffset = (uint32_t)take_offset(calls);
        if (byte & 2)
            ranges[i].firstVertex = take_first_vertex(calls);
        if (byte & 4)
            ranges[i].transformOffset = (uint32_t)take_offset(calls);
        if (byte == 255)
            return take_pointer(calls);
    }
    return ranges;
}

static void take_info(struct calls *calls, struct build_arguments *arguments, bool is_host,
                      VkAccelerationStructureBuildGeometryInfoKHR *info)
{
    static const VkAccelerationStructureTypeKHR types[] = {
        VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR,
        VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR,
        VK_ACCELERATION_STRUCTURE_TYPE_OPACITY_MICROMAP_KHR,
        VK_ACCELERATION_STRUCTURE_TYPE_GENERIC_KHR};
    uint8_t byte = take(calls);
    *info = MAKE(VkAccelerationStructureBuildGeometryInfoKHR, .type = types[byte & 3],
                 .mode = byte & 4 ? VK_BUILD_ACCELERATION_STRUCTURE_MODE_UPDATE_KHR
                                  : VK_BUILD_ACCELERATION_STRUCTURE_MODE_BUILD_KHR,
                 .geometryCount = 1 + (byte >> 3) % GEOMETRIES_MAX);
    if (byte & 128)
        info->flags = take_word(calls) & 0xffff;
    if (byte & 64)
        info->geometryCount = take(calls) % 2;
    info->dstAccelerationStructure = PICK(VkAccelerationStructureKHR, calls, STRUCTURES);
    if (byte & 4)
        info->srcAccelerationStructure = PICK(VkAccelerationStructureKHR, calls, STRUCTURES);
    if (is_host)
        info->scratchData.hostAddress = calls->result + take_offset(calls) % RESULT_SIZE;
    else
        info->scratchData.deviceAddress = take_address(calls, 2);
    VkAccelerationStructureGeometryKHR *geometries =
        build_block(arguments, info->geometryCount * sizeof(*geometries));
    for (uint32_t i = 0; i < info->geometryCount; i++)
        take_geometry(calls, arguments, is_host, (byte & 3) == 1, &geometries[i]);
    point_to_geometries(arguments, info, geometries, take(calls));
}

struct build_arguments *build_arguments_take(struct calls *calls, bool is_host)
{
    struct build_arguments *arguments = calls_allocate(sizeof(*arguments));
    uint8_t byte = take(calls);
    calls->has_stride_0 = false;
    calls->is_host_build = is_host;
    arguments->count = byte & 128 ? 1 + byte % 3 : 1;
    arguments->infos = build_block(arguments, arguments->count * sizeof(*arguments->infos));
    arguments->ranges = build_block(arguments, arguments->count * sizeof(*arguments->ranges));
    for (uint32_t i = 0; i < arguments->count; i++) {
        take_info(calls, arguments, is_host, &arguments->infos[i]);
        arguments->ranges[i] = take_ranges(calls, arguments, arguments->infos[i].geometryCount);
    }
    return arguments;
}

/* ---- commands */

void call_build(struct calls *calls)
{
    VkCommandBuffer commands = pick_any_commands(calls);
    if (!commands)
        return;
    struct build_arguments *arguments = build_arguments_take(calls, false);
    uint8_t byte = take(calls);
    calls->vk.CmdBuildAccelerationStructuresKHR(commands, byte == 255 ? 0 : arguments->count,
                                                byte == 254 ? NULL : arguments->infos,
                                                byte == 253 ? NULL : arguments->ranges);
    build_arguments_free(arguments);
}

void call_build_indirect(struct calls *calls)
{
    VkCommandBuffer commands = pick_any_commands(calls);
    if (!commands)
        return;
    struct build_arguments *arguments = build_arguments_take(calls, false);
    VkDeviceAddress *addresses = build_block(arguments, arguments->count * sizeof(*addresses));
    uint32_t *strides = build_block(arguments, arguments->count * sizeof(*strides));
    const uint32_t **counts = build_block(arguments, arguments->count * sizeof(void *));
    for (uint32_t i = 0; i < arguments->count; i++) {
        uint32_t geometries = arguments->infos[i].geometryCount;
        uint32_t *own = build_block(arguments, geometries * sizeof(*own));
        for (uint32_t j = 0; j < geometries; j++)
            own[j] = take_build_count(calls);
        counts[i] = own;
        addresses[i] = take_address(calls, 0);
        strides[i] = take(calls) ? (uint32_t)take_size(calls) : 16;
    }
    uint8_t byte = take(calls);
    calls->vk.CmdBuildAccelerationStructuresIndirectKHR(
        commands, arguments->count, byte == 254 ? NULL : arguments->infos,
        byte == 253 ? NULL : addresses, byte == 252 ? NULL : strides, byte == 251 ? NULL : counts);
    build_arguments_free(arguments);
}

void call_host_build(struct calls *calls)
{
    const struct slot *operation = pick(calls, OPERATIONS);
    struct build_arguments *arguments = build_arguments_take(calls, true);
    bool defers = take(calls) % 4 == 1;
    VkResult result = calls->vk.BuildAccelerationStructuresKHR(
        calls->device, defers ? HANDLE_OF(VkDeferredOperationKHR, operation) : VK_NULL_HANDLE,
        arguments->count, arguments->infos, arguments->ranges);
    if (result != VK_OPERATION_DEFERRED_KHR) {
        build_arguments_free(arguments);
        return;
    }
    arguments->next = calls->deferred;
    calls->deferred = arguments;
}

/* The driver reads what it is given here, so it is well-formed. */
void call_get_sizes(struct calls *calls)
{
    struct build_arguments *arguments = build_arguments_take(calls, take(calls) % 2);
    VkAccelerationStructureBuildSizesInfoKHR sizes = MAKE(VkAccelerationStructureBuildSizesInfoKHR);
    uint32_t counts[GEOMETRIES_MAX];
    for (uint32_t i = 0; i < GEOMETRIES_MAX; i++)
        counts[i] = take_count(calls);
    calls->vk.GetAccelerationStructureBuildSizesKHR(calls->device,
                                                    VK_ACCELERATION_STRUCTURE_BUILD_TYPE_DEVICE_KHR,
                                                    arguments->infos, counts, &sizes);
    build_arguments_free(arguments);
}
