/* SPDX-License-Identifier: Apache-2.0 */
/* The views of input data at level `content`. Each view holds a copy of the data as it was read. */
#ifndef ASSAY_VIEW_CONTENT_VIEW_H
#define ASSAY_VIEW_CONTENT_VIEW_H

#include "src/state/resources/resources.h"
#include "src/view/view.h"

/* The vertices that the indices of a triangle geometry use. */
struct indices_view {
    const struct geometry_view *geometry;
    const VkAccelerationStructureBuildRangeInfoKHR *range;
    uint32_t max_vertex;
    /* is_beyond: an index exceeds maxVertex minus firstVertex. `primitive` and `index` describe the
     * first such index. */
    bool is_beyond;
    uint32_t primitive, index;
    uint64_t consumed; /* lower bound of the number of different vertices */
    /* How far the vertex of the largest index, `max`, lies behind the end of the buffer of the
     * vertex data, in no other buffer; 0: it does not, or that is unknown. */
    uint32_t max;
    VkBuffer buffer;
    uint64_t past_end;
};

/* A build range that the indirect command read. */
struct indirect_range_view {
    const struct geometry_view *geometry;
    const VkAccelerationStructureBuildRangeInfoKHR *range;
    uint32_t max_primitive_count; /* from ppMaxPrimitiveCounts */
};

/* One VkAabbPositionsKHR. */
struct box_view {
    const struct geometry_view *geometry;
    uint32_t primitive;
    VkAabbPositionsKHR positions;
};

/* A negative radius of a sphere or of a linear swept sphere. */
struct radius_view {
    const struct geometry_view *geometry;
    bool is_swept;
    uint32_t primitive;
    float radius;
};

/* One VkMicromapTriangleKHR of a micromap build. */
struct micromap_triangle_view {
    const struct geometry_view *geometry;
    uint64_t index;
    VkMicromapTriangleKHR triangle;
    uint64_t data_left; /* bytes from `data` to the end of its buffer; 0 if unknown */
};

/* The index through which a triangle uses a micromap of VK_KHR_opacity_micromap. */
struct opacity_index_view {
    const struct geometry_view *geometry;
    uint64_t micromap; /* handle; 0 is VK_NULL_HANDLE */
    /* Whether triangle_count, the triangles that the micromap was built with, is known. */
    bool count_known;
    uint32_t triangle_count;
    uint32_t base_triangle;
    uint32_t primitive;
    uint32_t index; /* raw value of `bits` bits */
    uint32_t bits;
};

/* One VkTransformMatrixKHR of an instance or of a geometry. */
struct transform_view {
    const struct geometry_view *geometry;
    bool is_of_instance;
    uint32_t instance;
    VkTransformMatrixKHR matrix;
};

/* What the application seems to have written where a build reads instances. */
struct data_look {
    enum {
        LOOKS_AS_ASKED,       /* what the build reads; or nothing that is known */
        LOOKS_LIKE_INSTANCES, /* in an array of pointers */
        LOOKS_LIKE_POINTERS,  /* in an array of instances */
        LOOKS_STRIDED,        /* instances that are `stride` bytes apart */
        LOOKS_UNWRITTEN,      /* nothing */
    } kind;
    uint32_t stride;
};

/* One VkAccelerationStructureInstanceKHR. */
struct instance_view {
    const struct geometry_view *geometry;
    uint32_t index;
    bool has_motion; /* the instance is a member of a VkAccelerationStructureMotionInstanceNV */
    VkAccelerationStructureInstanceKHR instance;
    /* Whether the referenced structure's last build before this one allows disabling micromaps. */
    enum tristate allows_disabling;
    const struct accel_facts *referenced; /* the structure; unknown if the reference is 0 */
    /* If there is none: the structure whose handle is the reference of a device build, or whose
     * address that of a host build; or NULL. */
    VkAccelerationStructureKHR confused;
    struct data_look look; /* if there is none */
    bool may_be_placed;    /* if there is none: one without a handle may have been built there */
};

/* An instance of VK_NV_ray_tracing whose reference is not 0. */
struct nv_instance_view {
    const struct geometry_view *geometry;
    uint32_t index;
    uint64_t reference;
    enum nv_reference refers_to;
    bool is_handle; /* the reference is the handle of a live VkAccelerationStructureNV */
    const VkAccelerationStructureInstanceKHR *instance;
    struct data_look look; /* if the reference is nothing */
};

/* One address in an array of pointers to instances. */
struct instance_pointer_view {
    const struct geometry_view *geometry;
    uint32_t index;
    VkDeviceAddress address;
    bool leads_nowhere;    /* no memory that the build could read was there */
    bool is_host;          /* it is an address of the host */
    struct data_look look; /* if the address is not aligned */
};

/* A live structure that an instance of any kind references. */
struct reference_view {
    const struct geometry_view *geometry;
    uint32_t instance;
    const struct accel_facts *referenced;
};

/* The instances of a build that refer to live structures without contents: to structures that
 * nothing was built into, or copied to, before that build. */
struct unbuilt_view {
    const struct geometry_view *geometry;
    uint64_t instance_count;
    uint32_t structure_count; /* 0: no such instance is known */
    /* The first such instance, its structure, and whether the structure was built later. */
    uint32_t first;
    const struct accel_facts *referenced;
    bool is_built_later;
};

#endif
