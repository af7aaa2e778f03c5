/* SPDX-License-Identifier: Apache-2.0 */
/* Observes submissions. Each is prepared before the call goes down, which judges its batches,
 * and finished with the call's result. */
#include "layer/intercepts/lower.h"
#include "layer/snapshots/guard/execution.h"
#include "layer/snapshots/snapshots.h"
#include "observers.h"
#include "src/base/chain.h"

/* The commands that a semaphore operation of these stages orders, for states of structures. The
 * stage of builds includes copies of structures. Other stages count as nothing, even those that
 * include copies of structures: what is not ordered is unknown, and nothing is reported about it.
 * The hazard check has the stages themselves (submission_set_stages()). */
static enum semaphore_scope scope_of(VkPipelineStageFlags2 stages, VkPipelineStageFlags2 all)
{
    if (stages & (all | VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT))
        return SCOPE_ALL;
    return stages & VK_PIPELINE_STAGE_2_ACCELERATION_STRUCTURE_BUILD_BIT_KHR ? SCOPE_BUILDS
                                                                             : SCOPE_NOTHING;
}

/* A wait at the top of the pipe blocks all commands, a wait at its bottom none. For signals it is
 * the other way round (Vulkan specification, VkPipelineStageFlagBits2). */
static enum semaphore_scope scope_of_wait(VkPipelineStageFlags2 stages)
{
    return scope_of(stages, VK_PIPELINE_STAGE_2_TOP_OF_PIPE_BIT);
}

static enum semaphore_scope scope_of_signal(VkPipelineStageFlags2 stages)
{
    return scope_of(stages, VK_PIPELINE_STAGE_2_BOTTOM_OF_PIPE_BIT);
}

/* Whether a batch uses physical devices besides the first. If one of them waits for a semaphore or
 * signals it, that does not order the others. A device mask of 0 means all devices. */
static bool is_spread(const struct layer_device *device, const VkSubmitInfo2 *info)
{
    if (!device->facts.is_group)
        return false;
    for (uint32_t i = 0; i < info->commandBufferInfoCount; i++)
        if (info->pCommandBufferInfos[i].deviceMask != 1)
            return true;
    for (uint32_t i = 0; i < info->waitSemaphoreInfoCount; i++)
        if (info->pWaitSemaphoreInfos[i].deviceIndex)
            return true;
    for (uint32_t i = 0; i < info->signalSemaphoreInfoCount; i++)
        if (info->pSignalSemaphoreInfos[i].deviceIndex)
            return true;
    return false;
}

/* ---- submissions of command buffers */

/* A semaphore without a handle adds no operation. */
static void add_submit(struct submission *submission, const struct layer_device *device,
                       const VkSubmitInfo2 *info)
{
    bool spread = is_spread(device, info);
    submission_add_batch(submission);
    for (uint32_t i = 0; i < info->waitSemaphoreInfoCount; i++) {
        const VkSemaphoreSubmitInfo *wait = &info->pWaitSemaphoreInfos[i];
        submission_add_wait(submission, wait->semaphore, wait->value,
                            spread ? SCOPE_NOTHING : scope_of_wait(wait->stageMask));
        if (wait->semaphore)
            submission_set_stages(submission, wait->stageMask);
    }
    for (uint32_t i = 0; i < info->commandBufferInfoCount; i++)
        submission_add_commands(submission, info->pCommandBufferInfos[i].commandBuffer);
    for (uint32_t i = 0; i < info->signalSemaphoreInfoCount; i++) {
        const VkSemaphoreSubmitInfo *signal = &info->pSignalSemaphoreInfos[i];
        submission_add_signal(submission, signal->semaphore, signal->value,
                              spread ? SCOPE_NOTHING : scope_of_signal(signal->stageMask));
        if (signal->semaphore)
            submission_set_stages(submission, signal->stageMask);
    }
}

/* Counts the call, whether or not it will succeed. */
static struct submission *begin_submission(struct layer_device *device, VkQueue queue)
{
    destroyed_objects_count_submission(device->destroyed);
    guard_begin_submission();
    struct submission_origin origin = queue_labels_submit(device->queue_labels, queue);
    origin.frame = atomic_load(&device->frame);
    struct submission *submission = submission_begin(device->order, SUBMIT_COMMANDS, queue);
    submission_set_origin(submission, &origin, resources_destroy_count(device->resources));
    return submission;
}

/* `infos`: NULL if memory has run out for those of a call that is lowered. */
struct submission *begin_submit(struct layer_device *device, VkQueue queue, uint32_t count,
                                const VkSubmitInfo2 *infos, VkFence fence)
{
    if (count && !infos)
        execution_order_set_unknown(device->order, ORDER_UNKNOWN_OUT_OF_MEMORY);
    struct submission *submission = begin_submission(device, queue);
    for (uint32_t i = 0; submission && i < count; i++)
        add_submit(submission, device, &infos[i]);
    submission_set_fence(submission, fence);
    return submission;
}

/* Returns whether to skip the call. */
bool prepare_submit(struct layer_device *device, struct submission *submission)
{
    bool skip = submission_prepare(submission);
    if (skip) {
        submission_finish(submission, VK_ERROR_VALIDATION_FAILED_EXT);
        events_forget(device->events);
    }
    return skip;
}

/* If the device is lost, it may have executed a part of the submission. */
void end_submit(struct layer_device *device, struct submission *submission, VkResult result)
{
    if (result < VK_SUCCESS)
        events_forget(device->events);
    submission_finish(submission, result);
}

/* ---- vkQueueBindSparse */

/* Whether the bindings belong to another physical device of the group than the first. Only those of
 * the first are tracked. */
static bool is_of_other_device(const VkBindSparseInfo *info)
{
    const VkDeviceGroupBindSparseInfo *group =
        chain_find(info->pNext, VK_STRUCTURE_TYPE_DEVICE_GROUP_BIND_SPARSE_INFO);
    return group && (group->resourceDeviceIndex || group->memoryDeviceIndex);
}

/* Marks the bindings of the buffers as unknown. */
static void forget_bindings(struct layer_device *device, const VkBindSparseInfo *info)
{
    for (uint32_t i = 0; i < info->bufferBindCount; i++)
        resources_forget_sparse(device->resources, info->pBufferBinds[i].buffer);
}

/* Announces the bindings of buffers in a journal. Returns NULL if there are none, or if they are
 * not tracked. */
static struct journal *announce_bindings(struct layer_device *device, const VkBindSparseInfo *info)
{
    if (!info->bufferBindCount)
        return NULL;
    struct journal *journal =
        device->order && !is_of_other_device(info) ? journal_create(VK_NULL_HANDLE) : NULL;
    if (!journal) {
        forget_bindings(device, info);
        return NULL;
    }
    for (uint32_t i = 0; i < info->bufferBindCount; i++) {
        const VkSparseBufferMemoryBindInfo *binds = &info->pBufferBinds[i];
        for (uint32_t j = 0; j < binds->bindCount; j++) {
            struct sparse_binding binding =
                resources_announce_sparse(device->resources, binds->buffer, &binds->pBinds[j]);
            journal_add_binding(journal, &binding);
        }
    }
    return journal;
}

static void add_bindings(struct submission *submission, struct layer_device *device,
                         const VkBindSparseInfo *info)
{
    submission_add_batch(submission);
    for (uint32_t i = 0; i < info->waitSemaphoreCount; i++)
        submission_add_wait(submission, info->pWaitSemaphores[i],
                            lower_value(info->pNext, WAIT_OF_BATCH, i), SCOPE_ALL);
    struct journal *journal = announce_bindings(device, info);
    if (journal)
        submission_add_work(submission, journal);
    for (uint32_t i = 0; i < info->signalSemaphoreCount; i++)
        submission_add_signal(submission, info->pSignalSemaphores[i],
                              lower_value(info->pNext, SIGNAL_OF_BATCH, i), SCOPE_ALL);
}

struct submission *begin_bind_sparse(struct layer_device *device, VkQueue queue, uint32_t count,
                                     const VkBindSparseInfo *infos, VkFence fence)
{
    struct submission *submission = submission_begin(device->order, SUBMIT_BINDINGS, queue);
    for (uint32_t i = 0; i < count; i++)
        if (submission)
            add_bindings(submission, device, &infos[i]);
        else
            forget_bindings(device, &infos[i]);
    submission_set_fence(submission, fence);
    submission_prepare(submission);
    return submission;
}

void end_bind_sparse(struct submission *submission, VkResult result)
{
    submission_finish(submission, result);
}

/* ---- presentation */

/* If the call fails, its waits may not have happened. Without the signals their order is unknown.
 */
void note_present(struct layer_device *device, const VkPresentInfoKHR *info)
{
    atomic_fetch_add(&device->frame, 1);
    for (uint32_t i = 0; i < info->waitSemaphoreCount; i++)
        execution_order_forget_signal(device->order, info->pWaitSemaphores[i]);
}

void observe_present(struct layer_device *device)
{
    snapshots_deliver(device);
}

/* The presentation engine signals the semaphore and the fence, not a batch. A fence that was reset
 * needs no update. */
void note_acquisition(struct layer_device *device, VkSemaphore semaphore, VkResult result)
{
    if (semaphore && result >= VK_SUCCESS)
        execution_order_forget_signal(device->order, semaphore);
    if (result >= VK_SUCCESS)
        execution_order_note_acquisition(device->order);
}

/* An image that has been presented was waited for. */
void observe_presentation(struct layer_device *device, VkResult result)
{
    if (result == VK_SUCCESS || result == VK_SUBOPTIMAL_KHR)
        execution_order_observe_unknown(device->order, NULL);
}
