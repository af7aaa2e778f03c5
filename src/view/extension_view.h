/* SPDX-License-Identifier: Apache-2.0 */
/* The views of what extensions add to builds and geometries; made only where the extension is
 * enabled. */
#ifndef ASSAY_VIEW_EXTENSION_VIEW_H
#define ASSAY_VIEW_EXTENSION_VIEW_H

#include <vulkan/vulkan.h>

#include "src/view/view.h"

/* VK_NV_ray_tracing_motion_blur. A build, and triangles that have or lack motion. */
struct motion_build_view {
    const struct build_view *build;
};

struct motion_triangles_view {
    const struct geometry_view *geometry;
    const VkAccelerationStructureGeometryMotionTrianglesDataNV *data; /* or NULL */
};

/* An instance of a build with motion, as it was read. */
struct motion_instance_view {
    const struct geometry_view *geometry;
    uint32_t index;
    bool is_packed; /* the data alone was given, and the type in the pointer to it */
    VkAccelerationStructureMotionInstanceNV instance;
    struct accel_facts referenced; /* what it refers to; nothing is known of references of 0 */
};

/* VK_NV_ray_tracing_linear_swept_spheres. What both of its structures have. */
struct sphere_data {
    const struct geometry_view *geometry;
    bool missing; /* the structure certainly isn't there, though geometryType needs it */
    bool given;   /* it is there, and says: */
    VkFormat vertex_format, radius_format;
    VkDeviceSize vertex_stride, radius_stride, index_stride; /* bytes */
    VkIndexType index_type;
    VkDeviceOrHostAddressConstKHR vertices, radii, indices;

    /* From level STATE on. */
    enum tristate vertex_format_supported, radius_format_supported;
    /* Host builds: an address that is given but can't be read. */
    bool vertices_unreadable, radii_unreadable, indices_unreadable;
};

struct spheres_view {
    struct sphere_data data;
};

struct swept_spheres_view {
    struct sphere_data data;
    VkRayTracingLssIndexingModeNV indexing_mode;
    VkRayTracingLssPrimitiveEndCapsModeNV end_caps_mode;
};

/* VK_AMDX_dense_geometry_format. A build that has such geometries, and one of them. */
struct dense_build_view {
    const struct build_view *build;
};

struct dense_view {
    const struct geometry_view *geometry;
    bool missing; /* the structure certainly isn't there, though geometryType needs it */
    const VkAccelerationStructureDenseGeometryFormatTrianglesDataAMDX *data; /* or NULL */
    const struct address_facts *address; /* from level STATE on, of device builds; else NULL */
};

/* Such a geometry of an update, and that of its source. */
struct updated_dense_view {
    const struct update_view *update;
    const struct dense_shape *asked, *source;
};

/* Whether a build reads none of the data: as geometry_is_empty, of geometries that have their count
 * here. */
static inline bool
dense_is_empty(const VkAccelerationStructureDenseGeometryFormatTrianglesDataAMDX *data)
{
    return !data->numTriangles || !data->dataSize;
}

static inline bool dense_format_is_known(VkCompressedTriangleFormatAMDX format)
{
    return format == VK_COMPRESSED_TRIANGLE_FORMAT_DGF1_AMDX;
}

#endif
