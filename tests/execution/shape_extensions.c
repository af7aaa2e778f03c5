/* SPDX-License-Identifier: Apache-2.0 */
/* What extensions chain to the geometries of a shape. */
#include "shape.h"

static void fill_motion(VkAccelerationStructureGeometryMotionTrianglesDataNV *motion,
                        const struct scene *scene)
{
    *motion = MAKE(VkAccelerationStructureGeometryMotionTrianglesDataNV,
                   .vertexData.deviceAddress = scene->boxes.address);
}

/* Spheres and linear swept spheres share these members. */
#define SPHERES_OF(scene)                                                                          \
    .vertexFormat = VK_FORMAT_R32G32B32_SFLOAT,                                                    \
    .vertexData.deviceAddress = (scene)->vertices.address, .vertexStride = 12,                     \
    .radiusFormat = VK_FORMAT_R32_SFLOAT, .radiusData.deviceAddress = (scene)->boxes.address,      \
    .radiusStride = 4, .indexType = VK_INDEX_TYPE_UINT32,                                          \
    .indexData.deviceAddress = (scene)->indices.address, .indexStride = 4

static void fill_spheres(VkAccelerationStructureGeometrySpheresDataNV *spheres,
                         const struct scene *scene)
{
    *spheres = MAKE(VkAccelerationStructureGeometrySpheresDataNV, SPHERES_OF(scene));
}

static void fill_swept(VkAccelerationStructureGeometryLinearSweptSpheresDataNV *swept,
                       const struct scene *scene)
{
    *swept = MAKE(VkAccelerationStructureGeometryLinearSweptSpheresDataNV, SPHERES_OF(scene),
                  .indexingMode = VK_RAY_TRACING_LSS_INDEXING_MODE_SUCCESSIVE_NV);
}

static void fill_dense(VkAccelerationStructureDenseGeometryFormatTrianglesDataAMDX *dense,
                       const struct scene *scene, const struct shape *shape)
{
    *dense =
        MAKE(VkAccelerationStructureDenseGeometryFormatTrianglesDataAMDX,
             .compressedData.deviceAddress = scene->boxes.address, .dataSize = shape->dense.size,
             .numTriangles = shape->dense.triangles, .numVertices = shape->dense.vertices,
             .maxPrimitiveIndex = shape->dense.max_primitive,
             .maxGeometryIndex = shape->dense.max_geometry,
             .format = VK_COMPRESSED_TRIANGLE_FORMAT_DGF1_AMDX);
}

void shape_fill_extension(struct shape_arguments *arguments, uint32_t index,
                          const struct scene *scene, const struct shape *shape)
{
    VkAccelerationStructureGeometryKHR *geometry = &arguments->geometries[index];
    switch ((int)shape->geometry_type) {
    case VK_GEOMETRY_TYPE_TRIANGLES_KHR:
        if (!shape->moves)
            return;
        fill_motion(&arguments->chained[index].motion, scene);
        geometry->geometry.triangles.pNext = &arguments->chained[index];
        return;
    case VK_GEOMETRY_TYPE_SPHERES_NV:
        fill_spheres(&arguments->chained[index].spheres, scene);
        break;
    case VK_GEOMETRY_TYPE_LINEAR_SWEPT_SPHERES_NV:
        fill_swept(&arguments->chained[index].swept, scene);
        break;
    case VK_GEOMETRY_TYPE_DENSE_GEOMETRY_FORMAT_TRIANGLES_AMDX:
        fill_dense(&arguments->chained[index].dense, scene, shape);
        break;
    default:
        return;
    }
    geometry->pNext = &arguments->chained[index];
}
