/* SPDX-License-Identifier: Apache-2.0 */
/* Pipeline stages and access types as the hazard check needs them (Vulkan specification,
 * Synchronization and Cache Control: Pipeline Stages, Access Types, Pipeline Stage Order; the
 * registry's <sync> section has the same tables).
 *
 * The specification's stage masks name groups of stages (ALL_COMMANDS), and builds include copies.
 * A stage_set holds the single stages after expansion, so two sets share a stage exactly if a chain
 * of dependencies continues from one to the other. */
#ifndef ASSAY_HAZARDS_SCOPES_H
#define ASSAY_HAZARDS_SCOPES_H

#include <stdbool.h>
#include <stdint.h>
#include <vulkan/vulkan_core.h>

/* Single stages. Builds, copies of structures and so on come first: accesses are tracked there. */
enum sync_stage {
    SYNC_BUILD,      /* ACCELERATION_STRUCTURE_BUILD: build commands alone */
    SYNC_ACCEL_COPY, /* copies, serialization and queries of structures: both
                        ACCELERATION_STRUCTURE_BUILD and ACCELERATION_STRUCTURE_COPY include it */
    SYNC_COPY,       /* COPY: copies of buffers, images and query results */
    SYNC_FILL,     /* vkCmdFillBuffer and vkCmdUpdateBuffer: part of COPY and of CLEAR, because the
                      specification does not say which */
    SYNC_MICROMAP, /* MICROMAP_BUILD: all commands of micromaps */
    SYNC_HOST,
    SYNC_COMPUTE_SHADER,
    SYNC_RAY_TRACING_SHADER,
    SYNC_DRAW_INDIRECT, /* draws: the first scope of each stage of graphics has it */
    SYNC_ACCESS_STAGES, /* stages from here on only continue chains */
    SYNC_CLEAR = SYNC_ACCESS_STAGES,
    SYNC_BLIT,
    SYNC_RESOLVE,
    SYNC_COPY_INDIRECT,
    SYNC_INDEX_INPUT,
    SYNC_VERTEX_ATTRIBUTE_INPUT,
    SYNC_VERTEX_SHADER,
    SYNC_TESSELLATION_CONTROL,
    SYNC_TESSELLATION_EVALUATION,
    SYNC_GEOMETRY_SHADER,
    SYNC_TRANSFORM_FEEDBACK,
    SYNC_TASK_SHADER,
    SYNC_MESH_SHADER,
    SYNC_SHADING_RATE,
    SYNC_DENSITY_PROCESS,
    SYNC_EARLY_FRAGMENT_TESTS,
    SYNC_FRAGMENT_SHADER,
    SYNC_LATE_FRAGMENT_TESTS,
    SYNC_COLOR_OUTPUT,
    SYNC_CONDITIONAL_RENDERING,
    SYNC_COMMAND_PREPROCESS,
    SYNC_VIDEO, /* decode and encode */
    SYNC_OTHER, /* all other stages of extensions, as one */
    SYNC_STAGES,
};

typedef uint32_t stage_set; /* of bits 1 << enum sync_stage */
#define ALL_SYNC_STAGES ((stage_set)((1ull << SYNC_STAGES) - 1))

/* Tracked accesses: what accesses, and how. Names: stage, access. */
enum access_kind {
    ACCESS_BUILD_ACCEL_READ,          /* src, and structures that instances refer to */
    ACCESS_BUILD_ACCEL_WRITE,         /* dst; scratch (which is read, too) */
    ACCESS_BUILD_SHADER_READ,         /* vertices, indices, transforms, boxes, instances ... */
    ACCESS_BUILD_INDIRECT_READ,       /* ranges of an indirect build */
    ACCESS_BUILD_MICROMAP_READ,       /* micromaps that a build attaches */
    ACCESS_COPY_ACCEL_READ,           /* src of a copy or serialization; a query */
    ACCESS_COPY_ACCEL_WRITE,          /* dst of a copy or deserialization */
    ACCESS_COPY_ACCEL_TRANSFER_READ,  /* memory that a deserialization reads */
    ACCESS_COPY_ACCEL_TRANSFER_WRITE, /* memory that a serialization writes */
    ACCESS_TRANSFER_READ,             /* src of a copy at stage COPY */
    ACCESS_TRANSFER_WRITE,            /* dst of a copy at stage COPY */
    ACCESS_FILL_WRITE,                /* dst of a fill or an update */
    ACCESS_MARKER_WRITE,              /* vkCmdWriteBufferMarkerAMD */
    ACCESS_MICROMAP_READ,
    ACCESS_MICROMAP_WRITE,       /* dst, and scratch */
    ACCESS_MICROMAP_SHADER_READ, /* inputs of a micromap build */
    ACCESS_MICROMAP_TRANSFER_READ,
    ACCESS_MICROMAP_TRANSFER_WRITE,
    ACCESS_HOST_READ, /* by a host command */
    ACCESS_HOST_WRITE,
    ACCESS_COMPUTE_TRACE, /* a shader traces rays: it reads a top-level structure */
    ACCESS_RAYS_TRACE,
    /* A shader may write any bytes. A buffer barrier counts for all of them. */
    ACCESS_COMPUTE_WRITE,
    ACCESS_RAYS_WRITE,
    ACCESS_GRAPHICS_WRITE, /* at any stage of a draw */
    ACCESS_KINDS,
};

typedef uint32_t kind_set; /* of bits 1 << enum access_kind */

enum sync_stage access_stage(enum access_kind kind);
/* A barrier whose masks have one of these stages may name the access. */
stage_set access_stages(enum access_kind kind);
bool access_is_write(enum access_kind kind);
/* Whether the bytes of such accesses are unknown. */
static inline bool access_is_anywhere(enum access_kind kind)
{
    return kind >= ACCESS_COMPUTE_WRITE;
}

/* What a device has enabled that decides which stages and accesses a barrier may name. */
struct barrier_features {
    bool synchronization2; /* else: the flags of vkCmdPipelineBarrier */
    bool structures;       /* the stage ACCELERATION_STRUCTURE_BUILD */
    bool structure_copies; /* the stage ACCELERATION_STRUCTURE_COPY */
    bool micromaps;        /* the stage MICROMAP_BUILD, and accesses of micromaps */
};

/* The stage and access that a barrier names for a kind, such as "COPY_BIT", "TRANSFER_READ_BIT".
 * Behind the prefixes they are names of flags. Static text. */
struct access_names {
    const char *stage_prefix, *stage, *access_prefix, *access;
};
struct access_names access_names(enum access_kind kind, const struct barrier_features *features);

/* One dependency of a synchronization command. The scopes of stages include logically earlier
 * stages in `src`, and later ones in `dst`; the access scopes do not. */
struct dependency {
    stage_set src, dst;
    kind_set src_kinds, dst_kinds;
};

/* Expands the masks of a barrier. TOP_OF_PIPE and BOTTOM_OF_PIPE mean all or no stages, depending
 * on the side. Unknown bits count as all stages and all accesses, which can only hide hazards. */
struct dependency dependency_of(VkPipelineStageFlags2 src_stages, VkAccessFlags2 src_access,
                                VkPipelineStageFlags2 dst_stages, VkAccessFlags2 dst_access);
/* The scopes of a semaphore operation, without access masks: all accesses at the stages. */
struct dependency dependency_of_signal(VkPipelineStageFlags2 stages); /* fills src */
struct dependency dependency_of_wait(VkPipelineStageFlags2 stages);   /* fills dst */

#endif
