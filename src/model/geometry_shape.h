/* SPDX-License-Identifier: Apache-2.0 */
/* What a geometry is, apart from its data: what the sizes of its build depend on, and what an
 * update has to repeat. */
#ifndef ASSAY_MODEL_GEOMETRY_SHAPE_H
#define ASSAY_MODEL_GEOMETRY_SHAPE_H

#include "src/model/geometry.h"
#include "src/model/inputs.h"

/* Members are 0 if the type lacks them. There is no padding, so that the bytes can be hashed. */
struct geometry_shape {
    VkDeviceSize stride; /* of vertices or AABBs */
    VkGeometryTypeKHR type;
    VkGeometryFlagsKHR flags;
    VkFormat vertex_format;
    uint32_t max_vertex;
    VkIndexType index_type;
    uint32_t primitive_count;
    bool has_transform, has_pointers;
    bool count_known; /* false for the indirect command, whose counts are in device memory */
    unsigned char unused[5];
};
_Static_assert(sizeof(struct geometry_shape) == 40, "no padding");

/* `count` may be NULL: it is unknown. */
static inline struct geometry_shape
geometry_shape_of(const VkAccelerationStructureGeometryKHR *geometry, const uint32_t *count)
{
    const VkAccelerationStructureGeometryTrianglesDataKHR *triangles =
        &geometry->geometry.triangles;
    struct geometry_shape shape = {.type = geometry->geometryType, .flags = geometry->flags};
    shape.count_known = count;
    shape.primitive_count = count ? *count : 0;
    if (type_is_triangles(geometry->geometryType)) {
        shape.stride = triangles->vertexStride;
        shape.vertex_format = triangles->vertexFormat;
        shape.max_vertex = triangles->maxVertex;
        shape.index_type = triangles->indexType;
        shape.has_transform = input_address(geometry, INPUT_MATRIX) != 0;
    } else if (type_is_aabbs(geometry->geometryType)) {
        shape.stride = geometry->geometry.aabbs.stride;
    }
    shape.has_pointers = has_instance_pointers(geometry);
    return shape;
}

#endif
