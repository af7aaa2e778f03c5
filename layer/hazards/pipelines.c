/* SPDX-License-Identifier: Apache-2.0 */
#include "layer/hazards/pipelines.h"
#include "src/base/handle.h"

#include <stdlib.h>
#include <string.h>

#include "src/base/chain.h"
#include "src/base/readable.h"

/* ---- modules */

/* A copy of a module's code. Shared by pipelines. */
struct shader_code {
    atomic_uint references;
    size_t size;
    uint32_t words[];
};

static struct shader_code *copy_code(const VkShaderModuleCreateInfo *info)
{
    struct shader_code *code = readable(readable_cache_of_thread(), info->pCode, info->codeSize)
                                   ? malloc(sizeof(*code) + info->codeSize + sizeof(uint32_t))
                                   : NULL;
    if (!code)
        return NULL;
    atomic_init(&code->references, 1);
    code->size = info->codeSize;
    memcpy(code->words, info->pCode, info->codeSize);
    return code;
}

static void release_code(void *record)
{
    struct shader_code *code = record;
    if (code && atomic_fetch_sub(&code->references, 1) == 1)
        free(code);
}

static void set_record(struct shader_pipelines *pipelines, struct handle_table *table,
                       uint64_t handle, void *record, void (*release)(void *))
{
    reader_lock_write(&pipelines->lock);
    void *old = handle_table_remove(table, handle);
    const bool is_kept = record && handle_table_set(table, handle, record);
    reader_lock_write_done(&pipelines->lock);
    release(old);
    if (!is_kept)
        release(record);
}

void shader_pipelines_note_module(struct shader_pipelines *pipelines, VkShaderModule module,
                                  const VkShaderModuleCreateInfo *info)
{
    set_record(pipelines, &pipelines->modules, handle_number(module), copy_code(info),
               release_code);
}

void shader_pipelines_forget_module(struct shader_pipelines *pipelines, VkShaderModule module)
{
    if (module)
        set_record(pipelines, &pipelines->modules, handle_number(module), NULL, release_code);
}

/* Returns a reference to the code of a stage; NULL: it is not seen. */
static struct shader_code *find_code(struct shader_pipelines *pipelines,
                                     const VkPipelineShaderStageCreateInfo *stage)
{
    const VkShaderModuleCreateInfo *info =
        stage->module ? NULL
                      : chain_find(stage->pNext, VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO);
    if (info)
        return copy_code(info);
    const unsigned stripe = reader_lock_enter(&pipelines->lock);
    struct shader_code *code =
        stage->module ? handle_table_find(&pipelines->modules, handle_number(stage->module)) : NULL;
    if (code)
        atomic_fetch_add(&code->references, 1);
    reader_lock_leave(&pipelines->lock, stripe);
    return code;
}

/* ---- pipelines */

/* A shader that a command begins with, and that may trace. */
struct first_shader {
    struct shader_code *code; /* NULL: unknown */
    struct spirv spirv;       /* of the code */
    uint32_t entry;
    VkSpecializationInfo constants; /* owned copies */
};

struct shader_pipeline {
    atomic_uint references;
    struct shader_facts facts;
    bool is_whole; /* `shaders` has all shaders that a command may begin with */
    uint32_t count;
    struct first_shader shaders[];
};

void shader_pipeline_release(struct shader_pipeline *pipeline)
{
    if (!pipeline || atomic_fetch_sub(&pipeline->references, 1) != 1)
        return;
    for (uint32_t i = 0; i < pipeline->count; i++) {
        if (pipeline->shaders[i].code)
            spirv_close(&pipeline->shaders[i].spirv);
        release_code(pipeline->shaders[i].code);
        free((void *)pipeline->shaders[i].constants.pMapEntries);
        free((void *)pipeline->shaders[i].constants.pData);
    }
    free(pipeline);
}

static void release_pipeline(void *record)
{
    shader_pipeline_release(record);
}

const struct shader_facts *shader_pipeline_facts(const struct shader_pipeline *pipeline)
{
    return &pipeline->facts;
}

/* Returns a copy of readable memory, or NULL. */
static void *copy_memory(const void *from, size_t size)
{
    void *copy = size && readable(readable_cache_of_thread(), from, size) ? malloc(size) : NULL;
    if (copy)
        memcpy(copy, from, size);
    return copy;
}

/* Returns false if the constants are not known. */
static bool copy_constants(const VkSpecializationInfo *from, VkSpecializationInfo *to)
{
    *to = (VkSpecializationInfo){.mapEntryCount = 0};
    if (!from)
        return true;
    if (!readable(readable_cache_of_thread(), from, sizeof(*from)))
        return false;
    *to = *from;
    to->pMapEntries =
        copy_memory(from->pMapEntries, from->mapEntryCount * sizeof(*from->pMapEntries));
    to->pData = copy_memory(from->pData, from->dataSize);
    return (!to->mapEntryCount || to->pMapEntries) && (!to->dataSize || to->pData);
}

/* Adds the facts of a stage. `first`: the record of a shader that a command begins with, or NULL.
 */
static void read_stage(struct shader_pipelines *pipelines,
                       const VkPipelineShaderStageCreateInfo *stage, struct shader_facts *facts,
                       struct first_shader *first)
{
    struct shader_code *code = find_code(pipelines, stage);
    struct shader_facts read = shader_facts_unknown();
    struct spirv spirv;
    if (code && spirv_open(&spirv, code->words, code->size)) {
        const uint32_t entry = spirv_find_entry(&spirv, stage->pName, shader_model(stage->stage));
        if (entry)
            shader_facts_read(&spirv, entry, &read);
        if (entry && first && read.may_trace &&
            copy_constants(stage->pSpecializationInfo, &first->constants)) {
            first->entry = entry;
            first->code = code;
            first->spirv = spirv;
            code = NULL;
        } else {
            spirv_close(&spirv);
        }
    }
    release_code(code);
    shader_facts_add(facts, &read);
}

static bool begins_command(VkShaderStageFlagBits stage)
{
    return stage == VK_SHADER_STAGE_COMPUTE_BIT || stage == VK_SHADER_STAGE_RAYGEN_BIT_KHR;
}

struct shader_pipeline *shader_pipeline_read(struct shader_pipelines *pipelines, uint32_t count,
                                             const VkPipelineShaderStageCreateInfo *stages,
                                             bool is_whole)
{
    const bool is_readable =
        count && readable(readable_cache_of_thread(), stages, count * sizeof(*stages));
    struct shader_pipeline *pipeline =
        calloc(1, sizeof(*pipeline) + count * sizeof(pipeline->shaders[0]));
    if (!pipeline)
        return NULL;
    atomic_init(&pipeline->references, 1);
    pipeline->is_whole = is_readable && is_whole;
    pipeline->facts = (struct shader_facts){.is_known = true};
    for (uint32_t i = 0; is_readable && i < count; i++)
        read_stage(pipelines, &stages[i], &pipeline->facts,
                   begins_command(stages[i].stage) ? &pipeline->shaders[pipeline->count++] : NULL);
    if (!pipeline->is_whole)
        pipeline->facts = shader_facts_unknown();
    return pipeline;
}

bool shader_pipeline_traces(const struct shader_pipeline *pipeline, struct shader_launch *launch,
                            struct traced_descriptor *traced)
{
    bool traces = pipeline->is_whole && pipeline->count && pipeline->facts.may_trace;
    for (uint32_t i = 0; traces && i < pipeline->count; i++) {
        const struct first_shader *shader = &pipeline->shaders[i];
        launch->constants = &shader->constants;
        traces =
            shader->code && shader_certainly_traces(&shader->spirv, shader->entry, launch, traced);
    }
    traced->is_known &= pipeline->count == 1;
    return traces;
}

/* ---- by handle */

void shader_pipelines_add(struct shader_pipelines *pipelines, VkPipeline handle,
                          struct shader_pipeline *pipeline)
{
    if (handle)
        set_record(pipelines, &pipelines->pipelines, handle_number(handle), pipeline,
                   release_pipeline);
    else
        shader_pipeline_release(pipeline);
}

void shader_pipelines_remove(struct shader_pipelines *pipelines, VkPipeline handle)
{
    shader_pipelines_add(pipelines, handle, NULL);
}

struct shader_pipeline *shader_pipelines_find(struct shader_pipelines *pipelines, uint64_t handle)
{
    const unsigned stripe = reader_lock_enter(&pipelines->lock);
    struct shader_pipeline *pipeline = handle_table_find(&pipelines->pipelines, handle);
    if (pipeline)
        atomic_fetch_add(&pipeline->references, 1);
    reader_lock_leave(&pipelines->lock, stripe);
    return pipeline;
}

void shader_pipelines_end(struct shader_pipelines *pipelines)
{
    handle_table_drop(&pipelines->pipelines, release_pipeline);
    handle_table_drop(&pipelines->modules, release_code);
}
