/* SPDX-License-Identifier: Apache-2.0 */
/* What is known of shader modules and pipelines. */
#ifndef ASSAY_LAYER_HAZARDS_PIPELINES_H
#define ASSAY_LAYER_HAZARDS_PIPELINES_H

#include <stdatomic.h>

#include "src/base/handle_table.h"
#include "src/base/reader_lock.h"
#include "src/shaders/facts.h"
#include "src/shaders/paths.h"

struct shader_pipeline;

/* All-zero: no object is known. Has a lock of its own. */
struct shader_pipelines {
    struct reader_lock lock;
    struct handle_table modules, pipelines;
};

void shader_pipelines_end(struct shader_pipelines *pipelines);

/* Copies the code. */
void shader_pipelines_note_module(struct shader_pipelines *pipelines, VkShaderModule module,
                                  const VkShaderModuleCreateInfo *info);
void shader_pipelines_forget_module(struct shader_pipelines *pipelines, VkShaderModule module);

/* Reads what the shaders of a pipeline can do. `is_whole`: the pipeline has no other shaders.
 * `stages` may be no pointer. */
struct shader_pipeline *shader_pipeline_read(struct shader_pipelines *pipelines, uint32_t count,
                                             const VkPipelineShaderStageCreateInfo *stages,
                                             bool is_whole);
const struct shader_facts *shader_pipeline_facts(const struct shader_pipeline *pipeline);

/* Takes over the reference to the pipeline, which may be NULL. */
void shader_pipelines_add(struct shader_pipelines *pipelines, VkPipeline handle,
                          struct shader_pipeline *pipeline);
void shader_pipelines_remove(struct shader_pipelines *pipelines, VkPipeline handle);
/* Returns a reference; NULL: the pipeline is unknown. */
struct shader_pipeline *shader_pipelines_find(struct shader_pipelines *pipelines, uint64_t handle);
/* Accepts NULL. */
void shader_pipeline_release(struct shader_pipeline *pipeline);

/* Whether a dispatch, or trace, with the pipeline certainly traces rays: by the shader of a compute
 * pipeline, by each ray generation shader of a ray tracing pipeline. Sets launch->constants. */
bool shader_pipeline_traces(const struct shader_pipeline *pipeline, struct shader_launch *launch,
                            struct traced_descriptor *traced);

#endif
