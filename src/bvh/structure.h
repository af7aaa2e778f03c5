/* SPDX-License-Identifier: Apache-2.0 */
/* The memory layout of a structure: header, geometries, records, nodes.
 *
 * Leaves hold records: triangles with their positions, AABBs, or instances. Only active primitives
 * have records, in the order of the tree. Nodes have up to eight children. Parents precede their
 * children, so a pass from the last node to the first visits children before parents, and the nodes
 * cannot form a cycle.
 *
 * The size has an upper and a lower bound. A leaf has at most LEAF_RECORDS records, so n records
 * need at least n/28 nodes; structure_node_capacity() is the maximum, which emit.c observes. For
 * triangles (48 bytes per record, 224 per node) the size per triangle is at most 48 + 0.09 * 224 =
 * 68.2 bytes and at least 56; for microtriangles of displaced triangles (56 bytes per record) it
 * is at most 76.2 and at least 64. */
#ifndef ASSAY_BVH_STRUCTURE_H
#define ASSAY_BVH_STRUCTURE_H

#include <stddef.h>

#include "src/bvh/bvh.h"

#define NODE_WIDTH 8u

/* Splits by cost end at this depth. Deeper ranges are split by primitive number, at most 29 times.
 * Therefore no path is longer than 80 nodes, and the stack of a traversal holds at most seven
 * pending children per level. */
#define SPLIT_DEPTH_LIMIT 48u
#define TREE_DEPTH_LIMIT 80u
#define TRACE_STACK (7 * TREE_DEPTH_LIMIT + NODE_WIDTH)

/* A child is CHILD_EMPTY, the index of a node, or LEAF_BIT | (records - 1) << 29 | index of the
 * first record. */
#define CHILD_EMPTY 0xffffffffu
#define LEAF_BIT 0x80000000u
#define LEAF_COUNT_SHIFT 29
#define LEAF_FIRST_MASK 0x1fffffffu

struct wide_node {
    float lower[3][NODE_WIDTH], upper[3][NODE_WIDTH]; /* +inf and -inf for empty children */
    uint32_t child[NODE_WIDTH];                       /* empty children are last */
};

struct triangle_record {
    float a[3];
    uint32_t geometry;
    float b[3];
    uint32_t primitive;
    float c[3];
    /* 0: none. Otherwise triangle `opacity` - 1 of the geometry's micromap or, from
     * OPACITY_SPECIAL on, a special index for the whole triangle. */
    uint32_t opacity;
};
#define OPACITY_SPECIAL 0xfffffffcu /* the lowest special index, as 32 bits */

struct aabb_record {
    float lower[3];
    uint32_t geometry;
    float upper[3];
    uint32_t primitive;
};

struct instance_record {
    double inverse[9]; /* inverse of the 3x3 part, row by row; all 0 if the part is singular */
    VkAccelerationStructureInstanceKHR instance;
    uint32_t primitive;
    uint32_t spare;
};

/* A triangle of dense geometry: its source, and the values that its block gives. */
struct dense_record {
    struct triangle_record triangle;
    uint32_t geometry, primitive; /* for hits */
    uint32_t is_opaque, spare;
};

struct sphere_record {
    float center[3];
    uint32_t geometry;
    float radius;
    uint32_t spare[2];
    uint32_t primitive;
};

/* A linear swept sphere. */
#define SWEPT_CAP_FIRST 1u
#define SWEPT_CAP_LAST 2u
struct swept_record {
    float a[3];
    uint32_t geometry;
    float b[3];
    uint32_t primitive;
    float radius[2];
    uint32_t caps, spare;
};

/* The triangle at time 0 and at time 1; both have the same numbers. */
struct motion_triangle_record {
    struct triangle_record at[2];
};

/* A microtriangle: the record stores the number of its base triangle; `part` is its position within
 * the base triangle. */
struct displaced_part {
    uint16_t index;       /* position along the curve (displacement.h) */
    uint8_t level, edges; /* `edges`: bits of the decimated edges */
    uint32_t spare;
};
struct displaced_record {
    struct triangle_record triangle;
    struct displaced_part part;
};
struct motion_displaced_record {
    struct motion_triangle_record triangle;
    struct displaced_part part;
};

/* `base` is the instance at time 0. A static instance uses only `base`. */
struct motion_instance_record {
    struct instance_record base;
    uint32_t type; /* VkAccelerationStructureMotionInstanceTypeNV */
    uint32_t spare[3];
    union {
        VkTransformMatrixKHR matrix[2];
        VkSRTDataNV srt[2];
    } at; /* at times 0 and 1 */
};

/* The header before the references ("VkCopyAccelerationStructureToMemoryInfoKHR"). */
struct serialized_header {
    uint8_t driver[VK_UUID_SIZE], compatibility[VK_UUID_SIZE];
    uint64_t serialized_size, deserialized_size, reference_count;
};
_Static_assert(sizeof(struct serialized_header) == BUILDER_SERIALIZED_HEADER,
               "the specification's layout");

struct structure_geometry {
    uint32_t flags, primitive_count;
};

enum structure_kind {
    STRUCTURE_TRIANGLES,
    STRUCTURE_AABBS,
    STRUCTURE_INSTANCES,
    STRUCTURE_MOTION_TRIANGLES, /* builds with VK_BUILD_ACCELERATION_STRUCTURE_MOTION_BIT_NV */
    STRUCTURE_MOTION_INSTANCES,
    STRUCTURE_SPHERES,
    STRUCTURE_SWEPT_SPHERES,
    STRUCTURE_DENSE,
    STRUCTURE_DISPLACED, /* triangles, if any geometry has displacement */
    STRUCTURE_MOTION_DISPLACED,
};

struct structure_header {
    uint32_t magic, version;
    uint32_t kind;                       /* enum structure_kind */
    uint32_t flags;                      /* VkBuildAccelerationStructureFlagsKHR */
    uint64_t size;                       /* size of the whole structure with unused capacity */
    uint64_t geometries, records, nodes; /* offsets from the header */
    uint32_t geometry_count;
    uint32_t record_count, node_count;
    uint32_t record_capacity, node_capacity;
    float lower[3], upper[3]; /* +inf and -inf if no primitive is active */
    /* Number of micromap references after the nodes: one per geometry, or none. */
    uint32_t micromap_count;
};
_Static_assert(sizeof(struct structure_header) == 96, "layout");
_Static_assert(sizeof(struct wide_node) == 224, "layout");
_Static_assert(sizeof(struct triangle_record) == 48, "layout");
_Static_assert(sizeof(struct instance_record) == 144, "layout");
_Static_assert(sizeof(struct motion_instance_record) == 288, "layout");
_Static_assert(sizeof(struct displaced_record) == 56, "layout");

static inline uint32_t leaf_child(uint32_t first, uint32_t count)
{
    return LEAF_BIT | (count - 1) << LEAF_COUNT_SHIFT | first;
}

static inline uint32_t leaf_first(uint32_t child)
{
    return child & LEAF_FIRST_MASK;
}

static inline uint32_t leaf_count(uint32_t child)
{
    return (child >> LEAF_COUNT_SHIFT & 3) + 1;
}

static inline struct structure_geometry *structure_geometries(const struct structure_header *header)
{
    return (struct structure_geometry *)((uintptr_t)header + header->geometries);
}

static inline void *structure_records(const struct structure_header *header)
{
    return (void *)((uintptr_t)header + header->records);
}

static inline struct wide_node *structure_nodes(const struct structure_header *header)
{
    return (struct wide_node *)((uintptr_t)header + header->nodes);
}

static inline uint64_t *structure_micromaps(const struct structure_header *header)
{
    return (uint64_t *)((uintptr_t)header + header->size) - header->micromap_count;
}

/* Returns whether the records begin with an instance_record. */
static inline bool structure_is_top(enum structure_kind kind)
{
    return kind == STRUCTURE_INSTANCES || kind == STRUCTURE_MOTION_INSTANCES;
}

/* Returns whether the records are microtriangles. */
static inline bool structure_is_displaced(enum structure_kind kind)
{
    return kind == STRUCTURE_DISPLACED || kind == STRUCTURE_MOTION_DISPLACED;
}

static inline const struct displaced_part *structure_part(enum structure_kind kind,
                                                          const void *record)
{
    const struct displaced_record *still = record;
    const struct motion_displaced_record *moving = record;
    return kind == STRUCTURE_DISPLACED ? &still->part : &moving->part;
}

/* Returns whether the records are undisplaced triangles of the application's vertex data. */
static inline bool structure_has_triangles(enum structure_kind kind)
{
    return kind == STRUCTURE_TRIANGLES || kind == STRUCTURE_MOTION_TRIANGLES;
}

/* Returns whether traversal tests the up to four triangles of a leaf at once. */
static inline bool structure_has_fours(enum structure_kind kind)
{
    return kind == STRUCTURE_TRIANGLES || kind == STRUCTURE_DENSE || kind == STRUCTURE_DISPLACED;
}

static inline uint64_t structure_record_size(enum structure_kind kind)
{
    switch (kind) {
    case STRUCTURE_TRIANGLES:
        return sizeof(struct triangle_record);
    case STRUCTURE_AABBS:
        return sizeof(struct aabb_record);
    case STRUCTURE_INSTANCES:
        return sizeof(struct instance_record);
    case STRUCTURE_MOTION_TRIANGLES:
        return sizeof(struct motion_triangle_record);
    case STRUCTURE_MOTION_INSTANCES:
        return sizeof(struct motion_instance_record);
    case STRUCTURE_SPHERES:
        return sizeof(struct sphere_record);
    case STRUCTURE_SWEPT_SPHERES:
        return sizeof(struct swept_record);
    case STRUCTURE_DENSE:
        return sizeof(struct dense_record);
    case STRUCTURE_DISPLACED:
        return sizeof(struct displaced_record);
    case STRUCTURE_MOTION_DISPLACED:
        return sizeof(struct motion_displaced_record);
    }
    return 0;
}

/* Returns the record of an instance. The structure must be a TLAS. */
struct instance_record *structure_instance(const struct structure_header *header, uint64_t index);
uint32_t structure_leaf_limit(enum structure_kind kind); /* maximum records per leaf */
/* Returns the maximum number of nodes over `records` records. */
uint32_t structure_node_capacity(enum structure_kind kind, uint32_t records);

/* Sets the offsets, counts and the size; zeroes the rest. */
void structure_lay_out(struct structure_header *header, enum structure_kind kind,
                       uint32_t geometry_count, uint32_t record_capacity, uint32_t node_capacity,
                       bool has_micromaps);

/* Returns whether `size` bytes hold a structure whose offsets, counts and children are all
 * valid. */
bool structure_is_well_formed(const struct structure_header *header, uint64_t size);

#endif
