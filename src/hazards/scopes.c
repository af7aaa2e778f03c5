/* SPDX-License-Identifier: Apache-2.0 */
#include "src/hazards/scopes.h"

#include <stddef.h>

#define BIT(stage) ((stage_set)1 << (stage))
#define COUNT_OF(array) (sizeof(array) / sizeof((array)[0]))

#define DEVICE_STAGES (ALL_SYNC_STAGES & ~BIT(SYNC_HOST))
#define COPIES (BIT(SYNC_COPY) | BIT(SYNC_FILL))
#define CLEARS (BIT(SYNC_CLEAR) | BIT(SYNC_FILL))
#define TRANSFERS (COPIES | CLEARS | BIT(SYNC_BLIT) | BIT(SYNC_RESOLVE) | BIT(SYNC_ACCEL_COPY))
#define VERTEX_INPUT (BIT(SYNC_INDEX_INPUT) | BIT(SYNC_VERTEX_ATTRIBUTE_INPUT))
/* SYNC_OTHER has the stages CLUSTER_CULLING_SHADER, SUBPASS_SHADER and INVOCATION_MASK. */
#define PRE_RASTERIZATION                                                                          \
    (BIT(SYNC_VERTEX_SHADER) | BIT(SYNC_TESSELLATION_CONTROL) |                                    \
     BIT(SYNC_TESSELLATION_EVALUATION) | BIT(SYNC_GEOMETRY_SHADER) | BIT(SYNC_TASK_SHADER) |       \
     BIT(SYNC_MESH_SHADER) | BIT(SYNC_OTHER))
#define RASTERIZATION                                                                              \
    (BIT(SYNC_SHADING_RATE) | BIT(SYNC_EARLY_FRAGMENT_TESTS) | BIT(SYNC_FRAGMENT_SHADER) |         \
     BIT(SYNC_LATE_FRAGMENT_TESTS) | BIT(SYNC_COLOR_OUTPUT))
#define GRAPHICS                                                                                   \
    (BIT(SYNC_DRAW_INDIRECT) | VERTEX_INPUT | PRE_RASTERIZATION | BIT(SYNC_TRANSFORM_FEEDBACK) |   \
     RASTERIZATION | BIT(SYNC_DENSITY_PROCESS) | BIT(SYNC_CONDITIONAL_RENDERING))

/* ---- stages */

/* Flags of stages, except TOP_OF_PIPE and BOTTOM_OF_PIPE, and what they stand for. */
static const struct {
    VkPipelineStageFlags2 flag;
    stage_set stages;
} stage_flags[] = {
    {VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, DEVICE_STAGES},
    {VK_PIPELINE_STAGE_2_ACCELERATION_STRUCTURE_BUILD_BIT_KHR,
     BIT(SYNC_BUILD) | BIT(SYNC_ACCEL_COPY)},
    {VK_PIPELINE_STAGE_2_ACCELERATION_STRUCTURE_COPY_BIT_KHR, BIT(SYNC_ACCEL_COPY)},
    {VK_PIPELINE_STAGE_2_MICROMAP_BUILD_BIT_EXT, BIT(SYNC_MICROMAP)},
    {VK_PIPELINE_STAGE_2_HOST_BIT, BIT(SYNC_HOST)},
    {VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT, TRANSFERS},
    {VK_PIPELINE_STAGE_2_COPY_BIT, COPIES},
    {VK_PIPELINE_STAGE_2_CLEAR_BIT, CLEARS},
    {VK_PIPELINE_STAGE_2_BLIT_BIT, BIT(SYNC_BLIT)},
    {VK_PIPELINE_STAGE_2_RESOLVE_BIT, BIT(SYNC_RESOLVE)},
    {VK_PIPELINE_STAGE_2_COPY_INDIRECT_BIT_KHR, BIT(SYNC_COPY_INDIRECT)},
    {VK_PIPELINE_STAGE_2_ALL_GRAPHICS_BIT, GRAPHICS},
    {VK_PIPELINE_STAGE_2_DRAW_INDIRECT_BIT, BIT(SYNC_DRAW_INDIRECT)},
    {VK_PIPELINE_STAGE_2_VERTEX_INPUT_BIT, VERTEX_INPUT},
    {VK_PIPELINE_STAGE_2_INDEX_INPUT_BIT, BIT(SYNC_INDEX_INPUT)},
    {VK_PIPELINE_STAGE_2_VERTEX_ATTRIBUTE_INPUT_BIT, BIT(SYNC_VERTEX_ATTRIBUTE_INPUT)},
    {VK_PIPELINE_STAGE_2_PRE_RASTERIZATION_SHADERS_BIT, PRE_RASTERIZATION},
    {VK_PIPELINE_STAGE_2_VERTEX_SHADER_BIT, BIT(SYNC_VERTEX_SHADER)},
    {VK_PIPELINE_STAGE_2_TESSELLATION_CONTROL_SHADER_BIT, BIT(SYNC_TESSELLATION_CONTROL)},
    {VK_PIPELINE_STAGE_2_TESSELLATION_EVALUATION_SHADER_BIT, BIT(SYNC_TESSELLATION_EVALUATION)},
    {VK_PIPELINE_STAGE_2_GEOMETRY_SHADER_BIT, BIT(SYNC_GEOMETRY_SHADER)},
    {VK_PIPELINE_STAGE_2_TRANSFORM_FEEDBACK_BIT_EXT, BIT(SYNC_TRANSFORM_FEEDBACK)},
    {VK_PIPELINE_STAGE_2_TASK_SHADER_BIT_EXT, BIT(SYNC_TASK_SHADER)},
    {VK_PIPELINE_STAGE_2_MESH_SHADER_BIT_EXT, BIT(SYNC_MESH_SHADER)},
    {VK_PIPELINE_STAGE_2_FRAGMENT_SHADING_RATE_ATTACHMENT_BIT_KHR, BIT(SYNC_SHADING_RATE)},
    {VK_PIPELINE_STAGE_2_FRAGMENT_DENSITY_PROCESS_BIT_EXT, BIT(SYNC_DENSITY_PROCESS)},
    {VK_PIPELINE_STAGE_2_EARLY_FRAGMENT_TESTS_BIT, BIT(SYNC_EARLY_FRAGMENT_TESTS)},
    {VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT, BIT(SYNC_FRAGMENT_SHADER)},
    {VK_PIPELINE_STAGE_2_LATE_FRAGMENT_TESTS_BIT, BIT(SYNC_LATE_FRAGMENT_TESTS)},
    {VK_PIPELINE_STAGE_2_COLOR_ATTACHMENT_OUTPUT_BIT, BIT(SYNC_COLOR_OUTPUT)},
    {VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT, BIT(SYNC_COMPUTE_SHADER)},
    {VK_PIPELINE_STAGE_2_RAY_TRACING_SHADER_BIT_KHR, BIT(SYNC_RAY_TRACING_SHADER)},
    {VK_PIPELINE_STAGE_2_CONDITIONAL_RENDERING_BIT_EXT, BIT(SYNC_CONDITIONAL_RENDERING)},
    {VK_PIPELINE_STAGE_2_COMMAND_PREPROCESS_BIT_EXT, BIT(SYNC_COMMAND_PREPROCESS)},
    {VK_PIPELINE_STAGE_2_VIDEO_DECODE_BIT_KHR, BIT(SYNC_VIDEO)},
    {VK_PIPELINE_STAGE_2_VIDEO_ENCODE_BIT_KHR, BIT(SYNC_VIDEO)},
    {VK_PIPELINE_STAGE_2_SUBPASS_SHADER_BIT_HUAWEI, BIT(SYNC_OTHER)},
    {VK_PIPELINE_STAGE_2_INVOCATION_MASK_BIT_HUAWEI, BIT(SYNC_OTHER)},
    {VK_PIPELINE_STAGE_2_CLUSTER_CULLING_SHADER_BIT_HUAWEI, BIT(SYNC_OTHER)},
    {VK_PIPELINE_STAGE_2_OPTICAL_FLOW_BIT_NV, BIT(SYNC_OTHER)},
    {VK_PIPELINE_STAGE_2_MEMORY_DECOMPRESSION_BIT_EXT, BIT(SYNC_OTHER)},
    {VK_PIPELINE_STAGE_2_CONVERT_COOPERATIVE_VECTOR_MATRIX_BIT_NV, BIT(SYNC_OTHER)},
    {VK_PIPELINE_STAGE_2_DATA_GRAPH_BIT_ARM, BIT(SYNC_OTHER)},
};

/* Returns the stages that the flags name. */
static stage_set named_stages(VkPipelineStageFlags2 flags)
{
    stage_set stages = 0;
    for (size_t i = 0; i < COUNT_OF(stage_flags) && flags; i++)
        if (flags & stage_flags[i].flag) {
            stages |= stage_flags[i].stages;
            flags &= ~stage_flags[i].flag;
        }
    return flags ? ALL_SYNC_STAGES : stages;
}

/* The pipelines (Pipeline Stage Order). Each element comes logically before the next one. Pipelines
 * of one stage are left out. */
static const stage_set pipelines[][16] = {
    {BIT(SYNC_DRAW_INDIRECT), BIT(SYNC_INDEX_INPUT), BIT(SYNC_VERTEX_ATTRIBUTE_INPUT),
     BIT(SYNC_VERTEX_SHADER), BIT(SYNC_TESSELLATION_CONTROL), BIT(SYNC_TESSELLATION_EVALUATION),
     BIT(SYNC_GEOMETRY_SHADER), BIT(SYNC_TRANSFORM_FEEDBACK), BIT(SYNC_SHADING_RATE),
     BIT(SYNC_EARLY_FRAGMENT_TESTS), BIT(SYNC_FRAGMENT_SHADER), BIT(SYNC_LATE_FRAGMENT_TESTS),
     BIT(SYNC_COLOR_OUTPUT)},
    {BIT(SYNC_DRAW_INDIRECT), BIT(SYNC_TASK_SHADER), BIT(SYNC_MESH_SHADER), BIT(SYNC_SHADING_RATE),
     BIT(SYNC_EARLY_FRAGMENT_TESTS), BIT(SYNC_FRAGMENT_SHADER), BIT(SYNC_LATE_FRAGMENT_TESTS),
     BIT(SYNC_COLOR_OUTPUT)},
    {BIT(SYNC_DENSITY_PROCESS), BIT(SYNC_EARLY_FRAGMENT_TESTS), BIT(SYNC_FRAGMENT_SHADER),
     BIT(SYNC_LATE_FRAGMENT_TESTS), BIT(SYNC_COLOR_OUTPUT)},
    {BIT(SYNC_DRAW_INDIRECT), BIT(SYNC_COMPUTE_SHADER)},
    {BIT(SYNC_DRAW_INDIRECT), BIT(SYNC_RAY_TRACING_SHADER)},
    {BIT(SYNC_COPY_INDIRECT), TRANSFERS},
};

/* Adds the logically earlier stages. */
static stage_set with_earlier(stage_set named)
{
    stage_set all = named;
    for (size_t i = 0; i < COUNT_OF(pipelines); i++) {
        stage_set earlier = 0;
        for (const stage_set *stage = pipelines[i]; *stage; stage++) {
            if (*stage & named)
                all |= earlier;
            earlier |= *stage;
        }
    }
    return all;
}

/* Adds the logically later stages. */
static stage_set with_later(stage_set named)
{
    stage_set all = named;
    for (size_t i = 0; i < COUNT_OF(pipelines); i++) {
        bool is_later = false;
        for (const stage_set *stage = pipelines[i]; *stage; stage++) {
            if (is_later)
                all |= *stage;
            is_later |= (*stage & named) != 0;
        }
    }
    return all;
}

/* ---- accesses */

#define AT_BUILD "ACCELERATION_STRUCTURE_BUILD_BIT_KHR"
#define AT_MICROMAP "MICROMAP_BUILD_BIT_EXT"
#define AT_ALL "ALL_COMMANDS_BIT"

/* The equivalents of SHADER_READ count as SHADER_READ: the specification does not say which of them
 * a build performs. */
#define SHADER_READS                                                                               \
    (VK_ACCESS_2_SHADER_READ_BIT | VK_ACCESS_2_SHADER_SAMPLED_READ_BIT |                           \
     VK_ACCESS_2_SHADER_STORAGE_READ_BIT | VK_ACCESS_2_SHADER_BINDING_TABLE_READ_BIT_KHR |         \
     VK_ACCESS_2_SHADER_TILE_ATTACHMENT_READ_BIT_QCOM)

#define SHADER_WRITES                                                                              \
    (VK_ACCESS_2_SHADER_WRITE_BIT | VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT |                         \
     VK_ACCESS_2_SHADER_TILE_ATTACHMENT_WRITE_BIT_QCOM)

static const struct {
    enum sync_stage stage;
    bool is_write;
    VkAccessFlags2 flags; /* each of them includes the kind; as do MEMORY_READ or MEMORY_WRITE */
    stage_set stages;     /* a barrier that names one of these includes the kind */
    const char *stage_name, *flag_name;
} kinds[ACCESS_KINDS] = {
#define KIND(kind, stage, is_write, flags, stage_name, flag)                                       \
    [ACCESS_##kind] = {stage, is_write, flags, BIT(stage), stage_name, #flag}
#define READ(kind, stage, stage_name, flag)                                                        \
    KIND(kind, stage, false, VK_ACCESS_2_##flag, stage_name, flag)
#define WRITE(kind, stage, stage_name, flag)                                                       \
    KIND(kind, stage, true, VK_ACCESS_2_##flag, stage_name, flag)
#define AT_COPY "COPY_BIT"
#define AT_HOST "HOST_BIT"
#define AT_ACCEL_COPY "ACCELERATION_STRUCTURE_COPY_BIT_KHR"
#define AT_COMPUTE "COMPUTE_SHADER_BIT"
#define AT_RAYS "RAY_TRACING_SHADER_BIT_KHR"
    READ(BUILD_ACCEL_READ, SYNC_BUILD, AT_BUILD, ACCELERATION_STRUCTURE_READ_BIT_KHR),
    WRITE(BUILD_ACCEL_WRITE, SYNC_BUILD, AT_BUILD, ACCELERATION_STRUCTURE_WRITE_BIT_KHR),
    KIND(BUILD_SHADER_READ, SYNC_BUILD, false, SHADER_READS, AT_BUILD, SHADER_READ_BIT),
    READ(BUILD_INDIRECT_READ, SYNC_BUILD, AT_BUILD, INDIRECT_COMMAND_READ_BIT),
    READ(BUILD_MICROMAP_READ, SYNC_BUILD, AT_BUILD, MICROMAP_READ_BIT_EXT),
    READ(COPY_ACCEL_READ, SYNC_ACCEL_COPY, AT_ACCEL_COPY, ACCELERATION_STRUCTURE_READ_BIT_KHR),
    WRITE(COPY_ACCEL_WRITE, SYNC_ACCEL_COPY, AT_ACCEL_COPY, ACCELERATION_STRUCTURE_WRITE_BIT_KHR),
    READ(COPY_ACCEL_TRANSFER_READ, SYNC_ACCEL_COPY, AT_ACCEL_COPY, TRANSFER_READ_BIT),
    WRITE(COPY_ACCEL_TRANSFER_WRITE, SYNC_ACCEL_COPY, AT_ACCEL_COPY, TRANSFER_WRITE_BIT),
    READ(TRANSFER_READ, SYNC_COPY, AT_COPY, TRANSFER_READ_BIT),
    WRITE(TRANSFER_WRITE, SYNC_COPY, AT_COPY, TRANSFER_WRITE_BIT),
    /* Both COPY and CLEAR include it; ALL_TRANSFER is right in either reading. */
    WRITE(FILL_WRITE, SYNC_FILL, "ALL_TRANSFER_BIT", TRANSFER_WRITE_BIT),
    /* The stages of a barrier must include TRANSFER and the stage that the command names. */
    WRITE(MARKER_WRITE, SYNC_FILL, AT_ALL, TRANSFER_WRITE_BIT),
    READ(MICROMAP_READ, SYNC_MICROMAP, AT_MICROMAP, MICROMAP_READ_BIT_EXT),
    WRITE(MICROMAP_WRITE, SYNC_MICROMAP, AT_MICROMAP, MICROMAP_WRITE_BIT_EXT),
    KIND(MICROMAP_SHADER_READ, SYNC_MICROMAP, false, SHADER_READS, AT_MICROMAP, SHADER_READ_BIT),
    READ(MICROMAP_TRANSFER_READ, SYNC_MICROMAP, AT_MICROMAP, TRANSFER_READ_BIT),
    WRITE(MICROMAP_TRANSFER_WRITE, SYNC_MICROMAP, AT_MICROMAP, TRANSFER_WRITE_BIT),
    READ(HOST_READ, SYNC_HOST, AT_HOST, HOST_READ_BIT),
    WRITE(HOST_WRITE, SYNC_HOST, AT_HOST, HOST_WRITE_BIT),
    READ(COMPUTE_TRACE, SYNC_COMPUTE_SHADER, AT_COMPUTE, ACCELERATION_STRUCTURE_READ_BIT_KHR),
    READ(RAYS_TRACE, SYNC_RAY_TRACING_SHADER, AT_RAYS, ACCELERATION_STRUCTURE_READ_BIT_KHR),
    KIND(COMPUTE_WRITE, SYNC_COMPUTE_SHADER, true, SHADER_WRITES, AT_COMPUTE, SHADER_WRITE_BIT),
    KIND(RAYS_WRITE, SYNC_RAY_TRACING_SHADER, true, SHADER_WRITES, AT_RAYS, SHADER_WRITE_BIT),
    [ACCESS_GRAPHICS_WRITE] = {SYNC_DRAW_INDIRECT, true, SHADER_WRITES, GRAPHICS, AT_ALL,
                               "SHADER_WRITE_BIT"},
};

/* Every access flag that the table does not have although the specification defines it. None is a
 * tracked access. */
static const VkAccessFlags2 untracked_accesses =
    VK_ACCESS_2_INDEX_READ_BIT | VK_ACCESS_2_VERTEX_ATTRIBUTE_READ_BIT |
    VK_ACCESS_2_UNIFORM_READ_BIT | VK_ACCESS_2_INPUT_ATTACHMENT_READ_BIT |
    VK_ACCESS_2_COLOR_ATTACHMENT_READ_BIT | VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT |
    VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_READ_BIT | VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT |
    VK_ACCESS_2_VIDEO_DECODE_READ_BIT_KHR | VK_ACCESS_2_VIDEO_DECODE_WRITE_BIT_KHR |
    VK_ACCESS_2_VIDEO_ENCODE_READ_BIT_KHR | VK_ACCESS_2_VIDEO_ENCODE_WRITE_BIT_KHR |
    VK_ACCESS_2_TRANSFORM_FEEDBACK_WRITE_BIT_EXT |
    VK_ACCESS_2_TRANSFORM_FEEDBACK_COUNTER_READ_BIT_EXT |
    VK_ACCESS_2_TRANSFORM_FEEDBACK_COUNTER_WRITE_BIT_EXT |
    VK_ACCESS_2_CONDITIONAL_RENDERING_READ_BIT_EXT | VK_ACCESS_2_COMMAND_PREPROCESS_READ_BIT_EXT |
    VK_ACCESS_2_COMMAND_PREPROCESS_WRITE_BIT_EXT |
    VK_ACCESS_2_FRAGMENT_SHADING_RATE_ATTACHMENT_READ_BIT_KHR |
    VK_ACCESS_2_FRAGMENT_DENSITY_MAP_READ_BIT_EXT |
    VK_ACCESS_2_COLOR_ATTACHMENT_READ_NONCOHERENT_BIT_EXT |
    VK_ACCESS_2_DESCRIPTOR_BUFFER_READ_BIT_EXT | VK_ACCESS_2_INVOCATION_MASK_READ_BIT_HUAWEI |
    VK_ACCESS_2_OPTICAL_FLOW_READ_BIT_NV | VK_ACCESS_2_OPTICAL_FLOW_WRITE_BIT_NV |
    VK_ACCESS_2_DATA_GRAPH_READ_BIT_ARM | VK_ACCESS_2_DATA_GRAPH_WRITE_BIT_ARM |
    VK_ACCESS_2_MEMORY_DECOMPRESSION_READ_BIT_EXT | VK_ACCESS_2_MEMORY_DECOMPRESSION_WRITE_BIT_EXT |
    VK_ACCESS_2_SAMPLER_HEAP_READ_BIT_EXT | VK_ACCESS_2_RESOURCE_HEAP_READ_BIT_EXT;

enum sync_stage access_stage(enum access_kind kind)
{
    return kinds[kind].stage;
}

stage_set access_stages(enum access_kind kind)
{
    return kinds[kind].stages;
}

bool access_is_write(enum access_kind kind)
{
    return kinds[kind].is_write;
}

static bool is_of_micromaps(enum access_kind kind)
{
    return kinds[kind].stage == SYNC_MICROMAP || kind == ACCESS_BUILD_MICROMAP_READ;
}

/* Each stage that is not enabled is part of ALL_COMMANDS, or of another one. The first version of
 * the flags has one stage for transfers, and nothing of micromaps. */
static const char *stage_of(enum access_kind kind, const struct barrier_features *features)
{
    const bool is_2 = features->synchronization2;
    switch (kinds[kind].stage) {
    case SYNC_ACCEL_COPY:
        if (is_2 && features->structure_copies)
            break;
        return features->structures ? AT_BUILD : AT_ALL;
    case SYNC_BUILD:
        return features->structures ? AT_BUILD : AT_ALL;
    case SYNC_MICROMAP:
        return is_2 && features->micromaps ? AT_MICROMAP : AT_ALL;
    case SYNC_COPY:
    case SYNC_FILL:
        if (!is_2 && kind != ACCESS_MARKER_WRITE)
            return "TRANSFER_BIT";
        break;
    default:
        break;
    }
    return kinds[kind].stage_name;
}

struct access_names access_names(enum access_kind kind, const struct barrier_features *features)
{
    const bool is_2 = features->synchronization2;
    struct access_names names = {is_2 ? "VK_PIPELINE_STAGE_2_" : "VK_PIPELINE_STAGE_",
                                 stage_of(kind, features), is_2 ? "VK_ACCESS_2_" : "VK_ACCESS_",
                                 kinds[kind].flag_name};
    if (is_of_micromaps(kind) && !(is_2 && features->micromaps))
        names.access = kinds[kind].is_write ? "MEMORY_WRITE_BIT" : "MEMORY_READ_BIT";
    return names;
}

/* Returns the kinds that `flags` include at `stages`. */
static kind_set named_kinds(VkAccessFlags2 flags, stage_set stages)
{
    VkAccessFlags2 unknown =
        flags & ~(untracked_accesses | VK_ACCESS_2_MEMORY_READ_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT);
    kind_set at_stages = 0, named = 0;
    if (!flags)
        return 0;
    for (unsigned i = 0; i < ACCESS_KINDS; i++) {
        const VkAccessFlags2 all =
            kinds[i].is_write ? VK_ACCESS_2_MEMORY_WRITE_BIT : VK_ACCESS_2_MEMORY_READ_BIT;
        if (!(stages & access_stages((enum access_kind)i)))
            continue;
        at_stages |= (kind_set)1 << i;
        unknown &= ~kinds[i].flags;
        if (flags & (kinds[i].flags | all))
            named |= (kind_set)1 << i;
    }
    /* Flags of other stages are known, too. */
    for (unsigned i = 0; i < ACCESS_KINDS && unknown; i++)
        unknown &= ~kinds[i].flags;
    return unknown ? at_stages : named;
}

/* ---- dependencies */

struct dependency dependency_of(VkPipelineStageFlags2 src_stages, VkAccessFlags2 src_access,
                                VkPipelineStageFlags2 dst_stages, VkAccessFlags2 dst_access)
{
    const VkPipelineStageFlags2 ends =
        VK_PIPELINE_STAGE_2_TOP_OF_PIPE_BIT | VK_PIPELINE_STAGE_2_BOTTOM_OF_PIPE_BIT;
    const stage_set src = named_stages(src_stages & ~ends), dst = named_stages(dst_stages & ~ends);
    struct dependency dependency = {.src = with_earlier(src),
                                    .dst = with_later(dst),
                                    .src_kinds = named_kinds(src_access, src),
                                    .dst_kinds = named_kinds(dst_access, dst)};
    /* BOTTOM_OF_PIPE as source and TOP_OF_PIPE as destination are ALL_COMMANDS without accesses;
     * the other way round they are NONE. */
    if (src_stages & VK_PIPELINE_STAGE_2_BOTTOM_OF_PIPE_BIT)
        dependency.src |= DEVICE_STAGES;
    if (dst_stages & VK_PIPELINE_STAGE_2_TOP_OF_PIPE_BIT)
        dependency.dst |= DEVICE_STAGES;
    return dependency;
}

/* Returns all kinds at the stages. */
static kind_set kinds_at(stage_set stages)
{
    return named_kinds(VK_ACCESS_2_MEMORY_READ_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT, stages);
}

/* The access scopes of semaphore operations include all accesses of the device (vkQueueSubmit2).
 * So all accesses in the scope of stages count, even if the mask is TOP_OF_PIPE. */
struct dependency dependency_of_signal(VkPipelineStageFlags2 stages)
{
    struct dependency signal = dependency_of(stages, VK_ACCESS_2_NONE, 0, 0);
    signal.src_kinds = kinds_at(signal.src);
    return signal;
}

struct dependency dependency_of_wait(VkPipelineStageFlags2 stages)
{
    struct dependency wait = dependency_of(0, 0, stages, VK_ACCESS_2_NONE);
    wait.dst_kinds = kinds_at(wait.dst);
    return wait;
}
