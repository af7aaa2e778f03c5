/* SPDX-License-Identifier: Apache-2.0 */
/* The reference builder: acceleration structures from host memory into host memory.
 *
 * Follows "Acceleration Structures" of the Vulkan specification and calls no Vulkan function; the
 * types of vulkan_core.h are used for what an application hands over. A structure is one block of
 * bytes without pointers, so that it may be copied and moved; a TLAS names each BLAS by the 64-bit
 * reference of its instance, and a resolver turns that into the block's address.
 *
 * Units: offsets, strides and sizes are bytes; coordinates are the application's. All offsets are
 * 64 bits wide and are compared before they are added, so that none wraps. Same input, same bytes,
 * whatever the number of threads. Nothing here allocates: the caller gives the scratch. */
#ifndef ASSAY_BVH_BVH_H
#define ASSAY_BVH_BVH_H

#include <pthread.h>
#include <stdbool.h>
#include <stdint.h>
#include <vulkan/vulkan_core.h>

#define BUILDER_ALIGNMENT 64               /* of a structure and of scratch */
#define BUILDER_MAX_PRIMITIVES 0x1fffffffu /* of a structure, all geometries together */
#define BUILDER_ANY_SIZE UINT64_MAX        /* where nobody knows how much may be read */

enum builder_quality {
    BUILDER_FAST,     /* Morton order (Lauterbach 2009; Karras 2012) */
    BUILDER_BALANCED, /* binned SAH (Wald 2007) */
    BUILDER_HIGH,     /* full-sweep SAH (MacDonald and Booth 1990) */
};

enum builder_result {
    BUILDER_OK,
    BUILDER_UNKNOWN_FORMAT,     /* of vertices or indices, or a geometry of another type */
    BUILDER_INPUT_OUT_OF_RANGE, /* an index or a range leads out of its data: nothing was read there
                                 */
    BUILDER_TOO_MANY_PRIMITIVES,
    BUILDER_TOO_SMALL,    /* the structure, the scratch or the bytes given are too few */
    BUILDER_INCOMPATIBLE, /* a refit of another shape, or bytes that are no structure of ours */
};

/* Reads the memory behind an address that lies in the data; NULL where it can't be read. */
struct builder_memory {
    const void *(*read)(void *context, uint64_t address, uint64_t size); /* NULL: host pointers */
    void *context;
};

/* From VkAccelerationStructureInstanceKHR::accelerationStructureReference to a structure's block;
 * NULL where there is none. Called from several threads at once by builds that have them. */
struct builder_resolver {
    const void *(*find)(void *context, uint64_t reference);
    void *context;
};

/* VkAccelerationStructureTrianglesOpacityMicromapEXT, or ...KHR: which triangle of a micromap each
 * triangle of the geometry has. The micromap itself is looked for when rays are traced. */
struct builder_opacity {
    VkIndexType index_type; /* VK_INDEX_TYPE_NONE_KHR: the triangle's own number */
    uint32_t base_triangle;
    const void *indices;
    uint64_t indices_size, stride;
    uint64_t micromap; /* a reference; 0: none, and all indices are special */
};

/* VkAccelerationStructureTrianglesDisplacementMicromapNV: each triangle is cut into microtriangles,
 * whose vertices are where "Displacement Base Triangle" of the specification puts them. Vectors,
 * and biases with scales, are found by the numbers of vertices, to which a range's firstVertex is
 * added; of biases and scales the first two components count. Displacements come before a transform
 * of the geometry. What isn't in the specification: a triangle with a special index (-1 to -4) or
 * without a micromap stays as it is; each flag is a byte, bit 0 for the edge of vertices 0 and 1,
 * bit 1 for 1 and 2, bit 2 for 2 and 0: every second vertex of such an edge goes to the next
 * towards the edge's nearer end (displacement.h has the sources). */
struct builder_displacement {
    uint32_t usage_count;
    const VkMicromapUsageEXT *usages; /* sizes follow from them: there may be no more triangles */
    VkFormat vector_format, bias_and_scale_format; /* as of vertices */
    VkIndexType index_type; /* VK_INDEX_TYPE_NONE_KHR: the triangle's own number */
    uint32_t base_triangle;
    const void *vectors, *biases_and_scales, *flags, *indices; /* NULL: 0 and 1; no flags */
    uint64_t vectors_size, biases_and_scales_size, flags_size, indices_size;
    uint64_t vector_stride, bias_and_scale_stride, flags_stride, index_stride;
    uint64_t micromap; /* a reference, which the build resolves; 0: none */
};

/* VkAccelerationStructureGeometryTrianglesDataKHR. The sizes are what may be read from each
 * pointer on; VK_INDEX_TYPE_NONE_KHR has no indices, `transforms` may be NULL. */
struct builder_triangles {
    VkFormat vertex_format;
    VkIndexType index_type;
    uint32_t max_vertex;
    uint64_t vertex_stride;
    const void *vertices, *indices, *transforms;
    uint64_t vertices_size, indices_size, transforms_size;
    /* VkAccelerationStructureGeometryMotionTrianglesDataNV, in builds with motion: positions at
     * time 1, laid out as the others; NULL: it doesn't move. */
    const void *motion_vertices;
    uint64_t motion_vertices_size;
    const struct builder_opacity *opacity; /* NULL: none; a size query looks whether there is any */
    const struct builder_displacement *displacement; /* likewise, and reads the usages */
};

/* VkAccelerationStructureGeometryAabbsDataKHR */
struct builder_aabbs {
    const void *data;
    uint64_t size, stride;
};

/* VkAccelerationStructureGeometrySpheresDataNV and, with the last two members,
 * VkAccelerationStructureGeometryLinearSweptSpheresDataNV. */
struct builder_spheres {
    VkFormat vertex_format, radius_format; /* of radii: R32_SFLOAT, R16_SFLOAT */
    VkIndexType index_type;
    const void *vertices, *radii, *indices;
    uint64_t vertices_size, radii_size, indices_size;
    uint64_t vertex_stride, radius_stride, index_stride;
    VkRayTracingLssIndexingModeNV indexing_mode;
    VkRayTracingLssPrimitiveEndCapsModeNV end_caps_mode;
};

/* VkAccelerationStructureDenseGeometryFormatTrianglesDataAMDX: blocks of format DGF1. The range's
 * primitiveCount is numTriangles. Geometry and primitive of a hit, and what is opaque, are what the
 * blocks say; of what doesn't lie within its limits nothing is read. */
struct builder_dense {
    const void *data;
    uint64_t size;
    uint32_t max_primitive;
    const struct builder_opacity *opacity; /* by the blocks' primitive numbers; NULL: none */
};

/* VkAccelerationStructureGeometryInstancesDataKHR; of VkAccelerationStructureMotionInstanceNV, 160
 * bytes apart, in builds with motion, where pointers have their type in the low 4 bits. */
struct builder_instances {
    const void *data;
    uint64_t size;
    bool array_of_pointers;
};

struct builder_geometry {
    VkGeometryTypeKHR type; /* the same for all of a structure */
    VkGeometryFlagsKHR flags;
    union {
        struct builder_triangles triangles;
        struct builder_aabbs aabbs;
        struct builder_instances instances;
        struct builder_spheres spheres; /* swept or not */
        struct builder_dense dense;
    };
};

/* Threads of the caller's own that build together, as those that join a deferred operation do. One
 * runs builds and refits whose input names the team; any others call builder_team_help(), which
 * takes part in them until the team is closed, or builder_team_help_for_now(), which returns as
 * well when for a while there is nothing to do. A helper may come before a build, in its midst or
 * after it, and none has to; several threads may run builds with one team at once. Fields belong to
 * workers.c. */
struct builder_team {
    pthread_mutex_t lock;
    pthread_cond_t wakeup, done;
    struct builder_team_job *jobs;
    bool is_closed;
};
void builder_team_open(struct builder_team *team);
void builder_team_help(struct builder_team *team);
void builder_team_help_for_now(struct builder_team *team);
/* Sends helpers back; those who come later return at once. No build may run any more. */
void builder_team_close(struct builder_team *team);
void builder_team_destroy(struct builder_team *team); /* once nobody helps */

struct builder_input {
    VkAccelerationStructureTypeKHR type;        /* bottom or top */
    VkBuildAccelerationStructureFlagsKHR flags; /* VK_BUILD_ACCELERATION_STRUCTURE_MOTION_BIT_NV: a
                                                   structure of primitives that may move */
    enum builder_quality quality;
    uint32_t threads;          /* 0 and 1: the caller's alone; no other is started */
    struct builder_team *team; /* NULL: none; else `threads` is ignored */
    uint32_t geometry_count;
    const struct builder_geometry *geometries;
    const VkAccelerationStructureBuildRangeInfoKHR *ranges; /* one a geometry */
    struct builder_memory memory;                           /* for arrays of pointers */
    struct builder_resolver resolver;                       /* for instances */
    struct builder_resolver micromaps; /* for displacements; those it doesn't know stop a build */
};

/* What a build found in its data. Where a count isn't zero, the first of its kind in order of
 * geometry and primitive is named. */
struct builder_place {
    uint32_t geometry, primitive;
};
struct builder_report {
    uint64_t active, inactive; /* of what is displaced, microtriangles are active */
    uint64_t undefined; /* NaN in another component than X, or a negative radius: left open; */
    struct builder_place first_undefined; /* such primitives are left out */
    uint64_t out_of_range;
    struct builder_place first_out_of_range;
    uint64_t unresolved; /* instances whose reference the resolver doesn't know; left out */
    struct builder_place first_unresolved;
    uint64_t
        singular; /* instances whose 3x3 matrix (at time 0) has determinant 0: never hit then */
    struct builder_place first_singular;
    uint64_t transformed; /* positions that were to be multiplied by a geometry's transform */
};

/* vkGetAccelerationStructureBuildSizesKHR: of the input, only types, flags and geometry counts are
 * read, and `counts` in place of ranges unless it is NULL. A size serves smaller counts, too. */
struct builder_sizes {
    uint64_t structure, build_scratch, update_scratch;
};
enum builder_result builder_get_sizes(const struct builder_input *input, const uint32_t *counts,
                                      struct builder_sizes *sizes);

/* `report` is filled in every case, and may be NULL. After an error `structure` holds no structure.
 */
enum builder_result builder_build(const struct builder_input *input, void *structure,
                                  uint64_t structure_size, void *scratch, uint64_t scratch_size,
                                  struct builder_report *report);

/* VK_BUILD_ACCELERATION_STRUCTURE_MODE_UPDATE_KHR: new positions or instances in the tree of
 * `source`, which may be `structure`. Activity stays as it was built (03663, 03664). Where a
 * displaced triangle has another level than before, this is a build, for which there must be room.
 */
enum builder_result builder_refit(const struct builder_input *input, const void *source,
                                  void *structure, uint64_t structure_size, void *scratch,
                                  uint64_t scratch_size, struct builder_report *report);

/* vkCopyAccelerationStructureKHR */
uint64_t builder_size(const void *structure); /* bytes that a clone takes */
uint64_t builder_compacted_size(const void *structure);
enum builder_result builder_clone(const void *source, void *target, uint64_t target_size);
enum builder_result builder_compact(const void *source, void *target, uint64_t target_size);

/* The specification's serialized form: driver UUID and compatibility (16 bytes each), serialized
 * size, deserialized size, count of BLAS references (64 bits each), the references, the structure;
 * all in the host's byte order. To relocate, the application writes new references over the old. */
struct builder_uuids {
    uint8_t driver[VK_UUID_SIZE], compatibility[VK_UUID_SIZE];
};
uint64_t builder_serialized_size(const void *structure);
uint64_t builder_reference_count(const void *structure); /* BLAS pointers of the serialized form */
enum builder_result builder_serialize(const void *structure, const struct builder_uuids *uuids,
                                      void *bytes, uint64_t size);
/* What the first BUILDER_SERIALIZED_HEADER bytes say; false where they are none of ours. */
#define BUILDER_SERIALIZED_HEADER 56u
struct builder_serialized {
    uint64_t size, structure_size, reference_count;
};
bool builder_read_header(const void *bytes, const struct builder_uuids *uuids,
                         struct builder_serialized *serialized);
/* Bytes may come from anywhere: everything that traversal relies on is checked first. The bounds of
 * a relocated TLAS are those of the structures that it was built with (the specification asks that
 * the new ones equal them). */
enum builder_result builder_deserialize(const void *bytes, uint64_t size,
                                        const struct builder_uuids *uuids, void *structure,
                                        uint64_t structure_size);

/* ---- what tools ask about a structure */

VkAccelerationStructureTypeKHR builder_type(const void *structure);
bool builder_bounds(const void *structure, float lower[3], float upper[3]); /* false: empty */

struct builder_statistics {
    uint64_t nodes, leaves, active;
    uint32_t depth;
    double sah; /* areas relative to the root's: nodes cost 1, primitives of leaves 1 each */
};
void builder_measure(const void *structure, struct builder_statistics *statistics);

/* The sign of the determinant of a transform's 3x3 part, exactly (03799): -1, 0 or 1; 0, too, where
 * an element isn't finite. */
int builder_determinant_sign(const VkTransformMatrixKHR *transform);

#endif
