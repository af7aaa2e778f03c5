/* SPDX-License-Identifier: Apache-2.0 */
/* The reference builder: builds acceleration structures from host memory into host memory.
 *
 * It follows "Acceleration Structures" of the Vulkan specification and calls no Vulkan function;
 * it uses the types of vulkan_core.h for application data. A structure is one block of bytes
 * without pointers, so it can be copied and moved. A TLAS stores the 64-bit reference of each
 * instance's BLAS, and a resolver maps the reference to the address of the block.
 *
 * Units: offsets, strides and sizes are bytes; coordinates are the application's. Offsets are 64
 * bits wide and are compared before they are added, so none wraps. The same input gives the same
 * bytes for any number of threads. Nothing here allocates memory: the caller provides the
 * scratch. */
#ifndef ASSAY_BVH_BVH_H
#define ASSAY_BVH_BVH_H

#include <stdbool.h>
#include <stdint.h>
#include <vulkan/vulkan_core.h>

#include "src/platform/threads.h"

/* The alignment of structures and of scratch. */
#define BUILDER_ALIGNMENT 64
/* The maximum for all geometries of a structure together. */
#define BUILDER_MAX_PRIMITIVES 0x1fffffffu
/* For inputs whose readable size is unknown. */
#define BUILDER_ANY_SIZE UINT64_MAX

enum builder_quality {
    BUILDER_FAST,     /* Morton order (Lauterbach 2009; Karras 2012) */
    BUILDER_BALANCED, /* binned SAH (Wald 2007) */
    BUILDER_HIGH,     /* full-sweep SAH (MacDonald and Booth 1990) */
};

enum builder_result {
    BUILDER_OK,
    BUILDER_UNKNOWN_FORMAT, /* an unknown vertex or index format or geometry type */
    /* An index or a range exceeds its data. Nothing was read there. */
    BUILDER_INPUT_OUT_OF_RANGE,
    BUILDER_TOO_MANY_PRIMITIVES,
    /* The structure, the scratch or the serialized data is too small. */
    BUILDER_TOO_SMALL,
    /* The refit has another shape than its source, or the bytes are not a structure of this
     * builder. */
    BUILDER_INCOMPATIBLE,
};

/* Reads memory at the addresses that the input data contains. `read` returns NULL if the memory is
 * not readable. If `read` itself is NULL, addresses are host pointers. */
struct builder_memory {
    const void *(*read)(void *context, uint64_t address, uint64_t size);
    void *context;
};

/* Maps VkAccelerationStructureInstanceKHR::accelerationStructureReference to the block of the
 * structure. `find` returns NULL if there is none. Builds with several threads call it
 * concurrently. */
struct builder_resolver {
    const void *(*find)(void *context, uint64_t reference);
    void *context;
};

/* VkAccelerationStructureTrianglesOpacityMicromapEXT or ...KHR: maps each triangle of the geometry
 * to a triangle of a micromap. The micromap itself is resolved when rays are traced. */
struct builder_opacity {
    VkIndexType index_type; /* VK_INDEX_TYPE_NONE_KHR: the index is the triangle's own number */
    uint32_t base_triangle;
    const void *indices;
    uint64_t indices_size, stride;
    uint64_t micromap; /* reference; 0 if none: then all indices must be special */
};

/* VkAccelerationStructureTrianglesDisplacementMicromapNV: each triangle is split into
 * microtriangles, whose vertices follow "Displacement Base Triangle" of the specification. The
 * vertex index, plus firstVertex of the range, selects the vector and the bias and scale, of which
 * the first two components count. Displacement precedes the geometry's transform.
 *
 * The specification does not define the following behaviour of this builder. A triangle with a
 * special index (-1 to -4) or without a micromap stays undisplaced. Each flag is a byte; bit 0
 * stands for the edge between vertices 0 and 1, bit 1 for 1 and 2, bit 2 for 2 and 0. Every second
 * vertex of a flagged edge moves to its neighbour towards the nearer end of the edge
 * (displacement.h lists the sources). */
struct builder_displacement {
    uint32_t usage_count;
    const VkMicromapUsageEXT *usages; /* determines the sizes: the maximum number of triangles */
    VkFormat vector_format, bias_and_scale_format; /* the same formats as for vertices */
    VkIndexType index_type; /* VK_INDEX_TYPE_NONE_KHR: the index is the triangle's own number */
    uint32_t base_triangle;
    /* If biases_and_scales is NULL, the bias is 0 and the scale 1. If `flags` is NULL, no flag
     * is set. */
    const void *vectors, *biases_and_scales, *flags, *indices;
    uint64_t vectors_size, biases_and_scales_size, flags_size, indices_size;
    uint64_t vector_stride, bias_and_scale_stride, flags_stride, index_stride;
    uint64_t micromap; /* reference that the build resolves; 0 if none */
};

/* VkAccelerationStructureGeometryTrianglesDataKHR. Each size is the readable size in bytes from its
 * pointer on. `indices` is unused with VK_INDEX_TYPE_NONE_KHR; `transforms` may be NULL. */
struct builder_triangles {
    VkFormat vertex_format;
    VkIndexType index_type;
    uint32_t max_vertex;
    uint64_t vertex_stride;
    const void *vertices, *indices, *transforms;
    uint64_t vertices_size, indices_size, transforms_size;
    /* VkAccelerationStructureGeometryMotionTrianglesDataNV, in builds with motion: the positions at
     * time 1 in the layout of `vertices`; NULL if the geometry is static. */
    const void *motion_vertices;
    uint64_t motion_vertices_size;
    /* NULL if none. A size query tests only whether the pointer is NULL. */
    const struct builder_opacity *opacity;
    /* NULL if none. A size query also reads the usages. */
    const struct builder_displacement *displacement;
};

/* VkAccelerationStructureGeometryAabbsDataKHR */
struct builder_aabbs {
    const void *data;
    uint64_t size, stride;
};

/* VkAccelerationStructureGeometrySpheresDataNV and, with the last two members,
 * VkAccelerationStructureGeometryLinearSweptSpheresDataNV. */
struct builder_spheres {
    VkFormat vertex_format, radius_format; /* radius formats: R32_SFLOAT and R16_SFLOAT */
    VkIndexType index_type;
    const void *vertices, *radii, *indices;
    uint64_t vertices_size, radii_size, indices_size;
    uint64_t vertex_stride, radius_stride, index_stride;
    VkRayTracingLssIndexingModeNV indexing_mode;
    VkRayTracingLssPrimitiveEndCapsModeNV end_caps_mode;
};

/* VkAccelerationStructureDenseGeometryFormatTrianglesDataAMDX: blocks of format DGF1. The range's
 * primitiveCount is numTriangles. The blocks determine the geometry index, the primitive index and
 * the opacity of each hit. The builder reads nothing beyond the given limits. */
struct builder_dense {
    const void *data;
    uint64_t size;
    uint32_t max_primitive;
    /* Indexed by the primitive numbers of the blocks; NULL if none. */
    const struct builder_opacity *opacity;
};

/* VkAccelerationStructureGeometryInstancesDataKHR. In builds with motion, an array holds
 * VkAccelerationStructureMotionInstanceNV with a stride of 160 bytes, and an array of pointers
 * holds the type in the low 4 bits of each pointer. */
struct builder_instances {
    const void *data;
    uint64_t size;
    bool array_of_pointers;
};

struct builder_geometry {
    VkGeometryTypeKHR type; /* the same for all geometries of a structure */
    VkGeometryFlagsKHR flags;
    union {
        struct builder_triangles triangles;
        struct builder_aabbs aabbs;
        struct builder_instances instances;
        struct builder_spheres spheres; /* also for linear swept spheres */
        struct builder_dense dense;
    };
};

/* Threads of the caller that build together, such as the threads that join a deferred operation. A
 * thread that runs a build or a refit names the team in its input. Other threads help:
 * builder_team_help() takes part in jobs until the team is closed; builder_team_help_for_now() also
 * returns if no job comes for a while. Helpers are optional, and may join before, during or after a
 * build. Several threads may run builds with one team at once. The members belong to workers.c. */
struct builder_team {
    pthread_mutex_t lock;
    pthread_cond_t wakeup, done;
    struct builder_team_job *jobs;
    bool is_closed;
};
void builder_team_open(struct builder_team *team);
void builder_team_help(struct builder_team *team);
void builder_team_help_for_now(struct builder_team *team);
/* Releases the helpers; later helpers return at once. No build of the team may be running. */
void builder_team_close(struct builder_team *team);
void builder_team_destroy(struct builder_team *team); /* only after all helpers have returned */

struct builder_input {
    VkAccelerationStructureTypeKHR type; /* bottom or top level */
    /* VK_BUILD_ACCELERATION_STRUCTURE_MOTION_BIT_NV: the primitives of the structure may move. */
    VkBuildAccelerationStructureFlagsKHR flags;
    enum builder_quality quality;
    uint32_t threads;          /* with 0 or 1, the build starts no thread */
    struct builder_team *team; /* if not NULL, `threads` is ignored */
    uint32_t geometry_count;
    const struct builder_geometry *geometries;
    const VkAccelerationStructureBuildRangeInfoKHR *ranges; /* one per geometry */
    struct builder_memory memory;                           /* for arrays of pointers */
    struct builder_resolver resolver;                       /* for instances */
    /* For displacements. A build fails if the resolver does not find a micromap. */
    struct builder_resolver micromaps;
};

/* The position of a primitive in the input. */
struct builder_place {
    uint32_t geometry, primitive;
};

/* The findings of a build in its input. If a count is not 0, the `first` member names the first
 * such primitive in the order of geometry and primitive. */
struct builder_report {
    uint64_t active, inactive; /* counts microtriangles for displaced geometries */
    /* Primitives for which the specification defines no behaviour: NaN in a component other than
     * X, or a negative radius. The build leaves them out. */
    uint64_t undefined;
    struct builder_place first_undefined;
    uint64_t out_of_range;
    struct builder_place first_out_of_range;
    uint64_t unresolved; /* instances with an unresolved reference; left out */
    struct builder_place first_unresolved;
    /* Instances whose 3x3 matrix at time 0 has determinant 0. No ray hits them. */
    uint64_t singular;
    struct builder_place first_singular;
    uint64_t transformed; /* number of positions that a geometry's transform applies to */
};

/* vkGetAccelerationStructureBuildSizesKHR: reads only the types, flags and geometry counts of the
 * input, and `counts` instead of the ranges unless `counts` is NULL. The sizes also suffice for
 * smaller counts. */
struct builder_sizes {
    uint64_t structure, build_scratch, update_scratch;
};
enum builder_result builder_get_sizes(const struct builder_input *input, const uint32_t *counts,
                                      struct builder_sizes *sizes);

/* Builds a structure. Fills `report` in every case; `report` may be NULL. After an error,
 * `structure` holds no valid structure. */
enum builder_result builder_build(const struct builder_input *input, void *structure,
                                  uint64_t structure_size, void *scratch, uint64_t scratch_size,
                                  struct builder_report *report);

/* VK_BUILD_ACCELERATION_STRUCTURE_MODE_UPDATE_KHR: applies new positions or instances to the tree
 * of `source`, which may equal `structure`. Each primitive stays active or inactive as built
 * (03663, 03664). If the subdivision level of a displaced triangle has changed, this is a build,
 * and the sizes must suffice for a build. */
enum builder_result builder_refit(const struct builder_input *input, const void *source,
                                  void *structure, uint64_t structure_size, void *scratch,
                                  uint64_t scratch_size, struct builder_report *report);

/* vkCopyAccelerationStructureKHR: the copies return BUILDER_TOO_SMALL if `target_size` is less than
 * builder_size(), or builder_compacted_size() for compaction. */
uint64_t builder_size(const void *structure); /* size of a clone in bytes */
uint64_t builder_compacted_size(const void *structure);
enum builder_result builder_clone(const void *source, void *target, uint64_t target_size);
enum builder_result builder_compact(const void *source, void *target, uint64_t target_size);

/* The serialized form of the specification: driver UUID and compatibility (16 bytes each),
 * serialized size, deserialized size, number of BLAS references (64 bits each), the references, the
 * structure; all in the host's byte order. To relocate a TLAS, the application overwrites the
 * references. */
struct builder_uuids {
    uint8_t driver[VK_UUID_SIZE], compatibility[VK_UUID_SIZE];
};
uint64_t builder_serialized_size(const void *structure);
/* Returns the number of BLAS references in the serialized form. */
uint64_t builder_reference_count(const void *structure);
enum builder_result builder_serialize(const void *structure, const struct builder_uuids *uuids,
                                      void *bytes, uint64_t size);
/* Reads the first BUILDER_SERIALIZED_HEADER bytes. Returns false if this builder did not write
 * them. */
#define BUILDER_SERIALIZED_HEADER 56u
struct builder_serialized {
    uint64_t size, structure_size, reference_count;
};
bool builder_read_header(const void *bytes, const struct builder_uuids *uuids,
                         struct builder_serialized *serialized);
/* Deserializes untrusted bytes: validates everything that traversal relies on. A relocated TLAS
 * keeps the bounds of the structures that it was built with (the specification requires the new
 * structures to have the same bounds). */
enum builder_result builder_deserialize(const void *bytes, uint64_t size,
                                        const struct builder_uuids *uuids, void *structure,
                                        uint64_t structure_size);

/* ---- properties for tools */

VkAccelerationStructureTypeKHR builder_type(const void *structure);
/* Returns false if the structure is empty. */
bool builder_bounds(const void *structure, float lower[3], float upper[3]);

struct builder_statistics {
    uint64_t nodes, leaves, active;
    uint32_t depth;
    double sah; /* areas relative to the root's: a node costs 1, a primitive in a leaf costs 1 */
};
/* Visits all nodes of the structure. */
void builder_measure(const void *structure, struct builder_statistics *statistics);

/* Returns the exact sign of the determinant of a transform's 3x3 part (03799): -1, 0 or 1. Returns
 * 0 if an element is not finite. */
int builder_determinant_sign(const VkTransformMatrixKHR *transform);

#endif
