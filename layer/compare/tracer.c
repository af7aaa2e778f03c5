/* SPDX-License-Identifier: Apache-2.0 */
/* The pipeline that traces rays, and the submissions of a job: the builds once, then the rays in
 * batches. */
#include "layer/compare/tracer.h"

#include <stdlib.h>
#include <string.h>

_Static_assert(sizeof(struct compare_ray) == 32 && sizeof(struct compare_hit) == 32 &&
                   sizeof(struct compare_answer) == 512,
               "as the shader has them");

enum { BATCH = 16384 /* rays per submission */ };

/* The queue may depend on an event that the application sets only after the call that waits here.
 */
#define WAIT_NANOSECONDS ((uint64_t)10 * 1000 * 1000 * 1000)

struct work;

/* What a job submits with, besides its structures and buffers. */
struct submitting {
    uint32_t queue_family;
    VkDescriptorPool descriptors;
    VkDescriptorSet set;
    VkCommandPool pool;
    VkCommandBuffer commands;
    VkFence fence;
};

/* The caller guards what changes. */
struct tracer {
    struct compare_device device;
    struct trace_pipeline pipeline;
    struct compare_buffers spare;
    struct submitting submitting; /* of the last job, for the next one; without a fence: none */
    struct work *unfinished;      /* work that the device may still use */
};

VkResult tracer_create(const struct compare_device *device, struct tracer **tracer)
{
    *tracer = calloc(1, sizeof(**tracer));
    if (!*tracer)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    (*tracer)->device = *device;
    (*tracer)->device.spare = &(*tracer)->spare;
    VkResult result = trace_pipeline_create(&(*tracer)->device, &(*tracer)->pipeline);
    if (result == VK_SUCCESS)
        return VK_SUCCESS;
    free(*tracer);
    *tracer = NULL;
    return result;
}

/* ---- a job */

struct work {
    struct work *next;
    struct tracer *tracer;
    const struct compare_device *device;
    const struct tracer_job *job; /* the caller's; NULL when tracer_run() has returned */
    /* One per input. The second input of an update has no structure of its own. */
    struct compare_structure *bottoms;
    uint32_t bottom_count;
    struct compare_structure top;
    struct own_buffer rays, answers; /* for one batch */
    struct submitting submitting;
};

static void destroy_submitting(const struct compare_device *device, struct submitting *submitting)
{
    if (submitting->fence)
        device->vk->DestroyFence(device->handle, submitting->fence, NULL);
    if (submitting->pool)
        device->vk->DestroyCommandPool(device->handle, submitting->pool, NULL);
    if (submitting->descriptors)
        device->vk->DestroyDescriptorPool(device->handle, submitting->descriptors, NULL);
    *submitting = (struct submitting){0};
}

/* `result` is that of the job: only after success the next one takes what this one submitted
 * with. */
static void free_work(struct work *work, VkResult result)
{
    const struct compare_device *device = work->device;
    struct submitting *kept = &work->tracer->submitting;
    if (result == VK_SUCCESS && !kept->fence)
        *kept = work->submitting;
    else
        destroy_submitting(device, &work->submitting);
    compare_structure_free(device, &work->top);
    for (uint32_t i = 0; i < work->bottom_count; i++)
        compare_structure_free(device, &work->bottoms[i]);
    free(work->bottoms);
    compare_buffer_free(device, &work->rays);
    compare_buffer_free(device, &work->answers);
    free(work);
}

static VkResult create_commands(struct work *work)
{
    const struct compare_device *device = work->device;
    struct submitting *submitting = &work->submitting;
    const VkCommandPoolCreateInfo pool_info = {
        .sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO,
        .flags =
            VK_COMMAND_POOL_CREATE_TRANSIENT_BIT | VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT,
        .queueFamilyIndex = submitting->queue_family,
    };
    const VkFenceCreateInfo fence_info = {.sType = VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
    VkResult result =
        device->vk->CreateCommandPool(device->handle, &pool_info, NULL, &submitting->pool);
    const VkCommandBufferAllocateInfo info = {
        .sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
        .commandPool = submitting->pool,
        .level = VK_COMMAND_BUFFER_LEVEL_PRIMARY,
        .commandBufferCount = 1,
    };
    if (result == VK_SUCCESS)
        result = device->vk->AllocateCommandBuffers(device->handle, &info, &submitting->commands);
    if (result == VK_SUCCESS && device->set_loader_data)
        result = device->set_loader_data(device->handle, submitting->commands);
    if (result == VK_SUCCESS)
        result = device->vk->CreateFence(device->handle, &fence_info, NULL, &submitting->fence);
    return result;
}

static VkResult create_set(struct work *work)
{
    const struct compare_device *device = work->device;
    struct submitting *submitting = &work->submitting;
    const VkDescriptorPoolSize size = {VK_DESCRIPTOR_TYPE_ACCELERATION_STRUCTURE_KHR, 1};
    const VkDescriptorPoolCreateInfo pool_info = {
        .sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO,
        .maxSets = 1,
        .poolSizeCount = 1,
        .pPoolSizes = &size,
    };
    VkResult result = device->vk->CreateDescriptorPool(device->handle, &pool_info, NULL,
                                                       &submitting->descriptors);
    const VkDescriptorSetAllocateInfo info = {
        .sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO,
        .descriptorPool = submitting->descriptors,
        .descriptorSetCount = 1,
        .pSetLayouts = &work->tracer->pipeline.set_layout,
    };
    if (result == VK_SUCCESS)
        result = device->vk->AllocateDescriptorSets(device->handle, &info, &submitting->set);
    return result;
}

static VkResult create_submitting(struct work *work)
{
    struct submitting *kept = &work->tracer->submitting;
    if (kept->fence && kept->queue_family == work->job->queue_family) {
        work->submitting = *kept;
        *kept = (struct submitting){0};
        return VK_SUCCESS;
    }
    destroy_submitting(work->device, kept);
    work->submitting.queue_family = work->job->queue_family;
    VkResult result = create_set(work);
    return result == VK_SUCCESS ? create_commands(work) : result;
}

static void write_set(const struct work *work)
{
    const VkWriteDescriptorSetAccelerationStructureKHR structures = {
        .sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET_ACCELERATION_STRUCTURE_KHR,
        .accelerationStructureCount = 1,
        .pAccelerationStructures = &work->top.handle,
    };
    const VkWriteDescriptorSet write = {
        .sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
        .pNext = &structures,
        .dstSet = work->submitting.set,
        .descriptorCount = 1,
        .descriptorType = VK_DESCRIPTOR_TYPE_ACCELERATION_STRUCTURE_KHR,
    };
    work->device->vk->UpdateDescriptorSets(work->device->handle, 1, &write, 0, NULL);
}

static VkResult create_bottoms(struct work *work)
{
    const struct tracer_job *job = work->job;
    VkResult result = VK_SUCCESS;
    work->bottoms = calloc(job->input_count + 1ull, sizeof(*work->bottoms));
    if (!work->bottoms)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    work->bottom_count = job->input_count;
    for (uint32_t i = 0; i < job->input_count && result == VK_SUCCESS; i++)
        result =
            compare_structure_create(work->device, &job->inputs[i],
                                     i && !job->top ? &work->bottoms[0] : NULL, &work->bottoms[i]);
    return result;
}

static uint64_t address_of(const struct work *work, uint32_t bottom)
{
    const VkAccelerationStructureDeviceAddressInfoKHR info = {
        .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_DEVICE_ADDRESS_INFO_KHR,
        .accelerationStructure = work->bottoms[bottom].handle,
    };
    return work->device->vk->GetAccelerationStructureDeviceAddressKHR(work->device->handle, &info);
}

static bool has_boxes(const struct compare_input *input)
{
    const struct build_parameters *build = input->parameters;
    return build->info.geometryCount > 0 && type_is_aabbs(build->geometries[0].geometryType);
}

/* Creates the TLAS of the job, or a TLAS of one instance for a BLAS. */
static VkResult create_top(struct work *work)
{
    static const VkAccelerationStructureInstanceKHR identity = {
        .transform.matrix = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}},
        .mask = 0xff,
        .accelerationStructureReference = 1,
    };
    static const struct compare_instances single = {.count = 1, .instances = &identity};
    const struct compare_instances *instances = work->job->top ? work->job->top : &single;
    VkResult result = compare_structure_create_top(work->device, instances, &work->top);
    for (uint32_t i = 0; i < instances->count && result == VK_SUCCESS; i++) {
        uint64_t number = instances->instances[i].accelerationStructureReference;
        uint32_t bottom = (uint32_t)number - 1;
        if (number)
            compare_structure_set_instance(&work->top, instances, i, address_of(work, bottom),
                                           has_boxes(&work->job->inputs[bottom]));
        else
            compare_structure_set_instance(&work->top, instances, i, 0, 0);
    }
    return result;
}

static VkResult create_work(struct work *work)
{
    const struct compare_device *device = work->device;
    const struct tracer_job *job = work->job;
    uint64_t batch = job->ray_count < BATCH ? job->ray_count : BATCH;
    VkResult result = create_bottoms(work);
    if (result == VK_SUCCESS)
        result = create_top(work);
    if (result == VK_SUCCESS)
        result =
            compare_buffer_create(device, batch * sizeof(struct compare_ray), true, &work->rays);
    if (result == VK_SUCCESS)
        result = compare_buffer_create(device, batch * sizeof(struct compare_answer), true,
                                       &work->answers);
    if (result == VK_SUCCESS)
        result = create_submitting(work);
    if (result == VK_SUCCESS)
        write_set(work);
    return result;
}

static void record_builds(const struct work *work)
{
    const struct tracer_job *job = work->job;
    for (uint32_t i = 0; i < job->input_count; i++)
        compare_structure_build(work->device, work->submitting.commands, &job->inputs[i],
                                i && !job->top ? &work->bottoms[0] : NULL, &work->bottoms[i]);
    compare_structure_build_top(work->device, work->submitting.commands, &work->top);
}

static void record_rays(const struct work *work, uint32_t count)
{
    const struct trace_constants constants = {work->rays.address, work->answers.address, count};
    const VkMemoryBarrier barrier = {.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER,
                                     .srcAccessMask = VK_ACCESS_SHADER_WRITE_BIT,
                                     .dstAccessMask = VK_ACCESS_HOST_READ_BIT};
    trace_pipeline_record(work->device, &work->tracer->pipeline, work->submitting.commands,
                          work->submitting.set, &constants);
    work->device->vk->CmdPipelineBarrier(
        work->submitting.commands, trace_pipeline_stage(work->device), VK_PIPELINE_STAGE_HOST_BIT,
        0, 1, &barrier, 0, NULL, 0, NULL);
}

/* Returns VK_TIMEOUT if the device may still execute the work. A lost device executes nothing; any
 * other error of the wait leaves that open. */
static VkResult wait_for(const struct work *work)
{
    const struct compare_device *device = work->device;
    VkResult result = device->vk->WaitForFences(device->handle, 1, &work->submitting.fence, VK_TRUE,
                                                WAIT_NANOSECONDS);
    return result == VK_SUCCESS || result == VK_ERROR_DEVICE_LOST ? result : VK_TIMEOUT;
}

static VkResult submit_work(const struct work *work)
{
    const struct compare_device *device = work->device;
    const VkSubmitInfo info = {
        .sType = VK_STRUCTURE_TYPE_SUBMIT_INFO,
        .commandBufferCount = 1,
        .pCommandBuffers = &work->submitting.commands,
    };
    if (!device->begin_submission(device->queues, work->job->queue))
        return VK_NOT_READY;
    VkResult result = device->vk->QueueSubmit(work->job->queue, 1, &info, work->submitting.fence);
    device->end_submission(device->queues);
    if (result == VK_SUCCESS)
        result = wait_for(work);
    if (result == VK_SUCCESS)
        result = device->vk->ResetFences(device->handle, 1, &work->submitting.fence);
    return result;
}

/* An any-hit shader may be called more than once for the same candidate. */
static void remove_duplicates(struct compare_answer *answer)
{
    uint32_t stored = answer->candidate_count, retained = 0;
    answer->flags = 0;
    if (stored > COMPARE_CANDIDATES)
        return;
    for (uint32_t i = 0; i < stored; i++) {
        const struct compare_hit *hit = &answer->candidates[i];
        uint32_t j = 0;
        while (j < retained && (answer->candidates[j].geometry != hit->geometry ||
                                answer->candidates[j].primitive != hit->primitive ||
                                answer->candidates[j].instance != hit->instance))
            j++;
        if (j == retained)
            answer->candidates[retained++] = *hit;
    }
    answer->candidate_count = retained;
}

static VkResult trace_batch(struct work *work, uint32_t first, uint32_t count)
{
    const VkuDeviceDispatchTable *vk = work->device->vk;
    const VkCommandBufferBeginInfo begin_info = {
        .sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO,
        .flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT,
    };
    memcpy(work->rays.bytes, work->job->rays + first, count * sizeof(struct compare_ray));
    VkResult result = vk->BeginCommandBuffer(work->submitting.commands, &begin_info);
    if (result != VK_SUCCESS)
        return result;
    if (first == 0)
        record_builds(work);
    record_rays(work, count);
    result = vk->EndCommandBuffer(work->submitting.commands);
    if (result == VK_SUCCESS)
        result = submit_work(work);
    if (result != VK_SUCCESS)
        return result;
    memcpy(work->job->answers + first, work->answers.bytes, count * sizeof(struct compare_answer));
    for (uint32_t i = 0; i < count; i++)
        remove_duplicates(&work->job->answers[first + i]);
    return VK_SUCCESS;
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
        work->job = NULL;
        work->next = tracer->unfinished;
        tracer->unfinished = work;
    } else {
        free_work(work, result);
    }
    if (result != VK_SUCCESS && result != VK_NOT_READY)
        compare_buffers_destroy(&tracer->device);
    return result;
}

/* Leaves the Vulkan objects to the device, which may still use them. */
static void leave_work(struct work *work)
{
    free(work->top.geometries);
    for (uint32_t i = 0; i < work->bottom_count; i++)
        free(work->bottoms[i].geometries);
    free(work->bottoms);
    free(work);
}

void tracer_destroy(struct tracer *tracer)
{
    bool is_in_use = false;
    if (!tracer)
        return;
    while (tracer->unfinished) {
        struct work *work = tracer->unfinished;
        tracer->unfinished = work->next;
        if (wait_for(work) == VK_TIMEOUT) {
            is_in_use = true;
            leave_work(work);
        } else {
            free_work(work, VK_TIMEOUT);
        }
    }
    destroy_submitting(&tracer->device, &tracer->submitting);
    compare_buffers_destroy(&tracer->device);
    if (!is_in_use)
        trace_pipeline_destroy(&tracer->device, &tracer->pipeline);
    free(tracer);
}
