/* SPDX-License-Identifier: Apache-2.0 */
/* What an acceleration structure of VK_NV_ray_tracing was created for: the part of its
 * VkAccelerationStructureInfoNV that limits the builds into it. */
#ifndef ASSAY_STATE_RESOURCES_NV_SHAPE_H
#define ASSAY_STATE_RESOURCES_NV_SHAPE_H

#include <stdatomic.h>
#include <stdint.h>
#include <vulkan/vulkan_core.h>

/* The counts of a geometry; 0 for counts that its type lacks. */
struct nv_counts {
    uint32_t vertices, indices, aabbs;
};

/* Returns the counts of a geometry. */
struct nv_counts nv_counts_of(const VkGeometryNV *geometry);

/* Immutable. Reference counted: freed with the last reference. Any thread may share and release
 * it. */
struct nv_shape {
    atomic_uint references;
    VkAccelerationStructureTypeNV type;
    VkBuildAccelerationStructureFlagsNV flags;
    uint32_t instance_count, geometry_count;
    struct nv_counts geometries[];
};

/* Copies `info`; the caller owns one reference. Returns NULL if there is no memory or if the
 * application's geometries can't be read. */
struct nv_shape *nv_shape_create(const VkAccelerationStructureInfoNV *info);

/* nv_shape_share() adds a reference, nv_shape_release() drops one. Both accept NULL. */
struct nv_shape *nv_shape_share(struct nv_shape *shape);
void nv_shape_release(struct nv_shape *shape);

#endif
