/* SPDX-License-Identifier: Apache-2.0 */
/* The builder's input: what a geometry is, and how much of its data can be read. */
#include "snapshots/build_input.h"

#include <stdlib.h>

#include "build/source.h"

enum builder_quality build_input_quality(VkBuildAccelerationStructureFlagsKHR flags)
{
    if (flags & VK_BUILD_ACCELERATION_STRUCTURE_PREFER_FAST_TRACE_BIT_KHR)
        return BUILDER_HIGH;
    if (flags & VK_BUILD_ACCELERATION_STRUCTURE_PREFER_FAST_BUILD_BIT_KHR)
        return BUILDER_FAST;
    return BUILDER_BALANCED;
}

static void describe_chained(const struct chained_input *from, struct builder_geometry *to)
{
    const VkAccelerationStructureGeometryLinearSweptSpheresDataNV *spheres = &from->spheres;
    switch ((int)to->type) {
    case VK_GEOMETRY_TYPE_SPHERES_NV:
    case VK_GEOMETRY_TYPE_LINEAR_SWEPT_SPHERES_NV:
        to->spheres = (struct builder_spheres){
            .vertex_format = spheres->vertexFormat,
            .radius_format = spheres->radiusFormat,
            .index_type = spheres->indexType,
            .vertex_stride = spheres->vertexStride,
            .radius_stride = spheres->radiusStride,
            .index_stride = spheres->indexStride,
            .indexing_mode = spheres->indexingMode,
            .end_caps_mode = spheres->endCapsMode,
        };
        break;
    case VK_GEOMETRY_TYPE_DENSE_GEOMETRY_FORMAT_TRIANGLES_AMDX:
        to->dense.max_primitive = from->dense.maxPrimitiveIndex;
        break;
    default: /* the builder refuses it */
        break;
    }
}

void build_input_describe(const VkAccelerationStructureGeometryKHR *geometry,
                          const struct chained_input *chained, struct builder_geometry *described)
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
    default:
        if (chained)
            describe_chained(chained, described);
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

/* `chained`: NULL: nothing. */
static void find_triangles(const struct input_memory *memory,
                           const VkAccelerationStructureGeometryTrianglesDataKHR *from,
                           const struct chained_input *chained,
                           const VkAccelerationStructureBuildRangeInfoKHR *range,
                           struct builder_triangles *to)
{
    VkDeviceOrHostAddressConstKHR motion = {0};
    if (chained)
        motion = chained->motion_vertices;
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

/* Indices that can't be read yet leave open how many vertices and radii are. */
static void find_spheres(const struct input_memory *memory,
                         const VkAccelerationStructureGeometryLinearSweptSpheresDataNV *from,
                         const VkAccelerationStructureBuildRangeInfoKHR *range, bool is_swept,
                         struct builder_spheres *to)
{
    uint64_t offset = range->primitiveOffset;
    if (!sphere_formats_are_known(to))
        return;
    if (to->index_type != VK_INDEX_TYPE_NONE_KHR) {
        uint64_t count = sphere_element_count(to, is_swept, range->primitiveCount);
        to->indices_size = find(
            memory, from->indexData,
            extent(offset, count - 1, to->index_stride, index_size(to->index_type)), &to->indices);
        offset = 0;
    }
    uint64_t count = sphere_vertex_count(to, is_swept, range), last = range->firstVertex + count;
    bool is_open = !count && memory->is_later;
    if (!count && !is_open)
        return;
    to->vertices_size =
        find(memory, from->vertexData,
             is_open ? UINT64_MAX : extent(offset, last - 1, to->vertex_stride, VERTEX_SIZE_MAX),
             &to->vertices);
    to->radii_size = find(memory, from->radiusData,
                          is_open ? UINT64_MAX
                                  : extent(offset, last - 1, to->radius_stride,
                                           radius_format_size(to->radius_format)),
                          &to->radii);
}

/* The opacity of `count` triangles. */
static void find_opacity(const struct input_memory *memory,
                         const VkAccelerationStructureTrianglesOpacityMicromapEXT *from,
                         uint64_t count, struct builder_opacity *to)
{
    *to = (struct builder_opacity){
        .index_type = from->indexType,
        .base_triangle = from->baseTriangle,
        .stride = from->indexStride,
        .micromap = (uint64_t)from->micromap,
    };
    if (count && from->indexType != VK_INDEX_TYPE_NONE_KHR)
        to->indices_size =
            find(memory, from->indexBuffer,
                 extent(0, count - 1, to->stride, index_size(from->indexType)), &to->indices);
}

static void find_data(const struct input_memory *memory, const struct build_parameters *build,
                      uint32_t geometry, struct builder_geometry *to)
{
    const VkAccelerationStructureGeometryKHR *from = &build->geometries[geometry];
    const VkAccelerationStructureBuildRangeInfoKHR *range = &build->ranges[geometry];
    const struct chained_input *chained = build->chained ? &build->chained[geometry] : NULL;
    uint64_t count = range->primitiveCount, offset = range->primitiveOffset;
    if (count == 0)
        return;
    switch ((int)to->type) {
    case VK_GEOMETRY_TYPE_TRIANGLES_KHR:
        find_triangles(memory, &from->geometry.triangles, chained, range, &to->triangles);
        break;
    case VK_GEOMETRY_TYPE_SPHERES_NV:
    case VK_GEOMETRY_TYPE_LINEAR_SWEPT_SPHERES_NV:
        if (chained)
            find_spheres(memory, &chained->spheres, range,
                         (int)to->type == VK_GEOMETRY_TYPE_LINEAR_SWEPT_SPHERES_NV, &to->spheres);
        break;
    case VK_GEOMETRY_TYPE_DENSE_GEOMETRY_FORMAT_TRIANGLES_AMDX:
        if (chained)
            to->dense.size = find(memory, chained->dense.compressedData, chained->dense.dataSize,
                                  &to->dense.data);
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

/* ---- micromaps */

/* Triangles that can't be read yet leave open how much data they have. */
static void find_micromap(const struct build_parameters *build, const struct input_memory *memory,
                          struct micromap_input *to)
{
    *to = (struct micromap_input){.type = VK_MICROMAP_TYPE_OPACITY_MICROMAP_EXT};
    if (build->info.geometryCount != 1 || !build->chained)
        return;
    const struct micromap_parameters *from = &build->chained[0].micromap;
    to->type = from->type;
    to->usage_count = from->usage_count;
    to->usages = from->usages;
    to->stride = from->stride;
    uint64_t count = micromap_triangle_count(to);
    if (!count)
        return;
    to->triangles_size =
        find(memory, from->triangles,
             extent(0, count - 1, to->stride, sizeof(VkMicromapTriangleEXT)), &to->triangles);
    to->data_size = find(memory, from->data,
                         memory->is_later ? UINT64_MAX : micromap_data_extent(to), &to->data);
}

/* For arrays of pointers. */
static const void *read_address(void *context, uint64_t address, uint64_t size)
{
    const struct input_memory *memory = context;
    const void *bytes;
    return memory->find(memory->context, address, size, &bytes) == size ? bytes : NULL;
}

/* Also where there are no triangles: a size query looks whether a geometry has any opacity. */
static void find_opacities(const struct build_parameters *build, const struct input_memory *memory,
                           struct build_input *input)
{
    for (uint32_t i = 0; i < build->info.geometryCount; i++) {
        const struct chained_input *chained = &build->chained[i];
        struct builder_geometry *to = &input->geometries[i];
        bool is_dense = geometry_is_dense(&build->geometries[i]);
        uint64_t count = build->ranges[i].primitiveCount;
        if (!chained->has_opacity)
            continue;
        if (is_dense && count)
            count = (uint64_t)to->dense.max_primitive + 1;
        find_opacity(memory, &chained->opacity, count, &input->opacities[i]);
        *(is_dense ? &to->dense.opacity : &to->triangles.opacity) = &input->opacities[i];
    }
}

static bool has_opacities(const struct build_parameters *build)
{
    for (uint32_t i = 0; build->chained && i < build->info.geometryCount; i++)
        if (build->chained[i].has_opacity)
            return true;
    return false;
}

static VkResult open_geometries(const struct build_parameters *build,
                                const struct input_memory *memory, struct build_input *input)
{
    uint32_t count = build->info.geometryCount;
    input->geometries = calloc(count, sizeof(*input->geometries));
    if (!input->geometries)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    input->input.geometries = input->geometries;
    for (uint32_t i = 0; i < count; i++) {
        build_input_describe(&build->geometries[i], build->chained ? &build->chained[i] : NULL,
                             &input->geometries[i]);
        find_data(memory, build, i, &input->geometries[i]);
    }
    if (!has_opacities(build))
        return VK_SUCCESS;
    input->opacities = calloc(count, sizeof(*input->opacities));
    if (!input->opacities) {
        build_input_close(input);
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    }
    find_opacities(build, memory, input);
    return VK_SUCCESS;
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
    if ((int)build->info.type == VK_ACCELERATION_STRUCTURE_TYPE_OPACITY_MICROMAP_KHR) {
        input->is_micromap = true;
        find_micromap(build, memory, &input->micromap);
        return VK_SUCCESS;
    }
    return count ? open_geometries(build, memory, input) : VK_SUCCESS;
}

void build_input_close(struct build_input *input)
{
    free(input->geometries);
    free(input->opacities);
    input->geometries = NULL;
    input->opacities = NULL;
}
