/* SPDX-License-Identifier: Apache-2.0 */
/* Results that commands write to buffers on backend cpu: serialized structures and queries.
 *
 * The host computes them, so they reach the buffer when the submission is complete, before the
 * application can observe that. Commands of the same submission that read the buffer read too
 * early. What the host cannot write is copied by a submission of the backend's own. */
#include <stdlib.h>
#include <string.h>

#include "layer/cpu/overlay.h"
#include "layer/snapshots/copies/copies.h"
#include "layer/snapshots/executions.h"
#include "observers.h"
#include "src/cpu/playback.h"

/* One copy to a buffer by the device. */
struct transfer {
    struct transfer *next;
    struct layer_device *device;
    const VkuDeviceDispatchTable *vk; /* the next layer's */
    VkCommandPool pool;
    VkCommandBuffer command_buffer;
    VkQueue queue;
    VkFence fence;
    struct staging_chunk *chunk;
};

static void free_transfer(struct transfer *transfer)
{
    VkDevice device = transfer->device->handle;
    if (transfer->chunk)
        staging_give_back(transfer->device->snapshots->staging, transfer->chunk);
    transfer->vk->DestroyFence(device, transfer->fence, NULL);
    transfer->vk->DestroyCommandPool(device, transfer->pool, NULL);
    free(transfer);
}

static bool create_transfer(struct transfer *transfer, uint64_t size)
{
    struct snapshots *snapshots = transfer->device->snapshots;
    VkDevice device = transfer->device->handle;
    uint32_t family;
    if (!snapshots_queue_family(snapshots, transfer->queue, &family))
        return false;
    const VkCommandPoolCreateInfo pool_info = {
        .sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO,
        .flags = VK_COMMAND_POOL_CREATE_TRANSIENT_BIT,
        .queueFamilyIndex = family,
    };
    const VkFenceCreateInfo fence_info = {.sType = VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
    if (staging_take(snapshots->staging, size, &transfer->chunk) != VK_SUCCESS ||
        transfer->vk->CreateFence(device, &fence_info, NULL, &transfer->fence) != VK_SUCCESS ||
        transfer->vk->CreateCommandPool(device, &pool_info, NULL, &transfer->pool) != VK_SUCCESS)
        return false;
    const VkCommandBufferAllocateInfo allocate_info = {
        .sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
        .commandPool = transfer->pool,
        .level = VK_COMMAND_BUFFER_LEVEL_PRIMARY,
        .commandBufferCount = 1,
    };
    return transfer->vk->AllocateCommandBuffers(device, &allocate_info,
                                                &transfer->command_buffer) == VK_SUCCESS &&
           (!snapshots->set_loader_data ||
            snapshots->set_loader_data(device, transfer->command_buffer) == VK_SUCCESS);
}

static VkResult record_transfer(const struct transfer *transfer, VkBuffer buffer,
                                const VkBufferCopy *regions, uint32_t region_count)
{
    const VkCommandBufferBeginInfo begin_info = {
        .sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO,
        .flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT,
    };
    const VkMemoryBarrier barrier = {
        .sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER,
        .srcAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT,
        .dstAccessMask = VK_ACCESS_MEMORY_READ_BIT | VK_ACCESS_MEMORY_WRITE_BIT,
    };
    VkResult result = transfer->vk->BeginCommandBuffer(transfer->command_buffer, &begin_info);
    if (result != VK_SUCCESS)
        return result;
    transfer->vk->CmdCopyBuffer(transfer->command_buffer, transfer->chunk->buffer.handle, buffer,
                                region_count, regions);
    transfer->vk->CmdPipelineBarrier(transfer->command_buffer, VK_PIPELINE_STAGE_TRANSFER_BIT,
                                     VK_PIPELINE_STAGE_ALL_COMMANDS_BIT |
                                         VK_PIPELINE_STAGE_HOST_BIT,
                                     0, 1, &barrier, 0, NULL, 0, NULL);
    return transfer->vk->EndCommandBuffer(transfer->command_buffer);
}

static bool wait_for(const struct transfer *transfer, uint64_t nanoseconds)
{
    return ticket_result_is_final(transfer->vk->WaitForFences(
        transfer->device->handle, 1, &transfer->fence, VK_TRUE, nanoseconds));
}

/* Submits the copy. The queue is the layer's own to use: snapshots_begin_own_submission(). */
static VkResult submit_transfer(const struct transfer *transfer)
{
    const VkSubmitInfo info = {
        .sType = VK_STRUCTURE_TYPE_SUBMIT_INFO,
        .commandBufferCount = 1,
        .pCommandBuffers = &transfer->command_buffer,
    };
    return transfer->vk->QueueSubmit(transfer->queue, 1, &info, transfer->fence);
}

void cpu_overlay_end_transfers(struct cpu_overlay *overlay)
{
    uint64_t nanoseconds = TICKET_GRACE_NANOSECONDS;
    for (struct transfer *transfer; overlay && (transfer = overlay->unfinished);) {
        overlay->unfinished = transfer->next;
        if (wait_for(transfer, nanoseconds)) {
            free_transfer(transfer);
            continue;
        }
        nanoseconds = 0;
        staging_leave(transfer->device->snapshots->staging, transfer->chunk);
        free(transfer);
    }
}

static bool buffer_is_alive(const struct layer_device *device, VkBuffer handle)
{
    struct buffer_facts facts;
    resources_look_up_buffer(device->resources, handle, &facts);
    return facts.alive == YES;
}

/* A copy by the device. If it fails, the buffer keeps its contents. */
static bool write_by_device(struct layer_device *device, const struct result_bytes *result)
{
    struct snapshots *snapshots = device->snapshots;
    struct transfer *transfer = calloc(1, sizeof(*transfer));
    VkResult submitted = VK_ERROR_UNKNOWN;
    if (!transfer)
        return true;
    transfer->device = device;
    transfer->vk = &device->cpu->down;
    transfer->queue = result->ticket->queue;
    bool is_created = create_transfer(transfer, result->size);
    if (is_created) {
        memcpy(transfer->chunk->chunk.bytes, result->bytes, result->size);
        is_created = record_transfer(transfer, result->buffer, result->regions,
                                     result->region_count) == VK_SUCCESS;
    }
    bool may_submit =
        is_created && snapshots_begin_own_submission(snapshots, result->ticket->queue);
    if (may_submit) {
        submitted = submit_transfer(transfer);
        snapshots_end_own_submission(snapshots);
    }
    if (submitted != VK_SUCCESS || wait_for(transfer, TICKET_GRACE_NANOSECONDS)) {
        free_transfer(transfer);
    } else {
        transfer->next = device->cpu->unfinished;
        device->cpu->unfinished = transfer;
    }
    return may_submit || !is_created;
}

/* Called by one thread at a time. Where the host can write the buffer, no queue is used: a copy
 * would wait for all that the application has submitted to the queue, which may wait for a call
 * that the application makes only when it has the result. */
static bool write_result(void *user, const struct result_bytes *result)
{
    struct layer_device *device = user;
    return cpu_write_by_host(device, result) || !buffer_is_alive(device, result->buffer) ||
           write_by_device(device, result);
}

/* ---- the consumer */

static void warn_of_losses(const struct layer_device *device)
{
    if (cpu_playback_take_failed(device->cpu->playback))
        reporter_warn(
            device->instance->reporter,
            "assay_validation.backend = cpu had no memory for what a submission builds or "
            "writes: structures and buffers may lack it.");
}

static bool is_to_be_reported(atomic_uint *occurrence)
{
    unsigned occurred = OCCURRED;
    return atomic_load(occurrence) == occurred &&
           atomic_compare_exchange_strong(occurrence, &occurred, OCCURRENCE_REPORTED);
}

void cpu_overlay_warn_of_occurrences(const struct layer_device *device)
{
    if (atomic_load(&device->cpu->device->lacks_copies))
        warn_lack_of_copies(device);
    if (is_to_be_reported(&device->cpu->device->overwritten))
        reporter_warn(device->instance->reporter,
                      "assay_validation.backend = cpu: a command buffer executed several times in "
                      "one submission, and the results of a build before the last time were asked "
                      "for. The layer builds them from what the last one copied.");
    if (is_to_be_reported(&device->cpu->device->used_early))
        reporter_warn(device->instance->reporter,
                      "assay_validation.backend = cpu: a structure was used by the host before the "
                      "commands that build it were complete. The layer waited 10 seconds for them, "
                      "and then went on without the structure.");
    if (atomic_exchange(&device->cpu->device->refused, 0))
        reporter_warn(device->instance->reporter,
                      "assay_validation.backend = cpu refuses a command of a command buffer that "
                      "writes a structure, which is then empty. The structure is smaller than "
                      "what is written to it, serialized data is incomplete or of another driver, "
                      "or what a build reads is not readable, or names what does not exist.");
}

static void warn_of_all(const struct layer_device *device)
{
    warn_of_losses(device);
    cpu_overlay_warn_of_occurrences(device);
}

static void cpu_overlay_run(void *user, struct order_batch *batch)
{
    const struct layer_device *device = user;
    uint32_t count = 0;
    for (uint32_t i = 0; i < batch->command_count; i++) {
        struct execution *execution = atomic_load(&batch->commands[i].execution);
        if (execution)
            cpu_playback_run(device->cpu->playback, execution, batch->timestamp);
        count += execution != NULL;
    }
    if (count)
        warn_of_all(device);
}

static void run_unordered(void *user, struct execution *execution)
{
    const struct layer_device *device = user;
    cpu_playback_run(device->cpu->playback, execution, timestamp_never());
}

static void cpu_overlay_deliver(void *user)
{
    struct layer_device *device = user;
    struct execution_clock seen = {0};
    const struct cpu_delivery delivery = {&seen, write_result, device};
    warn_of_all(device);
    if (!cpu_playback_has_results(device->cpu->playback))
        return;
    execution_order_host_clock(device->order, &seen);
    cpu_playback_deliver(device->cpu->playback, &delivery);
}

struct batch_consumer cpu_overlay_consumer(struct layer_device *device)
{
    return (struct batch_consumer){.user = device,
                                   .run = cpu_overlay_run,
                                   .run_unordered = run_unordered,
                                   .deliver = cpu_overlay_deliver};
}
