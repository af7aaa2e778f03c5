/* SPDX-License-Identifier: Apache-2.0 */
/* Buffers for the layer's own builds and traces, and the pipelines that trace rays. */
#ifndef ASSAY_LAYER_COMPARE_PIPELINES_H
#define ASSAY_LAYER_COMPARE_PIPELINES_H

#include <stdbool.h>
#include <stdint.h>
#include <vulkan/utility/vk_dispatch_table.h>
#include <vulkan/vk_layer.h>
#include <vulkan/vulkan.h>

#include "layer/own_objects.h"
#include "src/platform/threads.h"

/* The properties of a device that comparing needs. */
struct compare_device {
    VkDevice handle;
    const VkuDeviceDispatchTable *vk;
    const VkPhysicalDeviceMemoryProperties *memory;
    uint32_t scratch_alignment;
    PFN_vkSetDeviceLoaderData set_loader_data; /* for command buffers; may be NULL */
    pthread_mutex_t *queue_lock;               /* held during submissions */
    /* If false, ray-tracing pipelines are used, whose tables need the sizes below. */
    bool has_queries;
    uint32_t group_handle_size, group_handle_alignment, group_base_alignment;
};

/* Creates a buffer with a device address. The caller calls compare_buffer_free(), also after a
 * failure. */
VkResult compare_buffer_create(const struct compare_device *device, VkBufferUsageFlags usage,
                               uint64_t size, bool is_mapped, struct own_buffer *buffer);
void compare_buffer_free(const struct compare_device *device, struct own_buffer *buffer);

/* A compute shader with ray queries, or a ray-tracing pipeline with its shader binding table. */
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
