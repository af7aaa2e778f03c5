/* SPDX-License-Identifier: Apache-2.0 */
/* Records commands that run shaders, and which of them trace rays. What shaders access is decided
 * by descriptors and code, which are not followed: a shader may write any bytes. */
#include "layer/execution/hazards/host_writes.h"
#include "layer/hazards/recording.h"
#include "layer/hazards/traced.h"
#include "observers.h"
#include "src/base/chain.h"
#include "src/base/readable.h"
#include "src/view/shader_code.h"

/* ---- commands */

static void add_shader_access(struct hazard_recording *recording, enum access_kind kind)
{
    hazard_recording_add_anywhere(recording,
                                  &(struct hazard_use){.kind = kind, .role = HAZARD_SHADER});
}

/* Without memory for what may be traced the trace is left out, too. */
static void add_trace(struct hazard_recording *recording, enum access_kind kind,
                      enum traced_point point)
{
    hazards_add_traced(recording, kind, point);
    if (!recording->journal->lacks_hazards)
        add_shader_access(recording, kind);
}

/* A command adds nothing if it follows one of the same name, with no other entry between them.
 * Returns whether it was added. */
static bool add_command(struct hazard_recording *recording, const char *name,
                        enum access_kind write)
{
    struct journal *journal = recording->journal;
    if (journal->shaders_end && journal->shaders_end == journal->entries.next &&
        journal->shaders_name == name)
        return false;
    hazard_recording_command(recording, name, NULL);
    add_shader_access(recording, write);
    return true;
}

static void end_command(struct hazard_recording *recording, const char *name)
{
    recording->journal->shaders_end = recording->journal->entries.next;
    recording->journal->shaders_name = name;
}

void hazards_draw(struct hazard_recording *recording, const char *name)
{
    if (add_command(recording, name, ACCESS_GRAPHICS_WRITE))
        end_command(recording, name);
}

/* Conditional rendering leaves dispatches out, and no traces of rays. */
static bool has_condition(const struct hazard_recording *recording)
{
    const struct command_buffer *command_buffer = recording->command_buffer;
    return recording->journal->has_condition ||
           (command_buffer && command_buffer->inherits_conditions);
}

/* A command without groups, or rays, runs no shader. */
void hazards_dispatch(struct hazard_recording *recording, const char *name, uint32_t x, uint32_t y,
                      uint32_t z)
{
    if (!x || !y || !z || !add_command(recording, name, ACCESS_COMPUTE_WRITE))
        return;
    if (recording->journal->has_tracing_pipeline && !has_condition(recording))
        add_trace(recording, ACCESS_COMPUTE_TRACE, TRACED_BY_COMPUTE);
    end_command(recording, name);
}

void hazards_trace(struct hazard_recording *recording, const char *name, uint32_t width,
                   uint32_t height, uint32_t depth)
{
    if (!width || !height || !depth || !add_command(recording, name, ACCESS_RAYS_WRITE))
        return;
    add_trace(recording, ACCESS_RAYS_TRACE, TRACED_BY_RAYS);
    end_command(recording, name);
}

/* The size is in device memory, and may be 0: then nothing is traced. */
void hazards_dispatch_indirect(struct hazard_recording *recording, const char *name)
{
    if (add_command(recording, name, ACCESS_COMPUTE_WRITE))
        end_command(recording, name);
}

void hazards_trace_indirect(struct hazard_recording *recording, const char *name)
{
    if (add_command(recording, name, ACCESS_RAYS_WRITE))
        end_command(recording, name);
}

void hazards_write_unfollowed(struct hazard_recording *command)
{
    hazard_recording_add_anywhere(
        command, &(struct hazard_use){.kind = ACCESS_TRANSFER_WRITE, .role = HAZARD_DST});
}

void hazards_build_unfollowed(struct hazard_recording *command)
{
    hazard_recording_add_anywhere(
        command, &(struct hazard_use){.kind = ACCESS_BUILD_ACCEL_WRITE, .role = HAZARD_TOP_DST});
}

/* ---- which shaders trace rays */

void hazards_note_module(struct layer_device *device, VkShaderModule module,
                         const VkShaderModuleCreateInfo *info)
{
    const bool traces = shader_code_traces(info->pCode, info->codeSize);
    hazard_objects_set_tracing(device->hazard_objects, TRACING_MODULE, (uint64_t)(uintptr_t)module,
                               shader_code_certainly_traces(info->pCode, info->codeSize));
    if (shader_code_stores(info->pCode, info->codeSize))
        host_writes_stop(device->host_writes);
    if (traces && shader_code_traces_addresses(info->pCode, info->codeSize))
        hazards_lack_descriptors(device);
}

void hazards_forget_module(struct layer_device *device, VkShaderModule module)
{
    hazard_objects_set_tracing(device->hazard_objects, TRACING_MODULE, (uint64_t)(uintptr_t)module,
                               false);
}

/* ---- which shaders write through addresses */

void hazards_note_unseen_code(struct layer_device *device)
{
    host_writes_stop(device->host_writes);
    hazards_lack_descriptors(device);
}

/* The stages may be ignored, and then be no pointer. The code of modules was read before. */
static void note_stages(struct layer_device *device, uint32_t count,
                        const VkPipelineShaderStageCreateInfo *stages)
{
    if (!count || !readable(readable_cache_of_thread(), stages, count * sizeof(*stages)))
        return;
    for (uint32_t i = 0; i < count; i++) {
        if (shader_stage_stores(&stages[i]))
            hazards_note_unseen_code(device);
        if (shader_stage_traces_addresses(&stages[i]))
            hazards_lack_descriptors(device);
    }
}

void hazards_note_graphics_pipelines(struct layer_device *device, uint32_t count,
                                     const VkGraphicsPipelineCreateInfo *infos)
{
    for (uint32_t i = 0; i < count; i++) {
        note_stages(device, infos[i].stageCount, infos[i].pStages);
        if (chain_find(infos[i].pNext,
                       VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_SHADER_GROUPS_CREATE_INFO_NV))
            hazards_note_unseen_code(device);
    }
}

void hazards_note_ray_pipelines(struct layer_device *device, uint32_t count,
                                const VkRayTracingPipelineCreateInfoKHR *infos)
{
    for (uint32_t i = 0; i < count; i++)
        note_stages(device, infos[i].stageCount, infos[i].pStages);
}

void hazards_note_ray_pipelines_nv(struct layer_device *device, uint32_t count,
                                   const VkRayTracingPipelineCreateInfoNV *infos)
{
    for (uint32_t i = 0; i < count; i++)
        note_stages(device, infos[i].stageCount, infos[i].pStages);
}

void hazards_note_shaders(struct layer_device *device, uint32_t count,
                          const VkShaderCreateInfoEXT *infos)
{
    for (uint32_t i = 0; i < count; i++)
        if (infos[i].codeType != VK_SHADER_CODE_TYPE_SPIRV_EXT ||
            shader_code_stores(infos[i].pCode, infos[i].codeSize))
            hazards_note_unseen_code(device);
}

/* ---- which shaders trace rays */

static bool stage_traces(const struct layer_device *device,
                         const VkPipelineShaderStageCreateInfo *stage)
{
    return shader_stage_certainly_traces(stage) ||
           hazard_objects_trace(device->hazard_objects, TRACING_MODULE,
                                (uint64_t)(uintptr_t)stage->module);
}

void hazards_note_compute_pipelines(struct layer_device *device, uint32_t count,
                                    const VkComputePipelineCreateInfo *infos, VkPipeline *pipelines)
{
    for (uint32_t i = 0; i < count; i++) {
        hazard_objects_set_tracing(device->hazard_objects, TRACING_PIPELINE,
                                   (uint64_t)(uintptr_t)pipelines[i],
                                   stage_traces(device, &infos[i].stage));
        note_stages(device, 1, &infos[i].stage);
    }
}

void hazards_forget_pipeline(struct layer_device *device, VkPipeline pipeline)
{
    hazard_objects_set_tracing(device->hazard_objects, TRACING_PIPELINE,
                               (uint64_t)(uintptr_t)pipeline, false);
}

void hazards_bind_pipeline(struct hazard_recording *recording, VkPipelineBindPoint point,
                           VkPipeline pipeline)
{
    if (point != VK_PIPELINE_BIND_POINT_COMPUTE)
        return;
    recording->journal->has_tracing_pipeline = hazard_objects_trace(
        recording->device->hazard_objects, TRACING_PIPELINE, (uint64_t)(uintptr_t)pipeline);
    recording->journal->shaders_end = NULL;
}

void hazards_begin_condition(struct hazard_recording *recording)
{
    recording->journal->has_condition = true;
}

void hazards_end_condition(struct hazard_recording *recording)
{
    recording->journal->has_condition = false;
    recording->journal->shaders_end = NULL;
}

/* Which shader objects trace rays is not known. */
void hazards_bind_shaders(struct hazard_recording *recording)
{
    recording->journal->has_tracing_pipeline = false;
    recording->journal->shaders_end = NULL;
}

/* ---- memory that more than buffers use */

void hazards_share_memory(struct layer_device *device, VkDeviceMemory memory)
{
    resources_share_memory(device->resources, memory);
}

void hazards_share_memories(struct layer_device *device, uint32_t count,
                            const VkBindImageMemoryInfo *infos)
{
    for (uint32_t i = 0; i < count; i++)
        resources_share_memory(device->resources, infos[i].memory);
}
