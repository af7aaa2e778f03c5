/* SPDX-License-Identifier: Apache-2.0 */
/* The views of what only vkBuildAccelerationStructuresKHR has: builds whose scratch, and geometries
 * whose data, is in host memory. */
#ifndef ASSAY_VIEW_HOST_VIEW_H
#define ASSAY_VIEW_HOST_VIEW_H

#include "src/view/view.h"

/* Bytes that the host's build reads. Without a count of primitives, or with none, only that there
 * is an address is known. */
struct host_bytes {
    const void *address; /* as the application gave it */
    bool unreadable;     /* it is given, and `size` bytes from `begin` on can't be read */
    uint64_t begin, size;
};

struct host_build_view {
    const struct build_view *build;
    struct host_bytes scratch;
};

struct host_geometry_view {
    const struct geometry_view *geometry;
    /* Those that the geometry doesn't have are not unreadable. */
    struct host_bytes vertices, indices, transform, data; /* data: AABBs or instances */
};

#endif
