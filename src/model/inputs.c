/* SPDX-License-Identifier: Apache-2.0 */
#include "src/model/inputs.h"

#include "src/bvh/input/formats.h"
#include "src/model/formats.h"
#include "src/model/geometry.h"

/* The inputs of one geometry, as far as they are found. */
struct found_inputs {
    const VkAccelerationStructureGeometryKHR *geometry;
    const struct chained_input *chained;
    struct geometry_input *items;
    uint32_t count;
};

/* The bound only protects memory: GEOMETRY_INPUTS is as many as a geometry can have. */
static void add_input(struct found_inputs *found, const struct geometry_input *input)
{
    if (found->count == GEOMETRY_INPUTS)
        return;
    struct geometry_input *added = &found->items[found->count++];
    *added = *input;
    added->address = *input_place(found->geometry, found->chained, input->role);
    if (!input->most)
        added->most = input->size;
}

/* Adds an input that the geometry has only if its address is not 0. */
static void add_if_given(struct found_inputs *found, const struct geometry_input *input)
{
    if (input_place(found->geometry, found->chained, input->role)->deviceAddress)
        add_input(found, input);
}

/* Adds `count` indices, if the type has any. */
static void add_indices(struct found_inputs *found, VkIndexType type, struct geometry_input indices)
{
    indices.size = index_type_size(type);
    if (indices.size)
        add_input(found, &indices);
}

/* ---- triangles */

/* How many vertices a range may use, from its firstVertex on. */
static uint64_t vertex_count(const VkAccelerationStructureGeometryTrianglesDataKHR *triangles,
                             const VkAccelerationStructureBuildRangeInfoKHR *range)
{
    const uint32_t most = triangles->maxVertex,
                   first = range->firstVertex < most ? range->firstVertex : most;
    const uint64_t corners = (uint64_t)range->primitiveCount * 3, left = (uint64_t)most - first + 1;
    return triangles->indexType == VK_INDEX_TYPE_NONE_KHR && corners < left ? corners : left;
}

static void add_vertices(struct found_inputs *found,
                         const VkAccelerationStructureGeometryTrianglesDataKHR *triangles,
                         const VkAccelerationStructureBuildRangeInfoKHR *range)
{
    const bool is_indexed = triangles->indexType != VK_INDEX_TYPE_NONE_KHR;
    struct geometry_input vertices = {
        .role = INPUT_VERTEX,
        .is_chosen = is_indexed,
        .follows_indices = is_indexed,
        .offset = input_extent(is_indexed ? 0 : range->primitiveOffset, range->firstVertex,
                               triangles->vertexStride, 0),
        .count = vertex_count(triangles, range),
        .stride = triangles->vertexStride,
        .size = format_position_size(triangles->vertexFormat),
    };
    add_input(found, &vertices);
    vertices.role = INPUT_MOTION_VERTEX;
    if (found->chained)
        add_if_given(found, &vertices);
}

/* One index for each of `count` triangles, of which the build reads each one if there is a
 * micromap. */
static void add_opacity(struct found_inputs *found, uint64_t count, bool is_certain)
{
    const VkAccelerationStructureTrianglesOpacityMicromapEXT *opacity = &found->chained->opacity;
    const bool is_ext =
        opacity->sType == VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_TRIANGLES_OPACITY_MICROMAP_EXT;
    if (found->chained->has_opacity)
        add_indices(
            found, opacity->indexType,
            (struct geometry_input){.role = is_ext ? INPUT_OPACITY_EXT_INDEX : INPUT_OPACITY_INDEX,
                                    .is_chosen = !is_certain || !opacity->micromap,
                                    .is_of_device = !is_ext,
                                    .count = count,
                                    .stride = opacity->indexStride});
}

/* Which vectors, and biases and scales, are read depends on the indices of the triangles. */
static void add_displacement(struct found_inputs *found,
                             const VkAccelerationStructureTrianglesDisplacementMicromapNV *from,
                             const VkAccelerationStructureBuildRangeInfoKHR *range,
                             uint64_t vertices)
{
    const struct geometry_input vectors = {
        .role = INPUT_DISPLACEMENT_VECTOR,
        .is_chosen = true,
        .offset = input_extent(0, range->firstVertex, from->displacementVectorStride, 0),
        .count = vertices,
        .stride = from->displacementVectorStride,
        .size = format_position_size(from->displacementVectorFormat),
    };
    const struct geometry_input biases = {
        .role = INPUT_DISPLACEMENT_BIAS,
        .is_chosen = true,
        .offset = input_extent(0, range->firstVertex, from->displacementBiasAndScaleStride, 0),
        .count = vertices,
        .stride = from->displacementBiasAndScaleStride,
        .size = format_position_size(from->displacementBiasAndScaleFormat),
    };
    const struct geometry_input flags = {
        .role = INPUT_DISPLACEMENT_FLAGS,
        .count = range->primitiveCount,
        .stride = from->displacedMicromapPrimitiveFlagsStride,
        .size = 1,
    };
    if (!from->micromap)
        return;
    add_input(found, &vectors);
    add_if_given(found, &biases);
    add_if_given(found, &flags);
    add_indices(found, from->indexType,
                (struct geometry_input){.role = INPUT_DISPLACEMENT_INDEX,
                                        .count = range->primitiveCount,
                                        .stride = from->indexStride});
}

static void add_triangles(struct found_inputs *found,
                          const VkAccelerationStructureGeometryTrianglesDataKHR *triangles,
                          const VkAccelerationStructureBuildRangeInfoKHR *range)
{
    const struct chained_input *chained = found->chained;
    const uint32_t index_size = index_type_size(triangles->indexType);
    add_vertices(found, triangles, range);
    add_indices(found, triangles->indexType,
                (struct geometry_input){.role = INPUT_INDEX,
                                        .offset = range->primitiveOffset,
                                        .count = (uint64_t)range->primitiveCount * 3,
                                        .stride = index_size});
    add_if_given(found, &(struct geometry_input){.role = INPUT_MATRIX,
                                                 .offset = range->transformOffset,
                                                 .count = 1,
                                                 .size = sizeof(VkTransformMatrixKHR)});
    if (!chained)
        return;
    add_opacity(found, range->primitiveCount, true);
    if (chained->has_displacement)
        add_displacement(found, &chained->displacement, range, vertex_count(triangles, range));
}

/* ---- other geometries */

/* Indices choose vertices and radii. Without them, radii follow each other from the first one on;
 * where that is, is certain only if firstVertex and primitiveOffset are 0. */
static void add_spheres(struct found_inputs *found,
                        const VkAccelerationStructureGeometryLinearSweptSpheresDataNV *spheres,
                        const VkAccelerationStructureBuildRangeInfoKHR *range, bool is_swept)
{
    const bool is_indexed = spheres->indexType != VK_INDEX_TYPE_NONE_KHR;
    const bool is_shared =
        is_indexed && spheres->indexingMode == VK_RAY_TRACING_LSS_INDEXING_MODE_SUCCESSIVE_NV;
    const bool has_pairs = is_swept && !is_shared;
    const bool is_known_mode =
        !has_pairs || spheres->indexingMode == VK_RAY_TRACING_LSS_INDEXING_MODE_LIST_NV;
    const uint64_t count = (uint64_t)range->primitiveCount << has_pairs;
    const uint32_t offset = is_indexed ? 0 : range->primitiveOffset;
    const struct geometry_input vertices = {
        .role = is_swept ? INPUT_SWEPT_VERTEX : INPUT_SPHERE_VERTEX,
        .is_chosen = is_indexed,
        .offset = input_extent(offset, range->firstVertex, spheres->vertexStride, 0),
        .count = is_indexed ? 0 : count,
        .stride = spheres->vertexStride,
        .size = format_position_size(spheres->vertexFormat),
    };
    const struct geometry_input radii = {
        .role = is_swept ? INPUT_SWEPT_RADIUS : INPUT_SPHERE_RADIUS,
        .is_chosen = is_indexed || range->firstVertex || offset,
        .offset = input_extent(offset, range->firstVertex, spheres->radiusStride, 0),
        .count = is_indexed ? 0 : count,
        .stride = spheres->radiusStride,
        .size = format_smallest_component(spheres->radiusFormat),
    };
    add_indices(found, spheres->indexType,
                (struct geometry_input){.role = is_swept ? INPUT_SWEPT_INDEX : INPUT_SPHERE_INDEX,
                                        .is_chosen = !is_known_mode,
                                        .offset = range->primitiveOffset,
                                        .count = count,
                                        .stride = spheres->indexStride});
    add_input(found, &vertices);
    add_input(found, &radii);
}

/* Motion instances are 160 bytes apart. What is certainly read of one is as much as an instance
 * without motion has, behind its type and flags. */
enum { MOTION_INSTANCE_STRIDE = 160, MOTION_INSTANCE_HEADER = 8 };

static void add_instances(struct found_inputs *found,
                          const VkAccelerationStructureBuildRangeInfoKHR *range, bool has_motion)
{
    struct geometry_input input = {.role = INPUT_INSTANCES,
                                   .offset = range->primitiveOffset,
                                   .count = range->primitiveCount,
                                   .stride = sizeof(VkAccelerationStructureInstanceKHR),
                                   .size = sizeof(VkAccelerationStructureInstanceKHR)};
    if (has_instance_pointers(found->geometry)) {
        input.stride = input.size = sizeof(VkDeviceAddress);
    } else if (has_motion) {
        input.stride = MOTION_INSTANCE_STRIDE;
        input.size += MOTION_INSTANCE_HEADER;
        input.most = sizeof(VkAccelerationStructureMotionInstanceNV);
    }
    add_input(found, &input);
}

/* Its primitive count is in the data. */
static void add_dense(struct found_inputs *found)
{
    const VkAccelerationStructureDenseGeometryFormatTrianglesDataAMDX *dense =
        &found->chained->dense;
    if (!dense->numTriangles || !dense->dataSize)
        return;
    add_input(found, &(struct geometry_input){
                         .role = INPUT_DENSE_DATA, .count = 1, .size = dense->dataSize});
    add_opacity(found, (uint64_t)dense->maxPrimitiveIndex + 1, false);
}

/* How much data the triangles of a micromap have is known only from them. */
static void add_micromap(struct found_inputs *found, const struct micromap_parameters *micromap)
{
    const uint64_t count = micromap_parameters_count(micromap);
    if (!count)
        return;
    add_input(found, &(struct geometry_input){.role = INPUT_MICROMAP_TRIANGLES,
                                              .is_of_device = micromap->is_khr,
                                              .count = count,
                                              .stride = micromap->stride,
                                              .size = sizeof(VkMicromapTriangleEXT)});
    add_input(found, &(struct geometry_input){.role = INPUT_MICROMAP_DATA,
                                              .is_chosen = true,
                                              .is_of_device = micromap->is_khr});
}

uint32_t inputs_of_geometry(VkBuildAccelerationStructureFlagsKHR flags,
                            const VkAccelerationStructureGeometryKHR *geometry,
                            const struct chained_input *chained,
                            const VkAccelerationStructureBuildRangeInfoKHR *range,
                            struct geometry_input inputs[GEOMETRY_INPUTS])
{
    struct found_inputs found = {.geometry = geometry, .chained = chained, .items = inputs};
    const bool has_motion = flags & VK_BUILD_ACCELERATION_STRUCTURE_MOTION_BIT_NV;
    const bool is_empty = !range || !range->primitiveCount;
    switch ((int)geometry->geometryType) {
    case VK_GEOMETRY_TYPE_TRIANGLES_KHR:
        if (!is_empty)
            add_triangles(&found, &geometry->geometry.triangles, range);
        break;
    case VK_GEOMETRY_TYPE_AABBS_KHR:
        if (!is_empty)
            add_input(&found, &(struct geometry_input){.role = INPUT_AABBS,
                                                       .offset = range->primitiveOffset,
                                                       .count = range->primitiveCount,
                                                       .stride = geometry->geometry.aabbs.stride,
                                                       .size = sizeof(VkAabbPositionsKHR)});
        break;
    case VK_GEOMETRY_TYPE_INSTANCES_KHR:
        if (!is_empty)
            add_instances(&found, range, has_motion);
        break;
    case VK_GEOMETRY_TYPE_SPHERES_NV:
    case VK_GEOMETRY_TYPE_LINEAR_SWEPT_SPHERES_NV:
        if (!is_empty && chained && chained->spheres.sType)
            add_spheres(&found, &chained->spheres, range,
                        type_is_swept_spheres(geometry->geometryType));
        break;
    case VK_GEOMETRY_TYPE_DENSE_GEOMETRY_FORMAT_TRIANGLES_AMDX:
        if (chained)
            add_dense(&found);
        break;
    case VK_GEOMETRY_TYPE_MICROMAP_KHR:
        if (chained)
            add_micromap(&found, &chained->micromap);
        break;
    default:
        break;
    }
    return found.count;
}
