/* SPDX-License-Identifier: Apache-2.0 */
/* The two ways to trace rays on a device: a compute shader with ray queries, or a ray-tracing
 * pipeline and its table. */
#ifndef ASSAY_LAYER_COMPARE_PIPELINES_H
#define ASSAY_LAYER_COMPARE_PIPELINES_H

#include "layer/compare/memory.h"

struct trace_pipeline {
    VkDescriptorSetLayout set_layout; /* of a TLAS at binding 0 */
    VkPipelineLayout layout;
    VkPipeline pipeline;
    VkShaderStageFlags stages; /* that constants are pushed for */
    struct own_buffer table;   /* of a ray-tracing pipeline, and where its parts are: */
    VkStridedDeviceAddressRegionKHR generation, miss, hit;
};

/* As the shaders have them. */
struct trace_constants {
    uint64_t rays, answers;
    uint32_t count;
};

/* Frees what it made where it fails. */
VkResult trace_pipeline_create(const struct compare_device *device,
                               struct trace_pipeline *pipeline);
void trace_pipeline_destroy(const struct compare_device *device, struct trace_pipeline *pipeline);

/* Records the tracing, with nothing around it. */
void trace_pipeline_record(const struct compare_device *device,
                           const struct trace_pipeline *pipeline, VkCommandBuffer commands,
                           VkDescriptorSet set, const struct trace_constants *constants);

/* Where it happens. */
static inline VkPipelineStageFlags trace_pipeline_stage(const struct compare_device *device)
{
    return device->has_queries ? VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT
                               : VK_PIPELINE_STAGE_RAY_TRACING_SHADER_BIT_KHR;
}

#endif
