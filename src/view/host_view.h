/* SPDX-License-Identifier: Apache-2.0 */
/* The views that only vkBuildAccelerationStructuresKHR needs: builds with scratch in host memory,
 * and geometries with data in host memory. */
#ifndef ASSAY_VIEW_HOST_VIEW_H
#define ASSAY_VIEW_HOST_VIEW_H

#include "src/view/view.h"

/* Bytes that a host build reads. If the primitive count is 0 or unknown, only `address` is
 * valid. */
struct host_bytes {
    const void *address; /* as the application gave it */
    /* `address` is not NULL, and some of `size` bytes from `begin` on are neither readable nor
     * mapped device memory. */
    bool unreadable;
    uint64_t begin, size;
};

struct host_build_view {
    const struct build_view *build;
    struct host_bytes scratch;
};

struct host_geometry_view {
    const struct geometry_view *geometry;
    /* `unreadable` is false for inputs that the geometry lacks. */
    struct host_bytes vertices, indices, transform, data; /* data: AABBs or instances */
};

#endif
