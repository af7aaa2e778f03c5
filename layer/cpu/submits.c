/* SPDX-License-Identifier: Apache-2.0 */
/* Commands of backend cpu: submissions. Each that has such recordings is followed by a fence of the
 * backend's own, which tells when its snapshots can be read; the application's fence comes after
 * it, so that whoever sees that one signalled finds the other so. */
#include <stdlib.h>

#include "cpu/commands.h"
#include "cpu/submit_infos.h"
#include "cpu/submits.h"
#include "snapshots/recorder.h"

/* ---- tickets */

struct fence_ticket {
    struct ticket ticket; /* first */
    const struct layer_device *device;
    VkFence fence;
    VkQueue queue;
    bool is_submitted;         /* the fence is, or was */
    struct fence_ticket *next; /* of the overlay's unfinished ones */
};

static VkResult wait_for_fence(struct ticket *ticket, uint64_t nanoseconds)
{
    const struct fence_ticket *own = (const struct fence_ticket *)ticket;
    return own->device->cpu->next.WaitForFences(own->device->handle, 1, &own->fence, VK_TRUE,
                                                nanoseconds);
}

static void destroy_ticket(struct fence_ticket *own)
{
    own->device->cpu->next.DestroyFence(own->device->handle, own->fence, NULL);
    free(own);
}

/* The fence may not be destroyed while the device uses it. */
static bool is_finished(const struct fence_ticket *own)
{
    return !own->is_submitted ||
           own->device->cpu->next.GetFenceStatus(own->device->handle, own->fence) != VK_NOT_READY;
}

static void keep_unfinished(struct cpu_overlay *overlay, struct fence_ticket *own)
{
    pthread_mutex_lock(&overlay->tickets_lock);
    own->next = overlay->unfinished;
    overlay->unfinished = own;
    pthread_mutex_unlock(&overlay->tickets_lock);
}

static void free_ticket(struct ticket *ticket)
{
    struct fence_ticket *own = (struct fence_ticket *)ticket;
    if (is_finished(own))
        destroy_ticket(own);
    else
        keep_unfinished(own->device->cpu, own);
}

void cpu_tickets_release(struct cpu_overlay *overlay, bool all)
{
    pthread_mutex_lock(&overlay->tickets_lock);
    struct fence_ticket *own = overlay->unfinished, *next;
    overlay->unfinished = NULL;
    pthread_mutex_unlock(&overlay->tickets_lock);
    for (; own; own = next) {
        next = own->next;
        if (all || is_finished(own))
            destroy_ticket(own);
        else
            keep_unfinished(overlay, own);
    }
}

VkQueue cpu_ticket_queue(const struct ticket *ticket)
{
    return ((const struct fence_ticket *)ticket)->queue;
}

static struct ticket *create_ticket(const struct layer_device *device, VkQueue queue)
{
    const VkFenceCreateInfo create_info = {.sType = VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
    cpu_tickets_release(device->cpu, false);
    struct fence_ticket *own = calloc(1, sizeof(*own));
    if (!own)
        return NULL;
    atomic_init(&own->ticket.references, 1);
    own->ticket.wait = wait_for_fence;
    own->ticket.free = free_ticket;
    own->device = device;
    own->queue = queue;
    if (device->cpu->next.CreateFence(device->handle, &create_info, NULL, &own->fence) ==
        VK_SUCCESS)
        return &own->ticket;
    free(own);
    return NULL;
}

/* ---- what a submission has to do with the backend */

struct submit {
    struct layer_device *device;
    VkQueue queue;
    struct ticket *ticket;
    struct execution **executions;
    uint32_t count, capacity;
    VkResult result; /* of what was done so far */
};

static bool reserve(struct submit *submit)
{
    if (submit->count < submit->capacity)
        return true;
    uint32_t capacity = submit->capacity ? submit->capacity * 2 : 8;
    struct execution **grown = realloc(submit->executions, capacity * sizeof(struct execution *));
    if (!grown)
        return false;
    submit->executions = grown;
    submit->capacity = capacity;
    return true;
}

static bool add_execution(struct submit *submit, struct recording *recording)
{
    if (!submit->ticket)
        submit->ticket = create_ticket(submit->device, submit->queue);
    if (!submit->ticket || !reserve(submit))
        return false;
    recording_detach(recording, submit->ticket);
    struct execution *execution = execution_create(recording, submit->ticket);
    if (execution)
        submit->executions[submit->count++] = execution;
    return execution;
}

static void add_command_buffer(struct submit *submit, VkCommandBuffer handle)
{
    struct recording *recording = recording_of(submit->device, handle);
    if (recording && recording->first && submit->result == VK_SUCCESS &&
        !add_execution(submit, recording))
        submit->result = VK_ERROR_OUT_OF_HOST_MEMORY;
}

static void release(struct submit *submit)
{
    ticket_release(submit->ticket);
    free(submit->executions);
}

/* Nothing was submitted. */
static VkResult give_up(struct submit *submit, VkResult result)
{
    for (uint32_t i = 0; i < submit->count; i++)
        execution_release(submit->executions[i]);
    release(submit);
    return result;
}

/* The fences, after the application's batches. Where they can't be submitted, nobody will learn of
 * the end of those: the device is as good as lost. */
static VkResult submit_fences(const struct submit *submit, VkFence fence)
{
    const VkuDeviceDispatchTable *next = &submit->device->cpu->next;
    struct fence_ticket *own = (struct fence_ticket *)submit->ticket;
    VkResult result = next->QueueSubmit(submit->queue, 0, NULL, own->fence);
    own->is_submitted = result == VK_SUCCESS;
    if (result == VK_SUCCESS && fence)
        result = next->QueueSubmit(submit->queue, 0, NULL, fence);
    return result == VK_SUCCESS ? VK_SUCCESS : VK_ERROR_DEVICE_LOST;
}

/* `result` is that of the application's batches. */
static VkResult finish(struct submit *submit, VkFence fence, VkResult result)
{
    const struct cpu_overlay *overlay = submit->device->cpu;
    if (!submit->count)
        return result;
    if (result == VK_SUCCESS)
        result = submit_fences(submit, fence);
    if (result != VK_SUCCESS)
        return give_up(submit, result);
    for (uint32_t i = 0; i < submit->count; i++)
        cpu_playback_expect(overlay->playback, submit->executions[i]);
    release(submit);
    if (atomic_load(&overlay->order_lost))
        cpu_playback_run_all(overlay->playback);
    return VK_SUCCESS;
}

VKAPI_ATTR VkResult VKAPI_CALL cpu_QueueSubmit(VkQueue queue, uint32_t submitCount,
                                               const VkSubmitInfo *pSubmits, VkFence fence)
{
    struct submit submit = {.device = layer_find_device(queue), .queue = queue};
    struct cpu_overlay *overlay = submit.device->cpu;
    cpu_deliver(submit.device);
    for (uint32_t i = 0; i < submitCount; i++)
        for (uint32_t j = 0; j < pSubmits[i].commandBufferCount; j++)
            add_command_buffer(&submit, pSubmits[i].pCommandBuffers[j]);
    if (submit.result != VK_SUCCESS)
        return give_up(&submit, submit.result);
    pthread_mutex_lock(&overlay->queue_lock);
    VkResult result = cpu_submit_below(overlay->next.QueueSubmit, queue, submitCount, pSubmits,
                                       submit.count ? VK_NULL_HANDLE : fence);
    result = finish(&submit, fence, result);
    pthread_mutex_unlock(&overlay->queue_lock);
    return result;
}

static VkResult submit2(PFN_vkQueueSubmit2 next, VkQueue queue, uint32_t count,
                        const VkSubmitInfo2 *infos, VkFence fence)
{
    struct submit submit = {.device = layer_find_device(queue), .queue = queue};
    struct cpu_overlay *overlay = submit.device->cpu;
    cpu_deliver(submit.device);
    for (uint32_t i = 0; i < count; i++)
        for (uint32_t j = 0; j < infos[i].commandBufferInfoCount; j++)
            add_command_buffer(&submit, infos[i].pCommandBufferInfos[j].commandBuffer);
    if (submit.result != VK_SUCCESS)
        return give_up(&submit, submit.result);
    pthread_mutex_lock(&overlay->queue_lock);
    VkResult result =
        cpu_submit2_below(next, queue, count, infos, submit.count ? VK_NULL_HANDLE : fence);
    result = finish(&submit, fence, result);
    pthread_mutex_unlock(&overlay->queue_lock);
    return result;
}

VKAPI_ATTR VkResult VKAPI_CALL cpu_QueueSubmit2(VkQueue queue, uint32_t submitCount,
                                                const VkSubmitInfo2 *pSubmits, VkFence fence)
{
    return submit2(cpu_overlay_of(queue)->next.QueueSubmit2, queue, submitCount, pSubmits, fence);
}

VKAPI_ATTR VkResult VKAPI_CALL cpu_QueueSubmit2KHR(VkQueue queue, uint32_t submitCount,
                                                   const VkSubmitInfo2 *pSubmits, VkFence fence)
{
    return submit2(cpu_overlay_of(queue)->next.QueueSubmit2KHR, queue, submitCount, pSubmits,
                   fence);
}

/* ---- other uses of queues, which the backend uses itself */

static void note_family(struct cpu_overlay *overlay, VkQueue queue, uint32_t family)
{
    uintptr_t name = (uintptr_t)family + 1;
    pthread_mutex_lock(&overlay->queue_lock);
    handle_table_set(&overlay->queue_families, (uint64_t)(uintptr_t)queue, (void *)name);
    pthread_mutex_unlock(&overlay->queue_lock);
}

bool cpu_queue_family(struct cpu_overlay *overlay, VkQueue queue, uint32_t *family)
{
    pthread_mutex_lock(&overlay->queue_lock);
    uintptr_t name =
        (uintptr_t)handle_table_find(&overlay->queue_families, (uint64_t)(uintptr_t)queue);
    pthread_mutex_unlock(&overlay->queue_lock);
    *family = (uint32_t)name - 1;
    return name != 0;
}

VKAPI_ATTR void VKAPI_CALL cpu_GetDeviceQueue(VkDevice device, uint32_t queueFamilyIndex,
                                              uint32_t queueIndex, VkQueue *pQueue)
{
    struct cpu_overlay *overlay = cpu_overlay_of(device);
    overlay->next.GetDeviceQueue(device, queueFamilyIndex, queueIndex, pQueue);
    note_family(overlay, *pQueue, queueFamilyIndex);
}

VKAPI_ATTR void VKAPI_CALL cpu_GetDeviceQueue2(VkDevice device,
                                               const VkDeviceQueueInfo2 *pQueueInfo,
                                               VkQueue *pQueue)
{
    struct cpu_overlay *overlay = cpu_overlay_of(device);
    overlay->next.GetDeviceQueue2(device, pQueueInfo, pQueue);
    note_family(overlay, *pQueue, pQueueInfo->queueFamilyIndex);
}

VKAPI_ATTR VkResult VKAPI_CALL cpu_QueueBindSparse(VkQueue queue, uint32_t bindInfoCount,
                                                   const VkBindSparseInfo *pBindInfo, VkFence fence)
{
    struct cpu_overlay *overlay = cpu_overlay_of(queue);
    pthread_mutex_lock(&overlay->queue_lock);
    VkResult result = overlay->next.QueueBindSparse(queue, bindInfoCount, pBindInfo, fence);
    pthread_mutex_unlock(&overlay->queue_lock);
    return result;
}

VKAPI_ATTR VkResult VKAPI_CALL cpu_QueuePresentKHR(VkQueue queue,
                                                   const VkPresentInfoKHR *pPresentInfo)
{
    struct cpu_overlay *overlay = cpu_overlay_of(queue);
    pthread_mutex_lock(&overlay->queue_lock);
    VkResult result = overlay->next.QueuePresentKHR(queue, pPresentInfo);
    pthread_mutex_unlock(&overlay->queue_lock);
    return result;
}

VKAPI_ATTR void VKAPI_CALL cpu_CmdExecuteCommands(VkCommandBuffer commandBuffer,
                                                  uint32_t commandBufferCount,
                                                  const VkCommandBuffer *pCommandBuffers)
{
    const struct layer_device *device = layer_find_device(commandBuffer);
    for (uint32_t i = 0; i < commandBufferCount; i++) {
        struct recording *recording = recording_of(device, pCommandBuffers[i]);
        struct recorder recorder;
        if (!recording || !recording->first || !recorder_begin(&recorder, commandBuffer))
            continue;
        const struct recorded_item item = {.kind = ITEM_EXECUTE,
                                           .secondary = recording_share(recording)};
        recorder_add(&recorder, &item);
    }
    device->cpu->next.CmdExecuteCommands(commandBuffer, commandBufferCount, pCommandBuffers);
}

/* ---- turns */

static void warn_of_losses(const struct layer_device *device)
{
    if (cpu_playback_take_lost(device->cpu->playback))
        reporter_warn(
            device->instance->reporter,
            "assay_validation.backend = cpu had no memory for what a submission builds or "
            "writes: structures and buffers may be without it.");
}

void cpu_overlay_run(const struct layer_device *device, const struct batch_run *run)
{
    struct cpu_overlay *overlay = device->cpu;
    for (uint32_t i = 0; i < run->command_count; i++) {
        const struct journal *journal = run->commands[i].captured;
        if (journal && journal->work)
            cpu_playback_run(overlay->playback, journal->work, run->moment);
    }
    warn_of_losses(device);
}

void cpu_overlay_lose_order(const struct layer_device *device)
{
    atomic_store(&device->cpu->order_lost, true);
    cpu_playback_run_all(device->cpu->playback);
    warn_of_losses(device);
}
