/* SPDX-License-Identifier: Apache-2.0 */
/* Updates copy orders at a submission. */
#include <stdlib.h>

#include "layer/snapshots/copies/copies.h"
#include "layer/snapshots/executions.h"
#include "layer/snapshots/guard/execution.h"
#include "layer/snapshots/guard/references.h"
#include "layer/snapshots/marks.h"
#include "layer/snapshots/recorder.h"
#include "layer/snapshots/snapshots.h"
#include "observers.h"
#include "src/base/array.h"

struct renewal {
    const struct layer_device *device;
    const struct ticket *next;
    bool has_limits;
    struct execution_clock seen; /* completions that the host has observed */
};

static void renew_order(const struct renewal *renewal, struct copy_order *order)
{
    struct resources *resources = renewal->device->resources;
    struct address_facts facts;
    order->is_done = 0;
    if (!order->source)
        return;
    if (order->size) {
        order->left =
            resources_find_readable(resources, order->source, order->size, &renewal->seen);
        return;
    }
    resources_look_up_address(resources, order->source, &facts);
    order->left = facts.status == ADDRESS_IN_BUFFER ? facts.bytes_left : 0;
}

static void renew_recording(const struct renewal *renewal, struct recording *recording)
{
    bool is_pending = recording_is_pending(recording, renewal->next);
    bool has_chunks = recording_open_gate(recording);
    bool is_renewed = has_chunks && !is_pending;
    recording_clear_marks(recording, renewal->next, is_pending);
    for (uint32_t i = 0; i < recording->copy_block_count && is_renewed; i++) {
        const struct copy_block *block = &recording->copy_blocks[i];
        for (uint32_t j = 0; block->orders.chunk < recording->chunk_count && j < block->used; j++)
            renew_order(renewal, &copy_orders_at(recording, &block->orders)[j]);
    }
    if (is_renewed)
        gather_renew_ranges(renewal->device, recording);
    if (has_chunks)
        guard_renew(renewal->device, recording, &renewal->seen, !is_renewed, renewal->has_limits);
    struct journal_walk walk = journal_start_secondaries(recording->journal);
    for (const struct journal *secondary; (secondary = journal_next_secondary(&walk));)
        if (secondary->work)
            renew_recording(renewal, secondary->work);
}

/* Updates the orders of a recording and of its secondaries before it is submitted with the ticket
 * `next`, because buffers were created and destroyed since it was recorded. Orders that the device
 * still executes stay unchanged, except the limits of guarded builds. `has_limits`: see
 * guard_renew(). The lock of executions is held. */
static void copy_orders_renew(const struct layer_device *device, struct recording *recording,
                              const struct ticket *next, bool has_limits)
{
    struct renewal renewal = {.device = device, .next = next, .has_limits = has_limits};
    execution_order_host_clock(device->order, &renewal.seen);
    renew_recording(&renewal, recording);
}

/* ---- Submissions. A submission with recordings is followed by a fence of the layer's own, which
 * signals when its snapshots can be read. On backend driver the application's submission goes down
 * unchanged. If memory runs out there, the snapshots are not validated. On backend cpu such a fence
 * follows each batch with recordings, because a later batch may wait for what the host does with a
 * structure of an earlier one; and the application's fence comes last, so that it signals later. */

/* ---- what a submission has to do with snapshots */

struct submit {
    struct snapshots *snapshots;
    VkQueue queue;
    PFN_vkQueueSubmit2 next; /* this call's command and parameters, or those of the older one */
    const VkSubmitInfo2 *infos;
    PFN_vkQueueSubmit next_older;
    const VkSubmitInfo *older;
    uint32_t batch_count;
    struct submission *submission; /* NULL: the order is unknown */
    bool has_limits;               /* the guarded builds of the batch: guard_limited_batches() */
    struct ticket *ticket;         /* of the call, or of the batch */
    uint64_t call;                 /* see struct ticket */
    struct submitted_execution {
        struct execution *execution;
        uint32_t batch, command; /* indices of the batch and of the command buffer in the call */
    } * executions;
    uint32_t count, capacity;
    uint32_t batch, commands; /* the batch that is described, and the command buffers so far */
    struct missed_executions missed;
    uint32_t unfenced; /* executions whose end nothing shows */
    VkResult result;   /* result so far */
};

/* The longest wait for an execution whose snapshots are about to be overwritten. Often the
 * application has already observed its end, and the layer's fence signals a moment later. But an
 * observed fence only shows that earlier batches have begun. */
static const uint64_t DETACH_NANOSECONDS = 2000 * 1000 * UINT64_C(1000);

static bool reserve_execution(struct submit *submit)
{
    return ARRAY_HAS_ROOM(submit->executions, submit->count, submit->capacity);
}

/* Other threads may submit the recording, or one of its secondaries, at the same time. The lock
 * makes one of two executions exist before the orders are renewed for the other. The copy orders
 * are renewed even if no execution can be created, because the device may only read memory that
 * exists now; from then on the recording counts as pending. */
static struct execution *create_execution(struct submit *submit, struct recording *recording)
{
    struct snapshots *snapshots = submit->snapshots;
    pthread_mutex_lock(&snapshots->executions_lock);
    submit->missed.unread += recording_detach(recording, submit->ticket, 0);
    copy_orders_renew(snapshots->device, recording, submit->ticket, submit->has_limits);
    struct execution *execution = submit->ticket && reserve_execution(submit)
                                      ? execution_create(recording, submit->ticket)
                                      : NULL;
    if (execution && !snapshots->are_for_backend)
        submit->missed.unread += execution_drop_contested(execution);
    else if (!execution && !snapshots->are_for_backend)
        recording_invalidate(recording);
    pthread_mutex_unlock(&snapshots->executions_lock);
    return execution;
}

static void begin_ticket(struct submit *submit)
{
    submit->ticket = ticket_create(submit->snapshots, submit->queue);
    if (submit->ticket && submit->call)
        submit->ticket->call = submit->call;
    else if (submit->ticket)
        submit->call = submit->ticket->call;
}

static bool add_execution(struct submit *submit, struct recording *recording)
{
    if (!submit->ticket)
        begin_ticket(submit);
    submit->missed.unread += recording_detach(recording, submit->ticket, DETACH_NANOSECONDS);
    struct execution *execution = create_execution(submit, recording);
    if (!execution)
        return false;
    submit->missed.repeated += execution_count_repeated(execution);
    execution->destroy_count = resources_destroy_count(submit->snapshots->device->resources);
    execution->submissions = destroyed_objects_submissions(submit->snapshots->device->destroyed);
    submit->executions[submit->count++] =
        (struct submitted_execution){execution, submit->batch, submit->commands};
    return true;
}

static void add_recording(struct submit *submit, struct recording *recording)
{
    if (!recording || !recording->has_commands || submit->result != VK_SUCCESS ||
        add_execution(submit, recording))
        return;
    if (submit->snapshots->are_for_backend)
        submit->result = VK_ERROR_OUT_OF_HOST_MEMORY;
    else
        submit->missed.no_memory++;
}

static void add_command_buffer(struct submit *submit, VkCommandBuffer handle)
{
    const struct layer_device *device = submit->snapshots->device;
    warn_left_out(device, handle);
    add_recording(submit, recording_of(device, handle));
    submit->commands++;
}

static void begin_batch(struct submit *submit, uint32_t batch)
{
    submit->batch = batch;
    submit->has_limits = batch < guard_limited_batches();
    if (!submit->snapshots->are_for_backend)
        return;
    ticket_release(submit->ticket);
    submit->ticket = NULL;
}

static uint32_t count_overwritten(const struct execution *execution)
{
    uint32_t count = execution && atomic_load(&execution->is_overwritten);
    for (uint32_t i = 0; execution && !count && i < execution->child_count; i++)
        count += count_overwritten(execution->children[i]);
    return count;
}

static void report_missed(struct submit *submit)
{
    for (uint32_t i = 0; i < submit->count; i++)
        submit->missed.overwritten += count_overwritten(submit->executions[i].execution);
    warn_missed(submit->snapshots->device, &submit->missed);
}

static void release_executions(struct submit *submit)
{
    ticket_release(submit->ticket);
    free(submit->executions);
}

/* Releases everything if nothing was submitted. */
static VkResult abandon_submit(struct submit *submit, VkResult result)
{
    for (uint32_t i = 0; i < submit->count; i++)
        execution_release(submit->executions[i].execution);
    release_executions(submit);
    return result;
}

static VkResult call_down(const struct submit *submit, uint32_t first, uint32_t count,
                          VkFence fence)
{
    return submit->next ? submit->next(submit->queue, count, submit->infos + first, fence)
                        : submit->next_older(submit->queue, count, submit->older + first, fence);
}

/* The device executes the batches, and nothing will show when it has ended. The executions count as
 * pending until their recordings do. */
static void forget_executions(struct submit *submit)
{
    for (uint32_t i = 0; i < submit->count; i++) {
        recording_invalidate(submit->executions[i].execution->recording);
        execution_release(submit->executions[i].execution);
    }
    submit->unfenced = submit->count;
    submit->count = 0;
}

/* Backend driver: if the fence cannot be submitted, nothing is validated. */
static VkResult submit_at_once(struct submit *submit, VkFence fence)
{
    VkResult result = call_down(submit, 0, submit->batch_count, fence);
    if (!submit->count || (result != VK_SUCCESS && result != VK_ERROR_DEVICE_LOST))
        return result;
    VkResult end = result == VK_SUCCESS ? ticket_submit(submit->ticket) : result;
    if (end == VK_ERROR_DEVICE_LOST)
        ticket_refuse(submit->ticket);
    else if (end != VK_SUCCESS)
        forget_executions(submit);
    return result;
}

/* Backend cpu: submits the batches, with a fence behind each one that has executions. If a part of
 * them cannot be submitted, or their end cannot be observed, the device counts as lost. */
static VkResult submit_batches(struct submit *submit, VkFence fence)
{
    VkResult result = VK_SUCCESS;
    uint32_t first = 0, i = 0;
    while (i < submit->count) {
        const struct submitted_execution *last = &submit->executions[i];
        struct ticket *ticket = last->execution->ticket;
        result = call_down(submit, first, last->batch + 1 - first, VK_NULL_HANDLE);
        if (result != VK_SUCCESS && !first)
            break;
        if (result != VK_SUCCESS || (result = ticket_submit(ticket)) != VK_SUCCESS) {
            result = VK_ERROR_DEVICE_LOST;
            break;
        }
        first = last->batch + 1;
        while (i < submit->count && submit->executions[i].execution->ticket == ticket)
            i++;
    }
    if (result == VK_SUCCESS && (first < submit->batch_count || fence || !first)) {
        result = call_down(submit, first, submit->batch_count - first, fence);
        if (result != VK_SUCCESS && first)
            result = VK_ERROR_DEVICE_LOST;
    }
    for (; result == VK_ERROR_DEVICE_LOST && i < submit->count; i++)
        ticket_refuse(submit->executions[i].execution->ticket);
    return result;
}

/* If the device is lost, it may have executed a part of the batches. */
static VkResult give_executions(struct submit *submit, VkResult result)
{
    struct snapshots *snapshots = submit->snapshots;
    if (!submit->count || (result != VK_SUCCESS && result != VK_ERROR_DEVICE_LOST))
        return abandon_submit(submit, result);
    for (uint32_t i = 0; i < submit->count; i++) {
        const struct submitted_execution *submitted = &submit->executions[i];
        if (!submit->submission ||
            !submission_set_execution(submit->submission, submitted->command, submitted->execution))
            snapshots_run_unordered(snapshots, submitted->execution);
    }
    release_executions(submit);
    if (unknown_is_set(&snapshots->order_unknown))
        snapshots_run_all(snapshots);
    return result;
}

/* No message is sent while the queue counts as in use. */
static VkResult submit_all(struct submit *submit, VkFence fence)
{
    struct snapshots *snapshots = submit->snapshots;
    report_missed(submit);
    if (submit->result != VK_SUCCESS)
        return abandon_submit(submit, submit->result);
    snapshots_enter_queue(snapshots->device, submit->queue);
    VkResult result =
        snapshots->are_for_backend ? submit_batches(submit, fence) : submit_at_once(submit, fence);
    result = give_executions(submit, result);
    snapshots_leave_queue(snapshots->device, submit->queue);
    warn_missed(snapshots->device, &(struct missed_executions){.no_memory = submit->unfenced});
    warn_unordered(snapshots->device);
    return result;
}

static struct submit begin_snapshots_submit(struct snapshots *snapshots, VkQueue queue)
{
    snapshots_deliver(snapshots->device);
    guard_follow(snapshots->device);
    staging_note_submission(snapshots->staging);
    if (snapshots->guard)
        staging_note_submission(guard_memory(snapshots->guard));
    return (struct submit){
        .snapshots = snapshots,
        .queue = queue,
        .submission = execution_order_under_way(snapshots->device->order, queue),
    };
}

static VkResult submit_with_copies(struct submit *submit, uint32_t count,
                                   const VkSubmitInfo2 *infos, VkFence fence)
{
    submit->batch_count = count;
    submit->result = count && !infos ? VK_ERROR_OUT_OF_HOST_MEMORY : VK_SUCCESS;
    for (uint32_t i = 0; infos && i < count; i++) {
        begin_batch(submit, i);
        for (uint32_t j = 0; j < infos[i].commandBufferInfoCount; j++)
            add_command_buffer(submit, infos[i].pCommandBufferInfos[j].commandBuffer);
    }
    return submit_all(submit, fence);
}

VkResult snapshots_submit(struct layer_device *device, PFN_vkQueueSubmit2 next, VkQueue queue,
                          uint32_t count, const VkSubmitInfo2 *infos, VkFence fence)
{
    struct submit submit = begin_snapshots_submit(device->snapshots, queue);
    submit.next = next;
    submit.infos = infos;
    return submit_with_copies(&submit, count, infos, fence);
}

/* `infos`: the batches as vkQueueSubmit2 has them. Without memory for them the call fails: what the
 * copies may read is unknown. */
VkResult snapshots_submit_older(struct layer_device *device, PFN_vkQueueSubmit next, VkQueue queue,
                                uint32_t count, const VkSubmitInfo *older,
                                const VkSubmitInfo2 *infos, VkFence fence)
{
    struct submit submit = begin_snapshots_submit(device->snapshots, queue);
    submit.next_older = next;
    submit.older = older;
    return submit_with_copies(&submit, count, infos, fence);
}

void snapshots_note_secondaries(struct layer_device *device, VkCommandBuffer handle, uint32_t count,
                                const VkCommandBuffer *secondaries)
{
    for (uint32_t i = 0; i < count; i++) {
        const struct recording *recording = recording_of(device, secondaries[i]);
        struct recorder recorder;
        warn_left_out(device, secondaries[i]);
        if (recording && recording->has_commands && recorder_begin(&recorder, handle))
            recorder.recording->has_commands = true;
    }
}
