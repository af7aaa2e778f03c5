/* SPDX-License-Identifier: Apache-2.0 */
/* Draws the scene with ray queries in a compute shader. */
#include <string.h>

#include "scene.h"
#include "scene_comp.h" /* generated from scene.comp */

#define BINDING_COUNT 5 /* the TLAS, then buffers */
#define GROUP_SIZE 8

/* As in scene.comp. */
struct push {
    uint32_t width;
    uint32_t height;
    uint32_t vertex_count;
    uint32_t grid;
};

struct render {
    VkDescriptorSetLayout set_layout;
    VkPipelineLayout layout;
    VkPipeline pipeline;
    VkDescriptorPool pool;
    VkDescriptorSet set;
    struct gpu_buffer pixels;
};

static VkDescriptorType render_binding_type(uint32_t binding)
{
    return binding == 0 ? VK_DESCRIPTOR_TYPE_ACCELERATION_STRUCTURE_KHR
                        : VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
}

static void render_create_layouts(struct render *render, struct gpu *gpu)
{
    VkDescriptorSetLayoutBinding bindings[BINDING_COUNT];
    for (uint32_t i = 0; i < BINDING_COUNT; ++i)
        bindings[i] = (VkDescriptorSetLayoutBinding){.binding = i,
                                                     .descriptorType = render_binding_type(i),
                                                     .descriptorCount = 1,
                                                     .stageFlags = VK_SHADER_STAGE_COMPUTE_BIT};
    TOOL_CALL(gpu->calls, CreateDescriptorSetLayout, gpu->device,
              &MAKE(VkDescriptorSetLayoutCreateInfo, .bindingCount = BINDING_COUNT,
                    .pBindings = bindings),
              NULL, &render->set_layout);
    TOOL_CALL(gpu->calls, CreatePipelineLayout, gpu->device,
              &MAKE(VkPipelineLayoutCreateInfo, .setLayoutCount = 1,
                    .pSetLayouts = &render->set_layout, .pushConstantRangeCount = 1,
                    .pPushConstantRanges =
                        &(VkPushConstantRange){.stageFlags = VK_SHADER_STAGE_COMPUTE_BIT,
                                               .size = sizeof(struct push)}),
              NULL, &render->layout);
}

static void render_create_pipeline(struct render *render, struct gpu *gpu)
{
    VkShaderModule module;
    TOOL_CALL(gpu->calls, CreateShaderModule, gpu->device,
              &MAKE(VkShaderModuleCreateInfo, .codeSize = sizeof(scene_comp), .pCode = scene_comp),
              NULL, &module);
    TOOL_CALL(
        gpu->calls, CreateComputePipelines, gpu->device, VK_NULL_HANDLE, 1,
        &MAKE(VkComputePipelineCreateInfo,
              .stage = MAKE(VkPipelineShaderStageCreateInfo, .stage = VK_SHADER_STAGE_COMPUTE_BIT,
                            .module = module, .pName = "main"),
              .layout = render->layout),
        NULL, &render->pipeline);
    gpu->calls.DestroyShaderModule(gpu->device, module, NULL);
}

static void render_create_set(struct render *render, struct gpu *gpu)
{
    const VkDescriptorPoolSize sizes[] = {{VK_DESCRIPTOR_TYPE_ACCELERATION_STRUCTURE_KHR, 1},
                                          {VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, BINDING_COUNT - 1}};
    TOOL_CALL(gpu->calls, CreateDescriptorPool, gpu->device,
              &MAKE(VkDescriptorPoolCreateInfo, .maxSets = 1,
                    .poolSizeCount = sizeof(sizes) / sizeof(*sizes), .pPoolSizes = sizes),
              NULL, &render->pool);
    TOOL_CALL(gpu->calls, AllocateDescriptorSets, gpu->device,
              &MAKE(VkDescriptorSetAllocateInfo, .descriptorPool = render->pool,
                    .descriptorSetCount = 1, .pSetLayouts = &render->set_layout),
              &render->set);
}

static void render_write_set(struct render *render, struct gpu *gpu, const struct scene *scene)
{
    const STRUCT(VkWriteDescriptorSetAccelerationStructureKHR, top, .accelerationStructureCount = 1,
                 .pAccelerationStructures = &scene->top.structure.handle);
    const VkDescriptorBufferInfo buffers[BINDING_COUNT] = {
        [1] = {render->pixels.handle, 0, VK_WHOLE_SIZE},
        [2] = {scene->indices.handle, 0, VK_WHOLE_SIZE},
        [3] = {scene->normals.handle, 0, VK_WHOLE_SIZE},
        [4] = {scene->boxes.handle, 0, VK_WHOLE_SIZE},
    };
    VkWriteDescriptorSet writes[BINDING_COUNT];
    for (uint32_t i = 0; i < BINDING_COUNT; ++i)
        writes[i] = MAKE(VkWriteDescriptorSet, .pNext = i == 0 ? &top : NULL, .dstSet = render->set,
                         .dstBinding = i, .descriptorCount = 1,
                         .descriptorType = render_binding_type(i), .pBufferInfo = &buffers[i]);
    gpu->calls.UpdateDescriptorSets(gpu->device, BINDING_COUNT, writes, 0, NULL);
}

static void render_dispatch(struct render *render, struct gpu *gpu, const struct push *push)
{
    VkCommandBuffer commands = gpu_begin(gpu);
    gpu->calls.CmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, render->pipeline);
    gpu->calls.CmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, render->layout, 0, 1,
                                     &render->set, 0, NULL);
    gpu->calls.CmdPushConstants(commands, render->layout, VK_SHADER_STAGE_COMPUTE_BIT, 0,
                                sizeof(*push), push);
    gpu->calls.CmdDispatch(commands, (push->width + GROUP_SIZE - 1) / GROUP_SIZE,
                           (push->height + GROUP_SIZE - 1) / GROUP_SIZE, 1);
    gpu_barrier(gpu, commands, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT, VK_ACCESS_SHADER_WRITE_BIT,
                VK_PIPELINE_STAGE_HOST_BIT, VK_ACCESS_HOST_READ_BIT);
    gpu_submit(gpu, commands);
}

void render_scene(struct gpu *gpu, const struct scene *scene, uint32_t width, uint32_t height,
                  uint32_t *pixels)
{
    struct render render = {0};
    const VkDeviceSize size = (VkDeviceSize)width * height * sizeof(*pixels);
    render.pixels =
        gpu_create_buffer(gpu, "pixels", GPU_PLACE_HOST, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, size);
    render_create_layouts(&render, gpu);
    render_create_pipeline(&render, gpu);
    render_create_set(&render, gpu);
    render_write_set(&render, gpu, scene);
    render_dispatch(&render, gpu,
                    &(struct push){.width = width,
                                   .height = height,
                                   .vertex_count = scene->vertex_count,
                                   .grid = RENDER_GRID});
    memcpy(pixels, render.pixels.data, size);

    gpu->calls.DestroyDescriptorPool(gpu->device, render.pool, NULL);
    gpu->calls.DestroyPipeline(gpu->device, render.pipeline, NULL);
    gpu->calls.DestroyPipelineLayout(gpu->device, render.layout, NULL);
    gpu->calls.DestroyDescriptorSetLayout(gpu->device, render.set_layout, NULL);
    gpu_destroy_buffer(gpu, &render.pixels);
}
