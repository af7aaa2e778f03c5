/* SPDX-License-Identifier: Apache-2.0 */
/* Submissions. Each that has recordings is followed by a fence of the layer's own, which tells when
 * its snapshots can be read; the application's fence comes after it, so that whoever sees that one
 * signalled finds the other so. */
#include <stdlib.h>

#include "snapshots/commands.h"
#include "snapshots/recorder.h"
#include "snapshots/tickets.h"

/* ---- what a submission has to do with snapshots */

struct submit {
    struct snapshots *snapshots;
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
        submit->ticket = ticket_create(submit->snapshots, submit->queue);
    if (!submit->ticket || !reserve(submit))
        return false;
    recording_detach(recording, submit->ticket);
    struct execution *execution = execution_create(recording, submit->ticket);
    if (!execution)
        return false;
    execution->deaths = resources_deaths(submit->snapshots->device->resources);
    submit->executions[submit->count++] = execution;
    return true;
}

static void add_command_buffer(struct submit *submit, VkCommandBuffer handle)
{
    struct recording *recording = recording_of(submit->snapshots->device, handle);
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
    VkResult result = ticket_submit(submit->ticket);
    if (result == VK_SUCCESS && fence)
        result = submit->snapshots->next.QueueSubmit(submit->queue, 0, NULL, fence);
    return result == VK_SUCCESS ? VK_SUCCESS : VK_ERROR_DEVICE_LOST;
}

/* `result` is that of the application's batches. */
static VkResult finish(struct submit *submit, VkFence fence, VkResult result)
{
    struct snapshots *snapshots = submit->snapshots;
    if (!submit->count)
        return result;
    if (result == VK_SUCCESS)
        result = submit_fences(submit, fence);
    if (result != VK_SUCCESS)
        return give_up(submit, result);
    for (uint32_t i = 0; i < submit->count; i++)
        snapshots_expect(snapshots, submit->executions[i]);
    release(submit);
    if (atomic_load(&snapshots->order_lost))
        snapshots_run_all(snapshots->device);
    return VK_SUCCESS;
}

static struct submit begin(VkQueue queue)
{
    struct snapshots *snapshots = snapshots_of(queue);
    snapshots_deliver(snapshots->device);
    return (struct submit){.snapshots = snapshots, .queue = queue};
}

VKAPI_ATTR VkResult VKAPI_CALL snapshots_QueueSubmit(VkQueue queue, uint32_t submitCount,
                                                     const VkSubmitInfo *pSubmits, VkFence fence)
{
    struct submit submit = begin(queue);
    struct snapshots *snapshots = submit.snapshots;
    for (uint32_t i = 0; i < submitCount; i++)
        for (uint32_t j = 0; j < pSubmits[i].commandBufferCount; j++)
            add_command_buffer(&submit, pSubmits[i].pCommandBuffers[j]);
    if (submit.result != VK_SUCCESS)
        return give_up(&submit, submit.result);
    pthread_mutex_lock(&snapshots->queue_lock);
    VkResult result = snapshots->below.QueueSubmit(queue, submitCount, pSubmits,
                                                   submit.count ? VK_NULL_HANDLE : fence);
    result = finish(&submit, fence, result);
    pthread_mutex_unlock(&snapshots->queue_lock);
    return result;
}

static VkResult submit2(PFN_vkQueueSubmit2 next, VkQueue queue, uint32_t count,
                        const VkSubmitInfo2 *infos, VkFence fence)
{
    struct submit submit = begin(queue);
    struct snapshots *snapshots = submit.snapshots;
    for (uint32_t i = 0; i < count; i++)
        for (uint32_t j = 0; j < infos[i].commandBufferInfoCount; j++)
            add_command_buffer(&submit, infos[i].pCommandBufferInfos[j].commandBuffer);
    if (submit.result != VK_SUCCESS)
        return give_up(&submit, submit.result);
    pthread_mutex_lock(&snapshots->queue_lock);
    VkResult result = next(queue, count, infos, submit.count ? VK_NULL_HANDLE : fence);
    result = finish(&submit, fence, result);
    pthread_mutex_unlock(&snapshots->queue_lock);
    return result;
}

VKAPI_ATTR VkResult VKAPI_CALL snapshots_QueueSubmit2(VkQueue queue, uint32_t submitCount,
                                                      const VkSubmitInfo2 *pSubmits, VkFence fence)
{
    return submit2(snapshots_of(queue)->below.QueueSubmit2, queue, submitCount, pSubmits, fence);
}

VKAPI_ATTR VkResult VKAPI_CALL snapshots_QueueSubmit2KHR(VkQueue queue, uint32_t submitCount,
                                                         const VkSubmitInfo2 *pSubmits,
                                                         VkFence fence)
{
    return submit2(snapshots_of(queue)->below.QueueSubmit2KHR, queue, submitCount, pSubmits, fence);
}

/* ---- other uses of queues, which the layer uses itself */

static void note_family(struct snapshots *snapshots, VkQueue queue, uint32_t family)
{
    uintptr_t name = (uintptr_t)family + 1;
    pthread_mutex_lock(&snapshots->queue_lock);
    handle_table_set(&snapshots->queue_families, (uint64_t)(uintptr_t)queue, (void *)name);
    pthread_mutex_unlock(&snapshots->queue_lock);
}

bool snapshots_queue_family(struct snapshots *snapshots, VkQueue queue, uint32_t *family)
{
    pthread_mutex_lock(&snapshots->queue_lock);
    uintptr_t name =
        (uintptr_t)handle_table_find(&snapshots->queue_families, (uint64_t)(uintptr_t)queue);
    pthread_mutex_unlock(&snapshots->queue_lock);
    *family = (uint32_t)name - 1;
    return name != 0;
}

VKAPI_ATTR void VKAPI_CALL snapshots_GetDeviceQueue(VkDevice device, uint32_t queueFamilyIndex,
                                                    uint32_t queueIndex, VkQueue *pQueue)
{
    struct snapshots *snapshots = snapshots_of(device);
    snapshots->below.GetDeviceQueue(device, queueFamilyIndex, queueIndex, pQueue);
    note_family(snapshots, *pQueue, queueFamilyIndex);
}

VKAPI_ATTR void VKAPI_CALL snapshots_GetDeviceQueue2(VkDevice device,
                                                     const VkDeviceQueueInfo2 *pQueueInfo,
                                                     VkQueue *pQueue)
{
    struct snapshots *snapshots = snapshots_of(device);
    snapshots->below.GetDeviceQueue2(device, pQueueInfo, pQueue);
    note_family(snapshots, *pQueue, pQueueInfo->queueFamilyIndex);
}

VKAPI_ATTR VkResult VKAPI_CALL snapshots_QueueBindSparse(VkQueue queue, uint32_t bindInfoCount,
                                                         const VkBindSparseInfo *pBindInfo,
                                                         VkFence fence)
{
    struct snapshots *snapshots = snapshots_of(queue);
    pthread_mutex_lock(&snapshots->queue_lock);
    VkResult result = snapshots->below.QueueBindSparse(queue, bindInfoCount, pBindInfo, fence);
    pthread_mutex_unlock(&snapshots->queue_lock);
    return result;
}

VKAPI_ATTR VkResult VKAPI_CALL snapshots_QueuePresentKHR(VkQueue queue,
                                                         const VkPresentInfoKHR *pPresentInfo)
{
    struct snapshots *snapshots = snapshots_of(queue);
    pthread_mutex_lock(&snapshots->queue_lock);
    VkResult result = snapshots->below.QueuePresentKHR(queue, pPresentInfo);
    pthread_mutex_unlock(&snapshots->queue_lock);
    return result;
}

VKAPI_ATTR void VKAPI_CALL snapshots_CmdExecuteCommands(VkCommandBuffer commandBuffer,
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
    device->snapshots->below.CmdExecuteCommands(commandBuffer, commandBufferCount, pCommandBuffers);
}
