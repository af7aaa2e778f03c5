/* SPDX-License-Identifier: Apache-2.0 */
/* The views of what extensions add to builds and geometries. A view is created only if its
 * extension is enabled. */
#ifndef ASSAY_VIEW_EXTENSION_VIEW_H
#define ASSAY_VIEW_EXTENSION_VIEW_H

#include <vulkan/vulkan.h>

#include "src/model/chained_input.h"
#include "src/view/view.h"

/* VK_NV_ray_tracing_motion_blur: a build, and a triangle geometry with or without motion data. */
struct motion_build_view {
    const struct build_view *build;
    /* From level STATE on, if dst was created without motion: the index of the first geometry with
     * motion data, or geometry_count. Otherwise geometry_count. */
    uint32_t first_motion_geometry;
};

struct motion_triangles_view {
    const struct geometry_view *geometry;
    /* At the end of the motion; NULL if the geometry has no motion data. */
    const VkDeviceOrHostAddressConstKHR *vertices;
};

/* An instance of a build with motion. `instance` is a copy of the data. */
struct motion_instance_view {
    const struct geometry_view *geometry;
    uint32_t index;
    bool is_packed; /* the application gave only the data; its type is in the pointer */
    VkAccelerationStructureMotionInstanceNV instance;
    const struct accel_facts *referenced; /* the structure; unknown if the reference is 0 */
};

/* VK_NV_ray_tracing_linear_swept_spheres: what both of its structures share. */
struct sphere_data {
    const struct geometry_view *geometry;
    bool is_swept;
    bool missing; /* geometryType requires the structure, and the chain certainly lacks it */
    bool given;   /* the chain has the structure; the members below are valid */
    struct chained_input chained; /* its `spheres` */

    /* From level STATE on. */
    enum tristate vertex_format_supported, radius_format_supported;
    /* Host builds: bits 1 << role of the addresses that are not NULL and not readable. */
    uint32_t unreadable;
};

struct spheres_view {
    const struct sphere_data *data;
};

struct swept_spheres_view {
    const struct sphere_data *data;
};

/* VK_AMDX_dense_geometry_format: a build that has dense geometries, and one dense geometry. */
struct dense_build_view {
    const struct build_view *build;
};

struct dense_view {
    const struct geometry_view *geometry;
    bool missing; /* geometryType requires the structure, and the chain certainly lacks it */
    /* NULL if the chain lacks it. */
    const VkAccelerationStructureDenseGeometryFormatTrianglesDataAMDX *data;
    const struct address_facts *address; /* from level STATE on in device builds; otherwise NULL */
};

/* A dense geometry of an update, and the geometry of the same index that its source was built
 * with. */
struct updated_dense_view {
    const struct update_view *update;
    const struct dense_shape *requested, *source;
};

/* Returns whether a build reads no data of a dense geometry. As geometry_is_empty(), for geometries
 * that have their count in this structure. */
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
