/* SPDX-License-Identifier: Apache-2.0 */
/* Shapes, and one difference for each rule about updates. */
#include "shape.h"

#include "tests/fixture/geometry.h"

enum {
    ALLOW_UPDATE = VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_UPDATE_BIT_KHR,
    ALLOW_COMPACTION = VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_COMPACTION_BIT_KHR,
};

struct shape shape_plain(void)
{
    return (struct shape){
        .flags = ALLOW_UPDATE | ALLOW_COMPACTION,
        .type = VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR,
        .geometry_count = 1,
        .geometry_type = VK_GEOMETRY_TYPE_TRIANGLES_KHR,
        .vertex_format = VK_FORMAT_R32G32B32_SFLOAT,
        .max_vertex = 5,
        .index_type = VK_INDEX_TYPE_UINT32,
        .has_transform = true,
        .primitive_count = 2,
    };
}

struct shape shape_boxes(void)
{
    struct shape shape = shape_plain();
    shape.geometry_type = VK_GEOMETRY_TYPE_AABBS_KHR;
    return shape;
}

static uint64_t address_of(const struct test_buffer *buffer, bool by_host)
{
    return by_host ? (uint64_t)(uintptr_t)buffer->host : buffer->address;
}

static void fill_triangles(VkAccelerationStructureGeometryTrianglesDataKHR *triangles,
                           const struct scene *scene, const struct shape *shape, bool by_host)
{
    *triangles =
        MAKE(VkAccelerationStructureGeometryTrianglesDataKHR, .vertexFormat = shape->vertex_format,
             .vertexData.deviceAddress = address_of(&scene->vertices, by_host), .vertexStride = 16,
             .maxVertex = shape->max_vertex, .indexType = shape->index_type,
             .transformData.deviceAddress =
                 shape->has_transform ? address_of(&scene->transforms, by_host) : 0);
    if (shape->index_type == VK_INDEX_TYPE_UINT32)
        triangles->indexData.deviceAddress = address_of(&scene->indices, by_host);
    if (shape->index_type == VK_INDEX_TYPE_UINT16)
        triangles->indexData.deviceAddress =
            address_of(&scene->indices, by_host) + SCENE_BUFFER_SIZE / 2;
}

static void fill_geometry(VkAccelerationStructureGeometryKHR *geometry, const struct scene *scene,
                          const struct shape *shape, bool by_host)
{
    *geometry = MAKE(VkAccelerationStructureGeometryKHR, .geometryType = shape->geometry_type,
                     .flags = shape->geometry_flags);
    if (shape->geometry_type == VK_GEOMETRY_TYPE_TRIANGLES_KHR)
        fill_triangles(&geometry->geometry.triangles, scene, shape, by_host);
    else if (shape->geometry_type == VK_GEOMETRY_TYPE_AABBS_KHR)
        geometry->geometry =
            boxes_geometry(address_of(&scene->boxes, by_host), sizeof(VkAabbPositionsKHR)).geometry;
    else if (shape->geometry_type == VK_GEOMETRY_TYPE_INSTANCES_KHR)
        geometry->geometry =
            instances_geometry(address_of(&scene->instances, by_host), false).geometry;
}

/* ---- what extensions add to a geometry, for the device: second positions and radii are where the
 * scene has boxes, and so is dense data */

/* Spheres and linear swept spheres share these members. */
#define SPHERES_OF(scene)                                                                          \
    .vertexFormat = VK_FORMAT_R32G32B32_SFLOAT,                                                    \
    .vertexData.deviceAddress = (scene)->vertices.address, .vertexStride = 12,                     \
    .radiusFormat = VK_FORMAT_R32_SFLOAT, .radiusData.deviceAddress = (scene)->boxes.address,      \
    .radiusStride = 4, .indexType = VK_INDEX_TYPE_UINT32,                                          \
    .indexData.deviceAddress = (scene)->indices.address, .indexStride = 4

static void fill_extension(struct shape_arguments *arguments, uint32_t index,
                           const struct scene *scene, const struct shape *shape)
{
    VkAccelerationStructureGeometryKHR *geometry = &arguments->geometries[index];
    union shape_extension *chained = &arguments->chained[index];
    switch ((int)shape->geometry_type) {
    case VK_GEOMETRY_TYPE_TRIANGLES_KHR:
        if (!shape->moves)
            return;
        chained->motion = MAKE(VkAccelerationStructureGeometryMotionTrianglesDataNV,
                               .vertexData.deviceAddress = scene->boxes.address);
        geometry->geometry.triangles.pNext = chained;
        return;
    case VK_GEOMETRY_TYPE_SPHERES_NV:
        chained->spheres = MAKE(VkAccelerationStructureGeometrySpheresDataNV, SPHERES_OF(scene));
        break;
    case VK_GEOMETRY_TYPE_LINEAR_SWEPT_SPHERES_NV:
        chained->swept =
            MAKE(VkAccelerationStructureGeometryLinearSweptSpheresDataNV, SPHERES_OF(scene),
                 .indexingMode = VK_RAY_TRACING_LSS_INDEXING_MODE_SUCCESSIVE_NV);
        break;
    case VK_GEOMETRY_TYPE_DENSE_GEOMETRY_FORMAT_TRIANGLES_AMDX:
        chained->dense = MAKE(VkAccelerationStructureDenseGeometryFormatTrianglesDataAMDX,
                              .compressedData.deviceAddress = scene->boxes.address,
                              .dataSize = shape->dense.size, .numTriangles = shape->dense.triangles,
                              .numVertices = shape->dense.vertices,
                              .maxPrimitiveIndex = shape->dense.max_primitive,
                              .maxGeometryIndex = shape->dense.max_geometry,
                              .format = VK_COMPRESSED_TRIANGLE_FORMAT_DGF1_AMDX);
        break;
    default:
        return;
    }
    geometry->pNext = chained;
}

/* ---- the arguments */

void shape_fill(struct shape_arguments *arguments, const struct scene *scene,
                const struct shape *shape, bool by_host)
{
    for (uint32_t i = 0; i < shape->geometry_count; i++) {
        fill_geometry(&arguments->geometries[i], scene, shape, by_host);
        fill_extension(arguments, i, scene, shape);
        arguments->ranges[i] =
            (VkAccelerationStructureBuildRangeInfoKHR){.primitiveCount = shape->primitive_count};
        arguments->counts[i] = shape->primitive_count;
    }
    const bool is_dense =
        (int)shape->geometry_type == VK_GEOMETRY_TYPE_DENSE_GEOMETRY_FORMAT_TRIANGLES_AMDX;
    arguments->range_pointer = is_dense ? NULL : arguments->ranges;
    arguments->count_pointer = arguments->counts;
    arguments->info = MAKE(VkAccelerationStructureBuildGeometryInfoKHR, .type = shape->type,
                           .flags = shape->flags, .geometryCount = shape->geometry_count,
                           .pGeometries = arguments->geometries);
}

VkAccelerationStructureBuildSizesInfoKHR shape_sizes(const struct scene *scene,
                                                     const struct shape *shape)
{
    struct shape_arguments arguments;
    VkAccelerationStructureBuildSizesInfoKHR sizes = MAKE(VkAccelerationStructureBuildSizesInfoKHR);
    shape_fill(&arguments, scene, shape, false);
    scene->vk->GetAccelerationStructureBuildSizesKHR(
        scene->fixture->device, VK_ACCELERATION_STRUCTURE_BUILD_TYPE_DEVICE_KHR, &arguments.info,
        arguments.counts, &sizes);
    return sizes;
}

/* ---- differences */

#define DIFFERENCE(name, rule, path)                                                               \
    {                                                                                              \
        name, {rule}, 1, path                                                                      \
    }
#define TRIANGLES ".pGeometries[0].geometry.triangles."

struct difference differences[DIFFERENCES] = {
    DIFFERENCE("no_allow_update", RULE_update_source_was_built_with_allow_update,
               ".srcAccelerationStructure"),
    DIFFERENCE("geometry_count", RULE_geometry_count_matches_source, ".geometryCount"),
    DIFFERENCE("flags", RULE_build_flags_match_source, ".flags"),
    DIFFERENCE("type", RULE_build_type_matches_source, ".type"),
    DIFFERENCE("geometry_type", RULE_geometry_type_matches_source, ".pGeometries[0].geometryType"),
    DIFFERENCE("geometry_flags", RULE_geometry_flags_match_source, ".pGeometries[0].flags"),
    DIFFERENCE("vertex_format", RULE_vertex_format_matches_source, TRIANGLES "vertexFormat"),
    DIFFERENCE("max_vertex", RULE_max_vertex_matches_source, TRIANGLES "maxVertex"),
    DIFFERENCE("index_type", RULE_index_type_matches_source, TRIANGLES "indexType"),
    DIFFERENCE("transform_added", RULE_transform_is_absent_where_source_had_none,
               TRIANGLES "transformData"),
    DIFFERENCE("transform_missing", RULE_transform_is_given_where_source_had_one,
               TRIANGLES "transformData"),
    DIFFERENCE("primitive_count", RULE_primitive_count_matches_source, ".pGeometries[0]"),
};

void differences_fill(void)
{
    for (uint32_t i = 0; i < DIFFERENCES; i++)
        differences[i].built = differences[i].asked = shape_plain();
    differences[0].built.flags = ALLOW_COMPACTION;
    differences[1].built.geometry_count = 2;
    differences[2].built.flags |= VK_BUILD_ACCELERATION_STRUCTURE_PREFER_FAST_TRACE_BIT_KHR;
    differences[3].asked.type = VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR;
    differences[3].asked.geometry_type = VK_GEOMETRY_TYPE_INSTANCES_KHR;
    differences[4].built.geometry_type = VK_GEOMETRY_TYPE_AABBS_KHR;
    differences[5].built.geometry_flags = VK_GEOMETRY_OPAQUE_BIT_KHR;
    differences[6].built.vertex_format = VK_FORMAT_R16G16B16A16_SFLOAT;
    differences[7].built.max_vertex = 6;
    differences[8].built.index_type = VK_INDEX_TYPE_UINT16;
    differences[9].built.has_transform = false;
    differences[10].asked.has_transform = false;
    differences[11].built.primitive_count = 1;
}
