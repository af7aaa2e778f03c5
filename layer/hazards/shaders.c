/* SPDX-License-Identifier: Apache-2.0 */
/* Records commands that run shaders, and reads the code of shaders and pipelines. */
#include "layer/hazards/executed/host_writes.h"
#include "layer/hazards/pipelines.h"
#include "layer/hazards/recording.h"
#include "layer/hazards/traced.h"
#include "observers.h"
#include "src/base/chain.h"
#include "src/base/readable.h"

/* ---- commands */

/* A command adds nothing if it follows one of the same name, with no other entry between them and
 * nothing else bound. */
static void add_command(struct hazard_recording *recording, const struct shader_command *command)
{
    struct journal *journal = recording->journal;
    if (journal->shaders_end && journal->shaders_end == journal->entries.next &&
        journal->shaders_name == command->name)
        return;
    hazards_add_shaders(recording, command);
    journal->shaders_end = journal->entries.next;
    journal->shaders_name = command->name;
}

void hazards_draw(struct hazard_recording *recording, const char *name)
{
    add_command(recording, &(struct shader_command){.name = name,
                                                    .point = SHADERS_OF_GRAPHICS,
                                                    .write = ACCESS_GRAPHICS_WRITE,
                                                    .trace = ACCESS_KINDS});
}

/* A command without groups, or rays, runs no shader. */
void hazards_dispatch(struct hazard_recording *recording, const char *name, uint32_t base_x,
                      uint32_t base_y, uint32_t base_z, uint32_t x, uint32_t y, uint32_t z)
{
    if (x && y && z)
        add_command(recording, &(struct shader_command){.name = name,
                                                        .point = SHADERS_OF_COMPUTE,
                                                        .write = ACCESS_COMPUTE_WRITE,
                                                        .trace = ACCESS_COMPUTE_TRACE,
                                                        .base = {base_x, base_y, base_z},
                                                        .size = {x, y, z}});
}

void hazards_trace(struct hazard_recording *recording, const char *name, uint32_t width,
                   uint32_t height, uint32_t depth)
{
    if (width && height && depth)
        add_command(recording, &(struct shader_command){.name = name,
                                                        .point = SHADERS_OF_RAYS,
                                                        .write = ACCESS_RAYS_WRITE,
                                                        .trace = ACCESS_RAYS_TRACE,
                                                        .size = {width, height, depth}});
}

/* The size is in device memory, and may be 0: then nothing is traced. */
void hazards_dispatch_indirect(struct hazard_recording *recording, const char *name)
{
    add_command(recording, &(struct shader_command){.name = name,
                                                    .point = SHADERS_OF_COMPUTE,
                                                    .write = ACCESS_COMPUTE_WRITE,
                                                    .trace = ACCESS_COMPUTE_TRACE});
}

void hazards_trace_indirect(struct hazard_recording *recording, const char *name)
{
    add_command(recording, &(struct shader_command){.name = name,
                                                    .point = SHADERS_OF_RAYS,
                                                    .write = ACCESS_RAYS_WRITE,
                                                    .trace = ACCESS_RAYS_TRACE});
}

void hazards_write_unfollowed(struct hazard_recording *command)
{
    hazard_recording_add_anywhere(
        command, &(struct hazard_use){.kind = ACCESS_TRANSFER_WRITE, .role = HAZARD_DST});
}

void hazards_begin_condition(struct hazard_recording *recording)
{
    recording->journal->has_condition = true;
    recording->journal->shaders_end = NULL;
}

void hazards_end_condition(struct hazard_recording *recording)
{
    recording->journal->has_condition = false;
    recording->journal->shaders_end = NULL;
}

/* ---- modules and pipelines */

void hazards_note_module(struct layer_device *device, VkShaderModule module,
                         const VkShaderModuleCreateInfo *info)
{
    struct shader_pipelines *pipelines = hazard_objects_pipelines(device->hazard_objects);
    if (pipelines)
        shader_pipelines_note_module(pipelines, module, info);
}

void hazards_forget_module(struct layer_device *device, VkShaderModule module)
{
    struct shader_pipelines *pipelines = hazard_objects_pipelines(device->hazard_objects);
    if (pipelines)
        shader_pipelines_forget_module(pipelines, module);
}

/* Code that is not seen may write through addresses. */
void hazards_note_unseen_code(struct layer_device *device)
{
    host_writes_stop(device->host_writes);
}

void hazards_note_shaders(struct layer_device *device, uint32_t count,
                          const VkShaderCreateInfoEXT *infos)
{
    for (uint32_t i = 0; i < count; i++) {
        struct shader_facts facts = shader_facts_unknown();
        struct spirv spirv;
        if (infos[i].codeType == VK_SHADER_CODE_TYPE_SPIRV_EXT &&
            spirv_open(&spirv, infos[i].pCode, infos[i].codeSize)) {
            const uint32_t entry =
                spirv_find_entry(&spirv, infos[i].pName, shader_model(infos[i].stage));
            if (entry)
                shader_facts_read(&spirv, entry, &facts);
            spirv_close(&spirv);
        }
        if (facts.stores_addresses)
            hazards_note_unseen_code(device);
    }
}

/* Flags of pipelines whose shaders get resources in ways that are not followed. */
static const VkPipelineCreateFlags2 unfollowed_flags =
    VK_PIPELINE_CREATE_2_DESCRIPTOR_BUFFER_BIT_EXT | VK_PIPELINE_CREATE_2_DESCRIPTOR_HEAP_BIT_EXT |
    VK_PIPELINE_CREATE_2_LIBRARY_BIT_KHR;

/* Whether the chain of a pipeline's parameters has only structures that neither add shaders nor
 * change what shaders access. For all other structures that is unknown. */
static bool is_plain_chain(const void *chain)
{
    for (const VkBaseInStructure *s = chain; s; s = s->pNext)
        switch (s->sType) {
        case VK_STRUCTURE_TYPE_PIPELINE_CREATION_FEEDBACK_CREATE_INFO:
        case VK_STRUCTURE_TYPE_PIPELINE_RENDERING_CREATE_INFO:
        case VK_STRUCTURE_TYPE_PIPELINE_ROBUSTNESS_CREATE_INFO:
        case VK_STRUCTURE_TYPE_PIPELINE_FRAGMENT_SHADING_RATE_STATE_CREATE_INFO_KHR:
        case VK_STRUCTURE_TYPE_PIPELINE_CREATE_FLAGS_2_CREATE_INFO:
            break;
        default:
            return false;
        }
    return true;
}

static bool is_whole(const void *chain, VkPipelineCreateFlags flags)
{
    const VkPipelineCreateFlags2CreateInfo *more =
        chain_find(chain, VK_STRUCTURE_TYPE_PIPELINE_CREATE_FLAGS_2_CREATE_INFO);
    return is_plain_chain(chain) && !((more ? more->flags : flags) & unfollowed_flags);
}

/* Until a deferred creation is complete, and if a creation has failed, there is no handle. A handle
 * that is not known names a pipeline which may do anything. */
static void note_pipeline(struct layer_device *device, const VkPipeline *handle, VkResult result,
                          bool has_all, uint32_t count,
                          const VkPipelineShaderStageCreateInfo *stages)
{
    struct shader_pipelines *pipelines = hazard_objects_pipelines(device->hazard_objects);
    struct shader_pipeline *pipeline =
        pipelines ? shader_pipeline_read(pipelines, count, stages, has_all) : NULL;
    const struct shader_facts *facts = pipeline ? shader_pipeline_facts(pipeline) : NULL;
    if (!facts || facts->stores_addresses)
        hazards_note_unseen_code(device);
    if (!facts || facts->stores.count || facts->stores.has_others)
        atomic_store(&device->shaders_write, true);
    if (pipeline && result >= 0 && result != VK_OPERATION_DEFERRED_KHR)
        shader_pipelines_add(pipelines, *handle, pipeline);
    else
        shader_pipeline_release(pipeline);
}

void hazards_note_graphics_pipelines(struct layer_device *device, uint32_t count,
                                     const VkGraphicsPipelineCreateInfo *infos,
                                     VkPipeline *pipelines, VkResult result)
{
    for (uint32_t i = 0; i < count; i++)
        note_pipeline(device, &pipelines[i], result, is_whole(infos[i].pNext, infos[i].flags),
                      infos[i].stageCount, infos[i].pStages);
}

void hazards_note_compute_pipelines(struct layer_device *device, uint32_t count,
                                    const VkComputePipelineCreateInfo *infos, VkPipeline *pipelines,
                                    VkResult result)
{
    for (uint32_t i = 0; i < count; i++)
        note_pipeline(device, &pipelines[i], result, is_whole(infos[i].pNext, infos[i].flags), 1,
                      &infos[i].stage);
}

void hazards_note_ray_pipelines(struct layer_device *device, uint32_t count,
                                const VkRayTracingPipelineCreateInfoKHR *infos,
                                VkPipeline *pipelines, VkResult result)
{
    for (uint32_t i = 0; i < count; i++)
        note_pipeline(device, &pipelines[i], result,
                      is_whole(infos[i].pNext, infos[i].flags) && !infos[i].pLibraryInfo,
                      infos[i].stageCount, infos[i].pStages);
}

void hazards_note_ray_pipelines_nv(struct layer_device *device, uint32_t count,
                                   const VkRayTracingPipelineCreateInfoNV *infos,
                                   VkPipeline *pipelines, VkResult result)
{
    for (uint32_t i = 0; i < count; i++)
        note_pipeline(device, &pipelines[i], result, is_whole(infos[i].pNext, infos[i].flags),
                      infos[i].stageCount, infos[i].pStages);
}

void hazards_forget_pipeline(struct layer_device *device, VkPipeline pipeline)
{
    struct shader_pipelines *pipelines = hazard_objects_pipelines(device->hazard_objects);
    if (pipelines && pipeline)
        shader_pipelines_remove(pipelines, pipeline);
}

/* ---- memory that more than buffers use */

void hazards_share_memories(struct layer_device *device, uint32_t count,
                            const VkBindImageMemoryInfo *infos)
{
    for (uint32_t i = 0; i < count; i++)
        resources_share_memory(device->resources, infos[i].memory);
}
