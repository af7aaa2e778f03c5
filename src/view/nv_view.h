/* SPDX-License-Identifier: Apache-2.0 */
/* The views that rules get of vkCmdBuildAccelerationStructureNV. The contract is that of
 * src/view/view.h. */
#ifndef ASSAY_VIEW_NV_VIEW_H
#define ASSAY_VIEW_NV_VIEW_H

#include "src/model/build_parameters.h"
#include "src/state/resources/nv_shape.h"
#include "src/view/view.h"

/* The parameters of the call. */
struct nv_call_view {
    const struct call_view *call;
    const VkAccelerationStructureInfoNV *info_argument;
    const VkAccelerationStructureInfoNV *info; /* info_argument, or NULL if it is not readable */
    VkBuffer instance_data;
    VkDeviceSize instance_offset;
    bool update;
    VkAccelerationStructureNV dst, src;
    VkBuffer scratch;
    VkDeviceSize scratch_offset;

    /* The geometries of `info`; geometry_count is 0 if the array is not readable, or without
     * memory. */
    const VkGeometryNV *geometries;
    uint32_t geometry_count;
    bool geometries_unreadable;
    /* This build in the structures of VK_KHR_acceleration_structure. Its addresses are no real
     * ones: an address that is not 0 says that the data is given. `info` is NULL if anything cannot
     * be read, or if memory runs out. */
    struct build_view build;

    /* From level STATE on. */
    struct nv_accel_facts dst_facts, src_facts;
    struct buffer_facts scratch_facts, instance_facts;
};

/* pInfo. */
struct nv_info_view {
    const struct nv_call_view *call;
    const VkAccelerationStructureInfoNV *info;
    uint64_t triangle_count; /* in all geometries */
    /* Index of the first geometry whose type differs from the first geometry's; geometry_count
     * of the call if there is none. */
    uint32_t first_other_type;
};

/* One geometry of pInfo. */
struct nv_geometry_view {
    const struct nv_call_view *call;
    uint32_t index;
    const VkGeometryNV *geometry;
    /* The member that geometryType selects, if its sType agrees. NULL otherwise. */
    const VkGeometryTrianglesNV *triangles;
    const VkGeometryAABBNV *aabbs;

    /* The geometry in the call's `build`. */
    struct geometry_view translated;
    struct nv_place places[NV_PLACES];

    /* By role. From level STATE on; `alive` is UNKNOWN if the geometry has no such buffer. */
    struct buffer_facts found[NV_PLACES];
};

/* As geometry_is_empty(). Rules still validate the handles of an empty geometry, which are
 * parameters. */
static inline bool nv_geometry_is_empty(const struct nv_geometry_view *geometry)
{
    const VkGeometryTrianglesNV *triangles = geometry->triangles;
    if (triangles && triangles->indexType != VK_INDEX_TYPE_NONE_NV)
        return !triangles->indexCount;
    return triangles ? !triangles->vertexCount : geometry->aabbs && !geometry->aabbs->numAABBs;
}

#endif
