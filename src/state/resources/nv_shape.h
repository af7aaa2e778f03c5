/* SPDX-License-Identifier: Apache-2.0 */
/* What a structure of VK_NV_ray_tracing was created for: as much of its
 * VkAccelerationStructureInfoNV as builds into it are measured by. */
#ifndef ASSAY_STATE_RESOURCES_NV_SHAPE_H
#define ASSAY_STATE_RESOURCES_NV_SHAPE_H

#include <stdatomic.h>
#include <stdint.h>
#include <vulkan/vulkan_core.h>

/* What a geometry has; 0 of what its type has none of. */
struct nv_counts {
    uint32_t vertices, indices, aabbs;
};

struct nv_counts nv_counts_of(const VkGeometryNV *geometry);

/* Immutable once made; freed with its last reference. */
struct nv_shape {
    atomic_uint references;
    VkAccelerationStructureTypeNV type;
    VkBuildAccelerationStructureFlagsNV flags;
    uint32_t instance_count, geometry_count;
    struct nv_counts geometries[];
};

/* NULL without memory, or where the application's geometries can't be read. */
struct nv_shape *nv_shape_create(const VkAccelerationStructureInfoNV *info);

/* Each accepts NULL. */
struct nv_shape *nv_shape_share(struct nv_shape *shape);
void nv_shape_release(struct nv_shape *shape);

#endif
