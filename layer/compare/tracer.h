/* SPDX-License-Identifier: Apache-2.0 */
/* The driver's side of a comparison: its builds of the layer's own structures, and rays traced
 * through them. */
#ifndef ASSAY_LAYER_COMPARE_TRACER_H
#define ASSAY_LAYER_COMPARE_TRACER_H

#include <stdbool.h>
#include <stdint.h>
#include <vulkan/utility/vk_dispatch_table.h>
#include <vulkan/vk_layer.h>
#include <vulkan/vulkan.h>

#include "layer/own_objects.h"
#include "src/compare/input.h"
#include "src/compare/rays.h"
#include "src/platform/threads.h"

/* ---- buffers, and the pipelines that trace rays */

/* The properties of a device that comparing needs. */
struct compare_device {
    VkDevice handle;
    const VkuDeviceDispatchTable *vk;
    const VkPhysicalDeviceMemoryProperties *memory;
    uint32_t scratch_alignment;
    PFN_vkSetDeviceLoaderData set_loader_data; /* for command buffers; may be NULL */
    /* Whether the tracer may submit to the queue now. If so, it calls end_submission() next. */
    bool (*begin_submission)(void *queues, VkQueue queue);
    void (*end_submission)(void *queues);
    void *queues;
    /* If false, ray-tracing pipelines are used, whose tables need the sizes below. */
    bool has_queries;
    uint32_t group_handle_size, group_handle_alignment, group_base_alignment;
    struct compare_buffers *spare; /* the tracer's; NULL: buffers are freed at once */
};

/* Buffers that nothing uses now, the last freed at the end. New memory costs the host much more
 * than what the layer writes to it. */
enum { SPARE_BUFFERS = 16 };
#define SPARE_BYTES ((uint64_t)256 << 20)
struct compare_buffers {
    struct own_buffer of[SPARE_BUFFERS];
    uint32_t count;
};

/* Makes a buffer of at least this size with a device address, for rays, answers, inputs, scratch
 * memory and structures, or takes one that was freed. The caller calls compare_buffer_free(), also
 * after a failure. */
VkResult compare_buffer_create(const struct compare_device *device, uint64_t size, bool is_mapped,
                               struct own_buffer *buffer);
/* The device must not use the buffer any more. */
void compare_buffer_free(const struct compare_device *device, struct own_buffer *buffer);
void compare_buffers_destroy(const struct compare_device *device);

/* A compute shader with ray queries, or a ray-tracing pipeline with its shader binding table. */
struct trace_pipeline {
    VkDescriptorSetLayout set_layout; /* a TLAS at binding 0 */
    VkPipelineLayout layout;
    VkPipeline pipeline;
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

/* ---- acceleration structures of the layer that the driver builds */

struct compare_structure {
    struct own_buffer buffer, scratch, input;
    VkAccelerationStructureKHR handle;
    VkAccelerationStructureGeometryKHR *geometries; /* owned */
    VkBuildAccelerationStructureFlagsKHR flags;     /* flags and instance_count: for a TLAS */
    uint32_t instance_count;
};

/* Allocates the memory of a build and of its input, and fills the input. `target` is the structure
 * that an update writes, or NULL; an update allocates no structure. Frees nothing: the caller calls
 * compare_structure_free(), also after a failure. */
VkResult compare_structure_create(const struct compare_device *device,
                                  const struct compare_input *input,
                                  const struct compare_structure *target,
                                  struct compare_structure *structure);

/* The instances of a TLAS. Their references and shader binding table offsets are filled in
 * later. */
struct compare_instances {
    uint32_t count;
    const VkAccelerationStructureInstanceKHR *instances;
    bool array_of_pointers;
    VkBuildAccelerationStructureFlagsKHR flags;
    VkGeometryFlagsKHR geometry_flags;
};
/* As compare_structure_create(), for a TLAS. */
VkResult compare_structure_create_top(const struct compare_device *device,
                                      const struct compare_instances *instances,
                                      struct compare_structure *structure);
/* Writes one instance with its reference and its shader binding table offset. */
void compare_structure_set_instance(const struct compare_structure *structure,
                                    const struct compare_instances *instances, uint32_t instance,
                                    uint64_t reference, uint32_t record);
void compare_structure_free(const struct compare_device *device,
                            struct compare_structure *structure);

/* Record a build and a barrier after it. */
void compare_structure_build(const struct compare_device *device, VkCommandBuffer commands,
                             const struct compare_input *input,
                             const struct compare_structure *target,
                             const struct compare_structure *structure);
void compare_structure_build_top(const struct compare_device *device, VkCommandBuffer commands,
                                 const struct compare_structure *structure);

/* ---- a tracer builds an input with the driver, and traces rays through it */

/* Owns the pipeline that traces; one per device. Only one thread may use it at a time. */
struct tracer;
/* Creates the tracer; sets `*tracer` to NULL if it fails. */
VkResult tracer_create(const struct compare_device *device, struct tracer **tracer);
/* Waits up to 10 seconds for each submission whose end tracer_run() has not observed. If the device
 * may still use objects then, they stay until the device is destroyed. */
void tracer_destroy(struct tracer *tracer); /* `tracer` may be NULL */

/* A BLAS (`top` is NULL) is built from the first input and, if there is a second input, then
 * updated with that one. Rays are traced through a TLAS of one instance with the identity
 * transform. For a TLAS, each input is a BLAS, and the instances refer to the inputs by number from
 * 1 on. */
struct tracer_job {
    VkQueue queue;
    uint32_t queue_family;
    uint32_t input_count;
    const struct compare_input *inputs;
    const struct compare_instances *top;
    uint32_t ray_count;
    const struct compare_ray *rays;
    struct compare_answer *answers;
};

/* Submits to the queue and waits. Returns VK_NOT_READY if it may not submit now. Returns VK_TIMEOUT
 * if the end of a submission was not observed within 10 seconds. The tracer then keeps the objects
 * that the submission uses. */
VkResult tracer_run(struct tracer *tracer, const struct tracer_job *job);

#endif
