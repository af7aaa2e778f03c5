/* SPDX-License-Identifier: Apache-2.0 */
/* The views of what extensions add to builds and geometries; made only where the extension is
 * enabled. */
#ifndef ASSAY_CHECK_EXTENSION_VIEW_H
#define ASSAY_CHECK_EXTENSION_VIEW_H

#include <vulkan/vulkan.h>

#include "check/view.h"

/* VK_NV_ray_tracing_motion_blur. A build, and triangles that have or lack motion. */
struct motion_build_view {
    const struct build_view *build;
};

struct motion_triangles_view {
    const struct geometry_view *geometry;
    const VkAccelerationStructureGeometryMotionTrianglesDataNV *data; /* or NULL */
};

#endif
