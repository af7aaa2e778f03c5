/* SPDX-License-Identifier: Apache-2.0 */
/* The inputs of a build that are kept for later updates: for each geometry the number of
 * primitives, which of them were inactive, and the indices. Kept at level CONTENT only. Takes one
 * bit for each primitive, and the bytes of the indices.
 *
 * The inputs of a host build are known during the call. For a device build, each execution has its
 * own inputs, which are attached to the live states when the build executes, and filled when the
 * execution has completed. */
#ifndef ASSAY_STATE_BUILDS_BUILT_H
#define ASSAY_STATE_BUILDS_BUILT_H

#include <stdatomic.h>
#include <stdbool.h>
#include <stdint.h>
#include <vulkan/vulkan_core.h>

#include "src/base/unknown.h"
#include "src/model/geometry_shape.h"
#include "src/state/facts.h"

/* The head of a block of memory that several builds share. Freed with the last reference. */
struct kept_block {
    atomic_uint references;
};
struct kept_block *kept_block_share(struct kept_block *block);
void kept_block_release(struct kept_block *block); /* accepts NULL */

/* The indices of a geometry. An update with the same indices shares those of its source. */
struct kept_indices {
    struct kept_block block;
    uint32_t max;  /* the largest index */
    uint64_t size; /* in bytes */
    uint8_t bytes[];
};

/* Members are NULL if unknown or absent. */
struct geometry_inputs {
    bool count_known;
    uint32_t primitive_count;
    uint64_t *inactive; /* bit i of word i / 64: primitive 64 * (i / 64) + i % 64 */
    struct kept_indices *indices;
    /* What a consumer has kept of the last build that was no update (struct build_reader). */
    struct kept_block *kept;
};

/* The reader of the data fills the items and then calls build_inputs_mark_known(); from then on
 * they are immutable. Freed with the last reference. */
struct build_inputs {
    atomic_uint references;
    atomic_bool is_known;
    const void *filler; /* the object that will fill the items, set and compared by the filler only;
                         * NULL: not known yet */
    uint32_t count;     /* number of geometries */
    struct geometry_inputs items[];
};

/* Returns unknown inputs with one reference, or NULL if there is no memory. */
struct build_inputs *build_inputs_create(uint32_t count);

void build_inputs_release(struct build_inputs *inputs); /* may be NULL */

/* Returns a copy with one reference, or NULL if there is no memory. */
struct kept_indices *kept_indices_create(const void *bytes, uint64_t size, uint32_t max);

/* Called when the items are complete and will not change. */
void build_inputs_mark_known(struct build_inputs *inputs); /* may be NULL */
/* Returns the inputs of a geometry, or NULL if they are unknown. `inputs` may be NULL. */
const struct geometry_inputs *build_inputs_of(const struct build_inputs *inputs, uint32_t geometry);

/* ---- Describes the last build of an acceleration structure, with which later updates are
 * compared.
 *
 * Geometry shapes are kept for builds that allow updates, for updates, and for builds of micromaps,
 * whose one geometry has as many primitives as the micromap has triangles. The journals of command
 * buffers and the live states share them by reference. */

/* The additional members of a geometry of VK_AMDX_dense_geometry_format. */
struct dense_shape {
    uint32_t geometry; /* index of the geometry */
    uint32_t triangle_count, vertex_count, max_primitive_index, max_geometry_index;
    uint32_t format;        /* VkCompressedTriangleFormatAMDX */
    VkDeviceSize data_size; /* in bytes */
};

/* The micromap of VK_KHR_opacity_micromap that triangles were built with. */
struct micromap_shape {
    uint64_t handle; /* 0: VK_NULL_HANDLE */
    uint64_t id;     /* of built_with_micromaps(); else 0 */
    bool given;      /* the chain has the structure with the handle */
};

/* Immutable; freed with the last reference. Any thread may share and release it. The dense shapes
 * follow the items in memory; if any geometry has a micromap, the micromap shapes of all geometries
 * follow those. */
struct geometry_shapes {
    atomic_uint references;
    bool has_micromaps;
    VkDeviceSize dst_size;    /* of an update: that dst was created with, in bytes; 0: unknown */
    VkDeviceSize needed_size; /* see built_needed_size() */
    uint32_t count, dense_count;
    struct geometry_shape items[];
};

/* Returns the dense shapes in ascending order of their geometries; there are dense_count. */
const struct dense_shape *built_dense_shapes(const struct geometry_shapes *shapes);

/* Returns the micromap shape of one geometry; zero if it had none. */
struct micromap_shape built_micromap_shape(const struct geometry_shapes *shapes, uint32_t geometry);

/* The compacted size of one build, as queried. Shared by the structure that holds the build, its
 * copies, and the queries that are not read yet. Only the owner of the live states accesses the
 * serialized size; the thread that delivers also sets `size`. */
struct compacted_size {
    atomic_uint references;
    _Atomic VkDeviceSize size; /* in bytes: the smallest query result; 0: none was read yet */
    /* The serialization size of the structure with this id, while it holds the build: copies may
     * have another one. In bytes; 0: no query result was read yet. */
    VkDeviceSize serialized;
    uint64_t serialized_id;
    VkDeviceSize full; /* the same for its size (VK_QUERY_TYPE_ACCELERATION_STRUCTURE_SIZE_KHR) */
    bool full_is_queried; /* of a structure that holds the build, though perhaps not yet read */
};

/* A query that was reset is BUILT_NEVER; one that was written since is BUILT_BEFORE. */
enum built_state {
    BUILT_UNKNOWN, /* the last write is unknown */
    BUILT_NEVER,   /* created and never written */
    BUILT_BEFORE,
    BUILT_FILLED, /* deserialized, or a VkMicromapEXT: the inputs of its build are unknown, and the
                   * flags unless `is_micromap` is set. `shapes` are those of
                   * built_with_micromaps() */
};

struct built {
    /* Where the build was recorded: the command buffer and the build's position in it. For a host
     * build: NULL and the index in pInfos. */
    union {
        VkCommandBuffer command_buffer;
        uint64_t queried; /* of a query: the handle of the structure */
    };
    uint32_t position;

    uint32_t geometry_count;
    struct geometry_shapes *shapes;  /* NULL: not kept */
    union {                          /* a recorded build takes little memory */
        struct build_inputs *inputs; /* see built_inputs(); with shapes */
        VkDeviceSize plain_size;     /* see built_needed_size(); without shapes */
    };
    VkAccelerationStructureTypeKHR type;
    VkBuildAccelerationStructureFlagsKHR flags;
    uint32_t command_buffer_id; /* 0: unknown */
    unsigned char state;        /* enum built_state */
    bool compacted : 1;         /* the structure holds a compacting copy */
    bool sole : 1;              /* of a query: this is its first write */
    bool unwritten : 1;         /* of a query: it was reset, and never written before */
    bool is_micromap : 1;       /* BUILT_FILLED by a build of a VkMicromapEXT, with `flags` */
    /* In live states: a micromap of VK_KHR_opacity_micromap, which nothing but builds has written
     * since it was created. */
    bool is_original : 1;
    /* In live states and queries: the compacted size of the build, or of the build that was
     * compacted. NULL if it has not been queried. */
    struct compacted_size *compacted_size;
};

/* Returns NULL if the inputs are not kept. */
static inline struct build_inputs *built_inputs(const struct built *built)
{
    return built->shapes ? built->inputs : NULL;
}

/* Returns accelerationStructureSize in bytes, as vkGetAccelerationStructureBuildSizesKHR returns it
 * for the build, or for the parameters of the update; 0: unknown. */
static inline VkDeviceSize built_needed_size(const struct built *built)
{
    return built->shapes ? built->shapes->needed_size : built->plain_size;
}

/* Returns the compacted size of the build of a structure, with one reference, or NULL if there is
 * no memory. */
struct compacted_size *compacted_size_create(uint64_t id);
/* Lowers the compacted size to `size`, a query result. Ignores 0. */
void compacted_size_update(struct compacted_size *compacted, VkDeviceSize size);

/* Returns a copy that shares the members it points to. Release each copy with built_release(). */
struct built built_share(const struct built *built);
void built_release(struct built *built);

/* A micromap that a geometry of a build uses. */
struct micromap_use {
    uint32_t geometry;
    bool is_ext;       /* of VK_EXT_opacity_micromap; else of VK_KHR_opacity_micromap */
    uint64_t handle;   /* 0: VK_NULL_HANDLE */
    uint64_t id;       /* 0: unknown */
    bool is_unindexed; /* the triangles use consecutive micromap triangles, and their count is
                        * known */
    uint32_t first, triangle_count; /* the first micromap triangle, and the number of triangles */
    struct accel_facts accel;       /* not set if is_ext */
};

struct micromap_uses {
    struct micromap_use *items;
    uint32_t count, capacity;
    struct unknown unknown; /* some uses are missing because there was no memory */
    bool built_count_known; /* the build is of a micromap with built_triangle_count triangles */
    uint32_t built_triangle_count;
};

/* Describes a build as the application gave it, without shapes, which most builds don't keep. */
static inline void built_describe(struct built *built,
                                  const VkAccelerationStructureBuildGeometryInfoKHR *info,
                                  const struct command_buffer_facts *command_buffer,
                                  uint32_t position)
{
    built->command_buffer = command_buffer->handle;
    built->command_buffer_id = command_buffer->id;
    built->position = position;
    built->geometry_count = info->geometryCount;
    built->type = info->type;
    built->flags = info->flags;
    built->shapes = NULL;
    built->plain_size = 0;
    built->state = BUILT_BEFORE;
    built->compacted = built->sole = built->unwritten = false;
    built->is_micromap = built->is_original = false;
    built->compacted_size = NULL;
}

/* Makes a description unknown except for its position. */
void built_forget(struct built *built);

/* Returns whether the shapes of a build are kept. */
static inline bool built_has_shapes(const VkAccelerationStructureBuildGeometryInfoKHR *info)
{
    return (info->flags & VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_UPDATE_BIT_KHR) ||
           build_is_update(info) ||
           info->type == VK_ACCELERATION_STRUCTURE_TYPE_OPACITY_MICROMAP_KHR;
}

/* The inputs of built_add_shapes(). The geometries of `info`, and `ranges` if counts are known, are
 * readable. */
struct build_description {
    const VkAccelerationStructureBuildGeometryInfoKHR *info;
    const VkAccelerationStructureBuildRangeInfoKHR *ranges;
    VkDeviceSize dst_size, needed_size;    /* see struct geometry_shapes */
    bool dense_readable;                   /* the chains of dense geometries are readable */
    const struct micromap_uses *micromaps; /* NULL: none */
    struct build_inputs *inputs;           /* shared; NULL: none */
};

/* Makes the shapes of a structure that was deserialized from data which refer to micromaps; all
 * else is unknown. Returns NULL if there is no memory. */
struct geometry_shapes *built_with_micromaps(uint32_t count,
                                             const struct micromap_shape *micromaps);
/* Returns NULL if there is no memory, or if shapes are unknown. */
struct geometry_shapes *geometry_shapes_create(const struct build_description *description);

/* Adds the shapes of a build. Makes the description unknown if that fails. */
void built_add_shapes(struct built *built, const struct build_description *description);

#endif
