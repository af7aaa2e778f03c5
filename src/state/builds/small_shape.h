/* SPDX-License-Identifier: Apache-2.0 */
/* The shape of a build of at most one geometry: what its sizes depend on.
 *
 * vkGetAccelerationStructureBuildSizesKHR ignores addresses, src, dst and mode, except whether
 * transformData is null (Vulkan specification, VkAccelerationStructureBuildSizesInfoKHR). */
#ifndef ASSAY_STATE_BUILDS_SMALL_SHAPE_H
#define ASSAY_STATE_BUILDS_SMALL_SHAPE_H

#include <stdbool.h>
#include <stdint.h>
#include <vulkan/vulkan_core.h>

#include "src/state/builds/build_info.h"

/* Has no padding, so that its bytes can be hashed. Members are 0 if there is no geometry, or if its
 * type lacks the member. */
struct small_shape {
    uint32_t build_type, type, flags, geometry_count;
    struct shape_geometry {
        uint64_t stride;
        uint32_t type, flags, primitive_count;
        uint32_t vertex_format, max_vertex, index_type;
        uint32_t has_transform, array_of_pointers;
    } first;
};

/* Compares member by member, so that the compiler need not write a shape to memory only to compare
 * it. */
static inline bool small_shapes_are_equal(const struct small_shape *a, const struct small_shape *b)
{
    const struct shape_geometry *x = &a->first, *y = &b->first;
    uint32_t different =
        (a->build_type ^ b->build_type) | (a->type ^ b->type) | (a->flags ^ b->flags) |
        (a->geometry_count ^ b->geometry_count) | (x->type ^ y->type) | (x->flags ^ y->flags) |
        (x->primitive_count ^ y->primitive_count) | (x->vertex_format ^ y->vertex_format) |
        (x->max_vertex ^ y->max_vertex) | (x->index_type ^ y->index_type) |
        (x->has_transform ^ y->has_transform) | (x->array_of_pointers ^ y->array_of_pointers);
    return !different && x->stride == y->stride;
}

/* These two functions return false if there is a chain, whose effect on the sizes is unknown. */
static inline bool shape_of_geometry(const VkAccelerationStructureGeometryKHR *geometry,
                                     uint32_t primitive_count, struct shape_geometry *shape)
{
    *shape = (struct shape_geometry){.type = (uint32_t)geometry->geometryType,
                                     .flags = geometry->flags,
                                     .primitive_count = primitive_count};
    if (geometry->pNext)
        return false;
    if (geometry->geometryType == VK_GEOMETRY_TYPE_TRIANGLES_KHR) {
        const VkAccelerationStructureGeometryTrianglesDataKHR *t = &geometry->geometry.triangles;
        shape->stride = t->vertexStride;
        shape->vertex_format = (uint32_t)t->vertexFormat;
        shape->max_vertex = t->maxVertex;
        shape->index_type = (uint32_t)t->indexType;
        shape->has_transform = t->transformData.deviceAddress != 0;
        return !t->pNext;
    }
    if (geometry->geometryType == VK_GEOMETRY_TYPE_AABBS_KHR) {
        shape->stride = geometry->geometry.aabbs.stride;
        return !geometry->geometry.aabbs.pNext;
    }
    if (geometry->geometryType == VK_GEOMETRY_TYPE_INSTANCES_KHR) {
        shape->array_of_pointers = geometry->geometry.instances.arrayOfPointers != 0;
        return !geometry->geometry.instances.pNext;
    }
    return false;
}

/* Gets the shape of a build with its first geometry only. */
static inline bool small_shape_of(const VkAccelerationStructureBuildGeometryInfoKHR *info,
                                  const uint32_t *primitive_counts,
                                  VkAccelerationStructureBuildTypeKHR build_type,
                                  struct small_shape *shape)
{
    *shape = (struct small_shape){.build_type = (uint32_t)build_type,
                                  .type = (uint32_t)info->type,
                                  .flags = info->flags,
                                  .geometry_count = info->geometryCount};
    if (info->pNext)
        return false;
    return !info->geometryCount ||
           shape_of_geometry(build_geometry(info, 0), primitive_counts[0], &shape->first);
}

#endif
