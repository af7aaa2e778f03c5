/* SPDX-License-Identifier: Apache-2.0 */
/* What an acceleration structure was built with: what later updates are measured by.
 *
 * Geometry details are kept only of builds that allow updates, of updates themselves, and of builds
 * of micromaps, whose one geometry has as many primitives as the micromap has triangles; they are
 * shared by reference between the journals of command buffers and the live states. */
#ifndef ASSAY_STATE_BUILDS_BUILT_H
#define ASSAY_STATE_BUILDS_BUILT_H

#include <stdatomic.h>
#include <stdbool.h>
#include <stdint.h>
#include <vulkan/vulkan_core.h>

#include "src/state/builds/build_info.h"
#include "src/state/builds/inputs.h"
#include "src/state/facts.h"

struct geometry_shape {
    VkGeometryTypeKHR type;
    VkGeometryFlagsKHR flags;
    VkFormat vertex_format; /* these four: triangles only */
    uint32_t max_vertex;
    VkIndexType index_type;
    bool has_transform;
    bool count_known; /* the indirect command's counts are in device memory */
    uint32_t primitive_count;
};

/* What a geometry of VK_AMDX_dense_geometry_format has beside its type and flags. */
struct dense_shape {
    uint32_t geometry; /* its index */
    uint32_t triangle_count, vertex_count, max_primitive_index, max_geometry_index;
    uint32_t format;        /* VkCompressedTriangleFormatAMDX */
    VkDeviceSize data_size; /* bytes */
};

/* What triangles were built with of VK_KHR_opacity_micromap. */
struct micromap_shape {
    uint64_t handle; /* 0: null */
    bool given;      /* the structure that names it is there */
};

/* Immutable once made; freed with its last reference. The dense shapes lie behind the items, and
 * behind those, if any geometry has a micromap, the micromaps of all. */
struct geometry_shapes {
    atomic_uint references;
    bool has_micromaps;
    /* Of an update: the size of its dst, and what vkGetAccelerationStructureBuildSizesKHR says that
     * it needs, in bytes; 0 where that isn't known. */
    VkDeviceSize dst_size, needed_size;
    uint32_t count, dense_count;
    struct geometry_shape items[];
};

/* In ascending order of their geometries; dense_count of them. */
const struct dense_shape *built_dense_shapes(const struct geometry_shapes *shapes);

/* Of one geometry; zero where none was given. */
struct micromap_shape built_micromap_shape(const struct geometry_shapes *shapes, uint32_t geometry);

/* What queries have told of the compacted size of one build: shared by the structure that holds it,
 * its copies, and the queries that wait to be read. `size` is for who owns the live states. */
struct compacted_size {
    atomic_uint references;
    VkDeviceSize size; /* bytes, the least answer; 0: none was read yet */
};

enum built_state {
    BUILT_UNKNOWN, /* of undetermined order: nothing is said of it */
    BUILT_NEVER,   /* created, and never written since */
    BUILT_BEFORE,
    BUILT_FILLED, /* deserialized: with what it was built isn't known */
};

struct built {
    /* Where: the command buffer and the build's position in it; of a build by the host, null and
     * the index in pInfos. */
    VkCommandBuffer command_buffer;
    uint32_t position;

    uint32_t geometry_count;
    struct geometry_shapes *shapes; /* NULL where they weren't kept */
    struct build_inputs *inputs;    /* NULL: none are kept */
    VkAccelerationStructureTypeKHR type;
    VkBuildAccelerationStructureFlagsKHR flags;
    enum built_state state;
    bool compacted; /* it holds a compacting copy */
    bool sole;      /* of a query: nothing was written there before */
    /* Live, or of a query: of the build that it holds, or that a compacting copy was made of. NULL
     * where nobody asked. */
    struct compacted_size *compacted_size;
};

/* NULL without memory; with one reference. */
struct compacted_size *compacted_size_create(void);
void compacted_size_learn(struct compacted_size *compacted, VkDeviceSize size);

/* A copy shares what it points to; each copy is released by itself. */
struct built built_share(const struct built *built);
void built_release(struct built *built);

/* The micromaps that the geometries of one build use. */
struct micromap_use {
    uint32_t geometry;
    bool is_ext;       /* of VK_EXT_opacity_micromap; else of VK_KHR_opacity_micromap */
    uint64_t handle;   /* 0: null */
    uint64_t id;       /* 0 where it isn't known */
    bool is_unindexed; /* the triangles, whose count is known, have the micromap's in order, */
    uint32_t first, triangle_count; /* beginning with that one */
    struct accel_facts accel;       /* unless is_ext */
};

struct micromap_uses {
    struct micromap_use *items;
    uint32_t count, capacity;
    bool incomplete;        /* some were lost for lack of memory */
    bool built_count_known; /* the build is one of a micromap, of so many triangles */
    uint32_t built_triangle_count;
};

/* Describes a build as the application gave it, all but its shapes: most builds keep none. */
static inline void built_describe(struct built *built,
                                  const VkAccelerationStructureBuildGeometryInfoKHR *info,
                                  VkCommandBuffer command_buffer, uint32_t position)
{
    built->command_buffer = command_buffer;
    built->position = position;
    built->geometry_count = info->geometryCount;
    built->type = info->type;
    built->flags = info->flags;
    built->shapes = NULL;
    built->inputs = NULL;
    built->state = BUILT_BEFORE;
    built->compacted = built->sole = false;
    built->compacted_size = NULL;
}

/* Nothing is known of it but where it is. */
void built_forget(struct built *built);

static inline bool built_has_shapes(const VkAccelerationStructureBuildGeometryInfoKHR *info)
{
    return (info->flags & VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_UPDATE_BIT_KHR) ||
           build_is_update(info) ||
           info->type == VK_ACCELERATION_STRUCTURE_TYPE_OPACITY_MICROMAP_KHR;
}

/* For builds that have them. The geometries of `info`, and `ranges` where counts are known, are
 * readable. Without memory what was described is forgotten. */
struct build_description {
    const VkAccelerationStructureBuildGeometryInfoKHR *info;
    const VkAccelerationStructureBuildRangeInfoKHR *ranges;
    VkDeviceSize dst_size, needed_size;    /* see struct geometry_shapes */
    bool dense_readable;                   /* the chains of dense geometries, with their data */
    const struct micromap_uses *micromaps; /* NULL: none */
    struct build_inputs *inputs;           /* shared; NULL: none */
};

/* Of a build of VK_NV_ray_tracing, whose geometries are readable: types, counts and index types.
 * NULL without memory. */
struct geometry_shapes *built_nv_shapes(const VkAccelerationStructureInfoNV *info);
/* As many triangles or boxes as a geometry has. */
uint32_t nv_primitive_count(const VkGeometryNV *geometry);

void built_add_shapes(struct built *built, const struct build_description *description);

#endif
