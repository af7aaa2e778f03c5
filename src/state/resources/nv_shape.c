/* SPDX-License-Identifier: Apache-2.0 */
/* Reference-counted copies of VkAccelerationStructureInfoNV. */
#include "src/state/resources/nv_shape.h"

#include <stdlib.h>
#include <string.h>

#include "src/base/readable.h"

struct nv_counts nv_counts_of(const VkGeometryNV *geometry)
{
    const VkGeometryTrianglesNV *triangles = &geometry->geometry.triangles;
    if (geometry->geometryType == VK_GEOMETRY_TYPE_TRIANGLES_NV)
        return (struct nv_counts){.vertices = triangles->vertexCount,
                                  .indices = triangles->indexCount};
    if (geometry->geometryType == VK_GEOMETRY_TYPE_AABBS_NV)
        return (struct nv_counts){.aabbs = geometry->geometry.aabbs.numAABBs};
    return (struct nv_counts){0};
}

struct nv_shape *nv_shape_create(const VkAccelerationStructureInfoNV *info)
{
    struct readable_cache readable_pages = {0};
    size_t count = info->geometryCount;
    if (!readable(&readable_pages, info->pGeometries, count * sizeof(*info->pGeometries)))
        return NULL;
    struct nv_shape *shape = malloc(sizeof(*shape) + count * sizeof(shape->geometries[0]));
    if (!shape)
        return NULL;
    atomic_init(&shape->references, 1);
    shape->type = info->type;
    shape->flags = info->flags;
    shape->instance_count = info->instanceCount;
    shape->geometry_count = info->geometryCount;
    for (size_t i = 0; i < count; i++) {
        VkGeometryNV geometry; /* the application's array may be misaligned */
        memcpy(&geometry, &info->pGeometries[i], sizeof(geometry));
        shape->geometries[i] = nv_counts_of(&geometry);
    }
    return shape;
}

struct nv_shape *nv_shape_share(struct nv_shape *shape)
{
    if (shape)
        atomic_fetch_add_explicit(&shape->references, 1, memory_order_relaxed);
    return shape;
}

void nv_shape_release(struct nv_shape *shape)
{
    /* Acquire and release: the thread that frees the shape must see the other threads' accesses
     * done. */
    if (shape && atomic_fetch_sub_explicit(&shape->references, 1, memory_order_acq_rel) == 1)
        free(shape);
}
