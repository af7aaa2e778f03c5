/* SPDX-License-Identifier: Apache-2.0 */
/* The builder's input: the description of each geometry, and how much of its data can be read; and
 * sizes, computed from an input without data. */
#include "src/snapshots/build_input.h"

#include <stdlib.h>

#include "src/bvh/input/source.h"
#include "src/snapshots/input_find.h"

/* The kind of BVH that the flags request. VK_BUILD_ACCELERATION_STRUCTURE_LOW_MEMORY_BIT_KHR is
 * kept among the BVH's flags and changes nothing else, because BVHs have one form. */
static enum builder_quality build_input_quality(VkBuildAccelerationStructureFlagsKHR flags)
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
    default: /* the builder rejects it */
        break;
    }
}

/* Fills in type, flags, formats and strides, without data. `chained` may be NULL. */
static void build_input_describe(const VkAccelerationStructureGeometryKHR *geometry,
                                 const struct chained_input *chained,
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
    default:
        if (chained)
            describe_chained(chained, described);
    }
}

/* ---- data */

/* `chained` may be NULL. */
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
    uint64_t vertices = input_vertices(from, range);
    if (from->indexType != VK_INDEX_TYPE_NONE_KHR) {
        to->indices_size = input_find(
            memory, from->indexData,
            input_extent(offset, corners, input_index_size(from->indexType), 0), &to->indices);
        offset = 0;
    }
    uint64_t size = input_extent(offset, range->firstVertex + vertices - 1, from->vertexStride,
                                 INPUT_VERTEX_MAX);
    to->vertices_size = input_find(memory, from->vertexData, size, &to->vertices);
    if (motion.deviceAddress)
        to->motion_vertices_size = input_find(memory, motion, size, &to->motion_vertices);
    if (motion.deviceAddress && !to->motion_vertices)
        to->motion_vertices = from; /* has motion, but none of the data can be read */
    if (!from->transformData.deviceAddress)
        return;
    to->transforms_size = input_find(
        memory, from->transformData,
        input_extent(range->transformOffset, 1, sizeof(VkTransformMatrixKHR), 0), &to->transforms);
    if (!to->transforms)
        to->transforms = from; /* has a transform that can't be read */
}

enum { MOTION_INSTANCE_STRIDE = 160 };

static uint64_t extent_of_instances(const struct build_parameters *build, bool array_of_pointers,
                                    uint64_t offset, uint64_t count)
{
    if (array_of_pointers)
        return input_extent(offset, count, sizeof(uint64_t), 0);
    if (build->info.flags & VK_BUILD_ACCELERATION_STRUCTURE_MOTION_BIT_NV)
        return input_extent(offset, count - 1, MOTION_INSTANCE_STRIDE,
                            sizeof(VkAccelerationStructureMotionInstanceNV));
    return input_extent(offset, count, sizeof(VkAccelerationStructureInstanceKHR), 0);
}

/* If indices can't be read yet, the numbers of vertices and radii are unknown. */
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
        to->indices_size = input_find(
            memory, from->indexData,
            input_extent(offset, count - 1, to->index_stride, input_index_size(to->index_type)),
            &to->indices);
        offset = 0;
    }
    uint64_t count = sphere_vertex_count(to, is_swept, range), last = range->firstVertex + count;
    bool is_open = !count && memory->is_later;
    if (!count && !is_open)
        return;
    to->vertices_size = input_find(
        memory, from->vertexData,
        is_open ? UINT64_MAX : input_extent(offset, last - 1, to->vertex_stride, INPUT_VERTEX_MAX),
        &to->vertices);
    to->radii_size = input_find(memory, from->radiusData,
                                is_open ? UINT64_MAX
                                        : input_extent(offset, last - 1, to->radius_stride,
                                                       radius_format_size(to->radius_format)),
                                &to->radii);
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
            to->dense.size = input_find(memory, chained->dense.compressedData,
                                        chained->dense.dataSize, &to->dense.data);
        break;
    case VK_GEOMETRY_TYPE_AABBS_KHR:
        to->aabbs.size = input_find(
            memory, from->geometry.aabbs.data,
            input_extent(offset, count - 1, to->aabbs.stride, sizeof(VkAabbPositionsKHR)),
            &to->aabbs.data);
        break;
    case VK_GEOMETRY_TYPE_INSTANCES_KHR:
        to->instances.size =
            input_find(memory, from->geometry.instances.data,
                       extent_of_instances(build, to->instances.array_of_pointers, offset, count),
                       &to->instances.data);
        break;
    default:
        break;
    }
}

/* ---- the whole input */

/* Resolves an element of an array of pointers. */
static const void *read_address(void *context, uint64_t address, uint64_t size)
{
    const struct input_memory *memory = context;
    const void *bytes;
    return memory->find(memory->context, address, size, &bytes) == size ? bytes : NULL;
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
    VkResult result = build_input_find_micromaps(build, memory, input);
    if (result != VK_SUCCESS)
        build_input_close(input);
    return result;
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
        build_input_find_micromap(build, memory, &input->micromap);
        return VK_SUCCESS;
    }
    return count ? open_geometries(build, memory, input) : VK_SUCCESS;
}

void build_input_close(struct build_input *input)
{
    free(input->geometries);
    free(input->opacities);
    free(input->displacements);
    input->geometries = NULL;
    input->opacities = NULL;
    input->displacements = NULL;
}

/* ---- sizes */

static uint64_t find_nothing(void *context, uint64_t address, uint64_t size, const void **bytes)
{
    (void)context;
    (void)address;
    (void)size;
    *bytes = NULL;
    return 0;
}

VkResult build_parameters_sizes(const struct build_parameters *build, const uint32_t *counts,
                                struct builder_sizes *sizes)
{
    const struct input_memory nothing = {.find = find_nothing};
    struct build_input input;
    *sizes = (struct builder_sizes){0};
    VkResult result = build_input_open(build, &nothing, &input);
    if (result == VK_SUCCESS && input.is_micromap)
        micromap_get_size(&input.micromap, &sizes->structure);
    else if (result == VK_SUCCESS)
        builder_get_sizes(&input.input, counts, sizes);
    build_input_close(&input);
    return result;
}

void cpu_build_sizes(const VkAccelerationStructureBuildGeometryInfoKHR *info,
                     const uint32_t *counts, struct builder_sizes *sizes)
{
    *sizes = (struct builder_sizes){0};
    struct readable_cache cache = {0};
    struct build_parameters build;
    if (build_parameters_copy(&cache, info, NULL, &build) != VK_SUCCESS)
        return;
    bool takes_counts = build_parameters_take_ranges(&build);
    if (!takes_counts ||
        readable(&cache, counts, sizeof(*counts) * (size_t)build.info.geometryCount))
        build_parameters_sizes(&build, takes_counts ? counts : NULL, sizes);
    build_parameters_release(&build);
}
