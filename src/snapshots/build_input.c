/* SPDX-License-Identifier: Apache-2.0 */
/* The builder's input: what a geometry is, and how much of its data can be read. */
#include "snapshots/build_input.h"

#include <stdlib.h>

enum builder_quality build_input_quality(VkBuildAccelerationStructureFlagsKHR flags)
{
    if (flags & VK_BUILD_ACCELERATION_STRUCTURE_PREFER_FAST_TRACE_BIT_KHR)
        return BUILDER_HIGH;
    if (flags & VK_BUILD_ACCELERATION_STRUCTURE_PREFER_FAST_BUILD_BIT_KHR)
        return BUILDER_FAST;
    return BUILDER_BALANCED;
}

void build_input_describe(const VkAccelerationStructureGeometryKHR *geometry,
                          struct builder_geometry *described)
{
    *described =
        (struct builder_geometry){.type = geometry->geometryType, .flags = geometry->flags};
    switch (geometry->geometryType) {
    case VK_GEOMETRY_TYPE_TRIANGLES_KHR: {
        const VkAccelerationStructureGeometryTrianglesDataKHR *triangles =
            &geometry->geometry.triangles;
        described->triangles.vertex_format = triangles->vertexFormat;
        described->triangles.index_type = triangles->indexType;
        described->triangles.max_vertex = triangles->maxVertex;
        described->triangles.vertex_stride = triangles->vertexStride;
        break;
    }
    case VK_GEOMETRY_TYPE_AABBS_KHR:
        described->aabbs.stride = geometry->geometry.aabbs.stride;
        break;
    case VK_GEOMETRY_TYPE_INSTANCES_KHR:
        described->instances.array_of_pointers = geometry->geometry.instances.arrayOfPointers;
        break;
    default: /* the builder refuses it */
        break;
    }
}

/* ---- data */

/* offset + count * stride + size, at most UINT64_MAX. */
static uint64_t extent(uint64_t offset, uint64_t count, uint64_t stride, uint64_t size)
{
    uint64_t sum;
    return __builtin_mul_overflow(count, stride, &sum) ||
                   __builtin_add_overflow(sum, offset, &sum) ||
                   __builtin_add_overflow(sum, size, &sum)
               ? UINT64_MAX
               : sum;
}

static uint64_t find(const struct input_memory *memory, VkDeviceOrHostAddressConstKHR address,
                     uint64_t size, const void **bytes)
{
    return memory->find(memory->context, address.deviceAddress, size, bytes);
}

enum { VERTEX_SIZE_MAX = 32 /* of any format */ };

static uint64_t index_size(VkIndexType type)
{
    return type == VK_INDEX_TYPE_UINT32 ? 4 : type == VK_INDEX_TYPE_UINT16 ? 2 : 1;
}

/* `motion`: an address of 0 where it doesn't move. */
static void find_triangles(const struct input_memory *memory,
                           const VkAccelerationStructureGeometryTrianglesDataKHR *from,
                           VkDeviceOrHostAddressConstKHR motion,
                           const VkAccelerationStructureBuildRangeInfoKHR *range,
                           struct builder_triangles *to)
{
    uint64_t corners = (uint64_t)range->primitiveCount * 3, offset = range->primitiveOffset;
    uint64_t vertices = (uint64_t)from->maxVertex + 1;
    if (from->indexType == VK_INDEX_TYPE_NONE_KHR) {
        vertices = corners < vertices ? corners : vertices;
    } else {
        to->indices_size =
            find(memory, from->indexData, extent(offset, corners, index_size(from->indexType), 0),
                 &to->indices);
        offset = 0;
    }
    uint64_t size =
        extent(offset, range->firstVertex + vertices - 1, from->vertexStride, VERTEX_SIZE_MAX);
    to->vertices_size = find(memory, from->vertexData, size, &to->vertices);
    if (motion.deviceAddress)
        to->motion_vertices_size = find(memory, motion, size, &to->motion_vertices);
    if (motion.deviceAddress && !to->motion_vertices)
        to->motion_vertices = from; /* not still, though nothing of it can be read */
    if (!from->transformData.deviceAddress)
        return;
    to->transforms_size =
        find(memory, from->transformData,
             extent(range->transformOffset, 1, sizeof(VkTransformMatrixKHR), 0), &to->transforms);
    if (!to->transforms)
        to->transforms = from; /* not none, though nothing of it can be read */
}

enum { MOTION_INSTANCE_STRIDE = 160 };

static uint64_t extent_of_instances(const struct build_parameters *build, bool array_of_pointers,
                                    uint64_t offset, uint64_t count)
{
    if (array_of_pointers)
        return extent(offset, count, sizeof(uint64_t), 0);
    if (build->info.flags & VK_BUILD_ACCELERATION_STRUCTURE_MOTION_BIT_NV)
        return extent(offset, count - 1, MOTION_INSTANCE_STRIDE,
                      sizeof(VkAccelerationStructureMotionInstanceNV));
    return extent(offset, count, sizeof(VkAccelerationStructureInstanceKHR), 0);
}

static void find_data(const struct input_memory *memory, const struct build_parameters *build,
                      uint32_t geometry, struct builder_geometry *to)
{
    const VkAccelerationStructureGeometryKHR *from = &build->geometries[geometry];
    const VkAccelerationStructureBuildRangeInfoKHR *range = &build->ranges[geometry];
    VkDeviceOrHostAddressConstKHR motion = {0};
    uint64_t count = range->primitiveCount, offset = range->primitiveOffset;
    if (count == 0)
        return;
    switch (to->type) {
    case VK_GEOMETRY_TYPE_TRIANGLES_KHR:
        if (build->motion_vertices)
            motion = build->motion_vertices[geometry];
        find_triangles(memory, &from->geometry.triangles, motion, range, &to->triangles);
        break;
    case VK_GEOMETRY_TYPE_AABBS_KHR:
        to->aabbs.size =
            find(memory, from->geometry.aabbs.data,
                 extent(offset, count - 1, to->aabbs.stride, sizeof(VkAabbPositionsKHR)),
                 &to->aabbs.data);
        break;
    case VK_GEOMETRY_TYPE_INSTANCES_KHR:
        to->instances.size =
            find(memory, from->geometry.instances.data,
                 extent_of_instances(build, to->instances.array_of_pointers, offset, count),
                 &to->instances.data);
        break;
    default:
        break;
    }
}

/* For arrays of pointers. */
static const void *read_address(void *context, uint64_t address, uint64_t size)
{
    const struct input_memory *memory = context;
    const void *bytes;
    return memory->find(memory->context, address, size, &bytes) == size ? bytes : NULL;
}

VkResult build_input_open(const struct build_parameters *build, const struct input_memory *memory,
                          struct build_input *input)
{
    uint32_t count = build->info.geometryCount;
    *input = (struct build_input){
        .input = {.type = build->info.type,
                  .flags = build->info.flags,
                  .quality = build_input_quality(build->info.flags),
                  .geometry_count = count,
                  .ranges = build->ranges},
        .memory = *memory,
    };
    input->input.memory = (struct builder_memory){read_address, &input->memory};
    if (count == 0)
        return VK_SUCCESS;
    input->geometries = calloc(count, sizeof(*input->geometries));
    if (!input->geometries)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    input->input.geometries = input->geometries;
    for (uint32_t i = 0; i < count; i++) {
        build_input_describe(&build->geometries[i], &input->geometries[i]);
        find_data(memory, build, i, &input->geometries[i]);
    }
    return VK_SUCCESS;
}

void build_input_close(struct build_input *input)
{
    free(input->geometries);
    input->geometries = NULL;
}
