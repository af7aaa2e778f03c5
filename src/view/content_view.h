/* SPDX-License-Identifier: Apache-2.0 */
/* The views of input data, as it was read; made only at level CONTENT. */
#ifndef ASSAY_VIEW_CONTENT_VIEW_H
#define ASSAY_VIEW_CONTENT_VIEW_H

#include "src/state/resources/resources.h"
#include "src/view/view.h"

/* The vertices that a geometry of triangles uses. */
struct indices_view {
    const struct geometry_view *geometry;
    const VkAccelerationStructureBuildRangeInfoKHR *range;
    uint32_t max_vertex;
    /* The first primitive with an index beyond maxVertex less firstVertex, and that index. */
    bool is_beyond;
    uint32_t primitive, index;
    uint64_t consumed; /* that many different vertices at least */
};

/* A build range that the indirect command has read. */
struct indirect_range_view {
    const struct geometry_view *geometry;
    const VkAccelerationStructureBuildRangeInfoKHR *range;
    uint32_t max_primitive_count; /* of ppMaxPrimitiveCounts */
};

/* One VkAabbPositionsKHR. */
struct box_view {
    const struct geometry_view *geometry;
    uint32_t primitive;
    VkAabbPositionsKHR positions;
};

/* The radius of a sphere, or one of a linear swept sphere, that is less than 0. */
struct radius_view {
    const struct geometry_view *geometry;
    bool is_swept;
    uint32_t primitive;
    float radius;
};

/* One VkMicromapTriangleKHR of a build of a micromap. */
struct micromap_triangle_view {
    const struct geometry_view *geometry;
    uint64_t index;
    VkMicromapTriangleKHR triangle;
    uint64_t data_left; /* bytes from `data` to the end of its buffer; 0: not known */
};

/* An index by which a triangle uses a micromap of VK_KHR_opacity_micromap. */
struct opacity_index_view {
    const struct geometry_view *geometry;
    uint64_t micromap; /* a handle; 0: null */
    bool count_known;  /* of the triangles that the micromap was built with: */
    uint32_t triangle_count;
    uint32_t base_triangle;
    uint32_t primitive;
    uint32_t index; /* as it is, of so many bits: */
    uint32_t bits;
};

/* One VkTransformMatrixKHR: of an instance, or of a geometry. */
struct transform_view {
    const struct geometry_view *geometry;
    bool is_of_instance;
    uint32_t instance;
    VkTransformMatrixKHR matrix;
};

/* One VkAccelerationStructureInstanceKHR. */
struct instance_view {
    const struct geometry_view *geometry;
    uint32_t index;
    bool has_motion; /* it is a member of a VkAccelerationStructureMotionInstanceNV */
    VkAccelerationStructureInstanceKHR instance;
    enum tristate allows_disabling; /* of micromaps: with what it refers to was built, by then */
    struct accel_facts referenced;  /* what it refers to; nothing is known of references of 0 */
};

/* An instance of VK_NV_ray_tracing that refers to something. */
struct nv_instance_view {
    const struct geometry_view *geometry;
    uint32_t index;
    uint64_t reference;
    enum nv_reference refers_to;
};

/* One address in an array of pointers to instances. */
struct instance_pointer_view {
    const struct geometry_view *geometry;
    uint32_t index;
    VkDeviceAddress address;
};

/* What an instance of any kind refers to, a structure that is alive. */
struct reference_view {
    const struct geometry_view *geometry;
    uint32_t instance;
    struct accel_facts referenced;
};

#endif
