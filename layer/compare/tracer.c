/* SPDX-License-Identifier: Apache-2.0 */
/* The pipeline that traces rays, and what is submitted for a job: builds once, then rays by the
 * batch. */
#include "compare/tracer.h"

#include <stdlib.h>
#include <string.h>

#include "compare/structures.h"

static const uint32_t code[] = {
#include "compare_comp.h"
};

/* As the shader has them. */
struct constants {
    uint64_t rays, answers;
    uint32_t count;
};
_Static_assert(sizeof(struct compare_ray) == 32 && sizeof(struct compare_hit) == 32 &&
                   sizeof(struct compare_answer) == 512,
               "as the shader has them");

enum { GROUP = 64, BATCH = 16384 /* rays of a submission */ };

/* The queue may wait for what the application does only after the call that waits for it. */
#define WAIT_NANOSECONDS ((uint64_t)10 * 1000 * 1000 * 1000)

struct work;

struct tracer {
    struct compare_device device;
    VkDescriptorSetLayout set_layout;
    VkPipelineLayout layout;
    VkPipeline pipeline;
    struct work *late; /* that the device may still use; guarded by the caller */
};

/* ---- the pipeline */

static VkResult create_layouts(struct tracer *tracer)
{
    const VkuDeviceDispatchTable *vk = tracer->device.vk;
    const VkDescriptorSetLayoutBinding binding = {
        .descriptorType = VK_DESCRIPTOR_TYPE_ACCELERATION_STRUCTURE_KHR,
        .descriptorCount = 1,
        .stageFlags = VK_SHADER_STAGE_COMPUTE_BIT,
    };
    const VkDescriptorSetLayoutCreateInfo set_info = {
        .sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO,
        .bindingCount = 1,
        .pBindings = &binding,
    };
    const VkPushConstantRange range = {.stageFlags = VK_SHADER_STAGE_COMPUTE_BIT,
                                       .size = sizeof(struct constants)};
    const VkPipelineLayoutCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO,
        .setLayoutCount = 1,
        .pSetLayouts = &tracer->set_layout,
        .pushConstantRangeCount = 1,
        .pPushConstantRanges = &range,
    };
    VkResult result =
        vk->CreateDescriptorSetLayout(tracer->device.handle, &set_info, NULL, &tracer->set_layout);
    if (result == VK_SUCCESS)
        result = vk->CreatePipelineLayout(tracer->device.handle, &info, NULL, &tracer->layout);
    return result;
}

static VkResult create_pipeline(struct tracer *tracer)
{
    const VkuDeviceDispatchTable *vk = tracer->device.vk;
    const VkShaderModuleCreateInfo module_info = {
        .sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO,
        .codeSize = sizeof(code),
        .pCode = code,
    };
    VkShaderModule module;
    VkResult result = vk->CreateShaderModule(tracer->device.handle, &module_info, NULL, &module);
    if (result != VK_SUCCESS)
        return result;
    const VkComputePipelineCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO,
        .stage = {.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
                  .stage = VK_SHADER_STAGE_COMPUTE_BIT,
                  .module = module,
                  .pName = "main"},
        .layout = tracer->layout,
    };
    result = vk->CreateComputePipelines(tracer->device.handle, VK_NULL_HANDLE, 1, &info, NULL,
                                        &tracer->pipeline);
    vk->DestroyShaderModule(tracer->device.handle, module, NULL);
    return result;
}

VkResult tracer_create(const struct compare_device *device, struct tracer **out)
{
    struct tracer *tracer = calloc(1, sizeof(*tracer));
    if (!tracer)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    tracer->device = *device;
    VkResult result = create_layouts(tracer);
    if (result == VK_SUCCESS)
        result = create_pipeline(tracer);
    if (result == VK_SUCCESS)
        *out = tracer;
    else
        tracer_destroy(tracer);
    return result;
}

/* ---- a job */

struct work {
    struct work *next;
    const struct tracer *tracer;
    const struct compare_device *device;
    const struct tracer_job *job;
    struct compare_structure bottom, update, top;
    struct compare_buffer rays, answers; /* of a batch */
    VkDescriptorPool descriptors;
    VkDescriptorSet set;
    VkCommandPool pool;
    VkCommandBuffer commands;
    VkFence fence;
};

static void free_work(struct work *work)
{
    const struct compare_device *device = work->device;
    if (work->fence)
        device->vk->DestroyFence(device->handle, work->fence, NULL);
    if (work->pool)
        device->vk->DestroyCommandPool(device->handle, work->pool, NULL);
    if (work->descriptors)
        device->vk->DestroyDescriptorPool(device->handle, work->descriptors, NULL);
    compare_structure_free(device, &work->top);
    compare_structure_free(device, &work->update);
    compare_structure_free(device, &work->bottom);
    compare_buffer_free(device, &work->rays);
    compare_buffer_free(device, &work->answers);
    free(work);
}

static VkResult create_commands(struct work *work)
{
    const struct compare_device *device = work->device;
    const VkCommandPoolCreateInfo pool_info = {
        .sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO,
        .flags =
            VK_COMMAND_POOL_CREATE_TRANSIENT_BIT | VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT,
        .queueFamilyIndex = work->job->queue_family,
    };
    const VkFenceCreateInfo fence_info = {.sType = VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
    VkResult result = device->vk->CreateCommandPool(device->handle, &pool_info, NULL, &work->pool);
    const VkCommandBufferAllocateInfo info = {
        .sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
        .commandPool = work->pool,
        .level = VK_COMMAND_BUFFER_LEVEL_PRIMARY,
        .commandBufferCount = 1,
    };
    if (result == VK_SUCCESS)
        result = device->vk->AllocateCommandBuffers(device->handle, &info, &work->commands);
    if (result == VK_SUCCESS && device->set_loader_data)
        result = device->set_loader_data(device->handle, work->commands);
    if (result == VK_SUCCESS)
        result = device->vk->CreateFence(device->handle, &fence_info, NULL, &work->fence);
    return result;
}

static VkResult create_set(struct work *work)
{
    const struct compare_device *device = work->device;
    const VkDescriptorPoolSize size = {VK_DESCRIPTOR_TYPE_ACCELERATION_STRUCTURE_KHR, 1};
    const VkDescriptorPoolCreateInfo pool_info = {
        .sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO,
        .maxSets = 1,
        .poolSizeCount = 1,
        .pPoolSizes = &size,
    };
    VkResult result =
        device->vk->CreateDescriptorPool(device->handle, &pool_info, NULL, &work->descriptors);
    const VkDescriptorSetAllocateInfo info = {
        .sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO,
        .descriptorPool = work->descriptors,
        .descriptorSetCount = 1,
        .pSetLayouts = &work->tracer->set_layout,
    };
    if (result == VK_SUCCESS)
        result = device->vk->AllocateDescriptorSets(device->handle, &info, &work->set);
    if (result != VK_SUCCESS)
        return result;
    const VkWriteDescriptorSetAccelerationStructureKHR structures = {
        .sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET_ACCELERATION_STRUCTURE_KHR,
        .accelerationStructureCount = 1,
        .pAccelerationStructures = &work->top.handle,
    };
    const VkWriteDescriptorSet write = {
        .sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
        .pNext = &structures,
        .dstSet = work->set,
        .descriptorCount = 1,
        .descriptorType = VK_DESCRIPTOR_TYPE_ACCELERATION_STRUCTURE_KHR,
    };
    device->vk->UpdateDescriptorSets(device->handle, 1, &write, 0, NULL);
    return VK_SUCCESS;
}

static VkResult create_work(struct work *work)
{
    const struct compare_device *device = work->device;
    const struct tracer_job *job = work->job;
    uint64_t batch = job->ray_count < BATCH ? job->ray_count : BATCH;
    VkResult result = compare_structure_create(device, &job->inputs[0], NULL, &work->bottom);
    if (result == VK_SUCCESS && job->input_count > 1)
        result = compare_structure_create(device, &job->inputs[1], &work->bottom, &work->update);
    if (result == VK_SUCCESS)
        result = compare_structure_create_top(device, &work->bottom, &work->top);
    if (result == VK_SUCCESS)
        result = compare_buffer_create(device, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT,
                                       batch * sizeof(struct compare_ray), true, &work->rays);
    if (result == VK_SUCCESS)
        result = compare_buffer_create(device, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT,
                                       batch * sizeof(struct compare_answer), true, &work->answers);
    if (result == VK_SUCCESS)
        result = create_set(work);
    if (result == VK_SUCCESS)
        result = create_commands(work);
    return result;
}

static void record_builds(const struct work *work)
{
    const struct tracer_job *job = work->job;
    compare_structure_build(work->device, work->commands, &job->inputs[0], NULL, &work->bottom);
    if (job->input_count > 1)
        compare_structure_build(work->device, work->commands, &job->inputs[1], &work->bottom,
                                &work->update);
    compare_structure_build_top(work->device, work->commands, &work->top);
}

static void record_rays(const struct work *work, uint32_t count)
{
    const VkuDeviceDispatchTable *vk = work->device->vk;
    const struct constants constants = {work->rays.address, work->answers.address, count};
    const VkMemoryBarrier barrier = {.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER,
                                     .srcAccessMask = VK_ACCESS_SHADER_WRITE_BIT,
                                     .dstAccessMask = VK_ACCESS_HOST_READ_BIT};
    vk->CmdBindPipeline(work->commands, VK_PIPELINE_BIND_POINT_COMPUTE, work->tracer->pipeline);
    vk->CmdBindDescriptorSets(work->commands, VK_PIPELINE_BIND_POINT_COMPUTE, work->tracer->layout,
                              0, 1, &work->set, 0, NULL);
    vk->CmdPushConstants(work->commands, work->tracer->layout, VK_SHADER_STAGE_COMPUTE_BIT, 0,
                         sizeof(constants), &constants);
    vk->CmdDispatch(work->commands, (count + GROUP - 1) / GROUP, 1, 1);
    vk->CmdPipelineBarrier(work->commands, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT,
                           VK_PIPELINE_STAGE_HOST_BIT, 0, 1, &barrier, 0, NULL, 0, NULL);
}

static VkResult submit(const struct work *work)
{
    const struct compare_device *device = work->device;
    const VkSubmitInfo info = {
        .sType = VK_STRUCTURE_TYPE_SUBMIT_INFO,
        .commandBufferCount = 1,
        .pCommandBuffers = &work->commands,
    };
    pthread_mutex_lock(device->queue_lock);
    VkResult result = device->vk->QueueSubmit(work->job->queue, 1, &info, work->fence);
    pthread_mutex_unlock(device->queue_lock);
    if (result == VK_SUCCESS)
        result =
            device->vk->WaitForFences(device->handle, 1, &work->fence, VK_TRUE, WAIT_NANOSECONDS);
    if (result == VK_SUCCESS)
        result = device->vk->ResetFences(device->handle, 1, &work->fence);
    return result;
}

static VkResult trace_batch(struct work *work, uint32_t first, uint32_t count)
{
    const VkuDeviceDispatchTable *vk = work->device->vk;
    const VkCommandBufferBeginInfo begin_info = {
        .sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO,
        .flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT,
    };
    memcpy(work->rays.bytes, work->job->rays + first, count * sizeof(struct compare_ray));
    VkResult result = vk->BeginCommandBuffer(work->commands, &begin_info);
    if (result != VK_SUCCESS)
        return result;
    if (first == 0)
        record_builds(work);
    record_rays(work, count);
    result = vk->EndCommandBuffer(work->commands);
    if (result == VK_SUCCESS)
        result = submit(work);
    if (result == VK_SUCCESS)
        memcpy(work->job->answers + first, work->answers.bytes,
               count * sizeof(struct compare_answer));
    return result;
}

VkResult tracer_run(struct tracer *tracer, const struct tracer_job *job)
{
    struct work *work = calloc(1, sizeof(*work));
    if (!work)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    work->tracer = tracer;
    work->device = &tracer->device;
    work->job = job;
    VkResult result = create_work(work);
    for (uint32_t first = 0; first < job->ray_count && result == VK_SUCCESS; first += BATCH) {
        uint32_t left = job->ray_count - first;
        result = trace_batch(work, first, left < BATCH ? left : BATCH);
    }
    if (result == VK_TIMEOUT) {
        work->next = tracer->late;
        tracer->late = work;
    } else {
        free_work(work);
    }
    return result;
}

void tracer_destroy(struct tracer *tracer)
{
    if (!tracer)
        return;
    const VkuDeviceDispatchTable *vk = tracer->device.vk;
    while (tracer->late) {
        struct work *late = tracer->late;
        tracer->late = late->next;
        vk->WaitForFences(tracer->device.handle, 1, &late->fence, VK_TRUE, WAIT_NANOSECONDS);
        free_work(late);
    }
    if (tracer->pipeline)
        vk->DestroyPipeline(tracer->device.handle, tracer->pipeline, NULL);
    if (tracer->layout)
        vk->DestroyPipelineLayout(tracer->device.handle, tracer->layout, NULL);
    if (tracer->set_layout)
        vk->DestroyDescriptorSetLayout(tracer->device.handle, tracer->set_layout, NULL);
    free(tracer);
}
