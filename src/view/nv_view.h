/* SPDX-License-Identifier: Apache-2.0 */
/* The views of vkCmdBuildAccelerationStructureNV that rules get, as src/view/view.h says of those
 * of the other commands. */
#ifndef ASSAY_VIEW_NV_VIEW_H
#define ASSAY_VIEW_NV_VIEW_H

#include "src/state/resources/nv_shape.h"
#include "src/view/view.h"

/* The parameters of the call. */
struct nv_call_view {
    const struct call_view *call;
    const VkAccelerationStructureInfoNV *info_argument;
    const VkAccelerationStructureInfoNV *info; /* the same, or NULL where it can't be read */
    VkBuffer instance_data;
    bool update;
    VkAccelerationStructureNV dst, src;
    VkBuffer scratch;
    VkDeviceSize scratch_offset;

    /* Of `info`: its geometries, geometry_count elements; 0 where they can't be read. */
    const VkGeometryNV *geometries;
    uint32_t geometry_count;
    bool geometries_unreadable;

    /* From level STATE on. */
    struct nv_accel_facts dst_facts, src_facts;
    struct buffer_facts scratch_facts, instance_facts;
};

/* pInfo. */
struct nv_info_view {
    const struct nv_call_view *call;
    const VkAccelerationStructureInfoNV *info;
    uint64_t triangle_count;   /* in all geometries */
    uint32_t first_other_type; /* index of the first geometry whose type is not the first's; or
                                  geometry_count of the call */
};

/* One geometry of it. */
struct nv_geometry_view {
    const struct nv_call_view *call;
    uint32_t index;
    const VkGeometryNV *geometry;
    /* The member that geometryType selects, where its sType agrees; NULL: the other. */
    const VkGeometryTrianglesNV *triangles;
    const VkGeometryAABBNV *aabbs;

    /* From level STATE on; alive UNKNOWN where the geometry has no such buffer. */
    struct buffer_facts vertex, index_data, transform, boxes;
};

/* As geometry_is_empty. Handles are validated all the same: they are parameters. */
static inline bool nv_geometry_is_empty(const struct nv_geometry_view *geometry)
{
    const VkGeometryTrianglesNV *triangles = geometry->triangles;
    if (triangles && triangles->indexType != VK_INDEX_TYPE_NONE_NV)
        return !triangles->indexCount;
    return triangles ? !triangles->vertexCount : geometry->aabbs && !geometry->aabbs->numAABBs;
}

#endif
