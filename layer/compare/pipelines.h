/* SPDX-License-Identifier: Apache-2.0 */
/* The two kinds of pipelines that trace rays: a compute shader with ray queries, or a ray-tracing
 * pipeline with its shader binding table. */
#ifndef ASSAY_LAYER_COMPARE_PIPELINES_H
#define ASSAY_LAYER_COMPARE_PIPELINES_H

#include "layer/compare/memory.h"

struct trace_pipeline {
    VkDescriptorSetLayout set_layout; /* a TLAS at binding 0 */
    VkPipelineLayout layout;
    VkPipeline pipeline;
    VkShaderStageFlags stages; /* stages of the push constants */
    /* Shader binding table of a ray-tracing pipeline; its regions follow. */
    struct own_buffer table;
    VkStridedDeviceAddressRegionKHR generation, miss, hit;
};

/* The push constants, in the layout of the shaders. */
struct trace_constants {
    uint64_t rays, answers;
    uint32_t count;
};

/* Creates the pipeline. Frees everything if it fails. */
VkResult trace_pipeline_create(const struct compare_device *device,
                               struct trace_pipeline *pipeline);
void trace_pipeline_destroy(const struct compare_device *device, struct trace_pipeline *pipeline);

/* Records the trace commands without barriers. */
void trace_pipeline_record(const struct compare_device *device,
                           const struct trace_pipeline *pipeline, VkCommandBuffer commands,
                           VkDescriptorSet set, const struct trace_constants *constants);

/* Returns the pipeline stage that traces. */
static inline VkPipelineStageFlags trace_pipeline_stage(const struct compare_device *device)
{
    return device->has_queries ? VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT
                               : VK_PIPELINE_STAGE_RAY_TRACING_SHADER_BIT_KHR;
}

#endif
