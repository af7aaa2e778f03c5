/* SPDX-License-Identifier: Apache-2.0 */
/* Recordings of command buffers, and the memory and barriers of their snapshots. */
#include "layer/snapshots/recorder.h"

#include "layer/snapshots/consumers.h"
#include "layer/snapshots/copies/dispatches.h"
#include "layer/snapshots/copies/orders.h"
#include "layer/snapshots/copies/staging.h"
#include "layer/snapshots/guard/copies.h"
#include "layer/snapshots/marks.h"
#include "layer/snapshots/words.h"

enum { SNAPSHOT_ALIGNMENT = 64 };

static void free_chunk(void *user, struct snapshot_chunk *chunk)
{
    const struct snapshots *snapshots = user;
    staging_give_back(snapshots->staging, (struct staging_chunk *)chunk);
}

static void free_guarded(void *user, struct snapshot_chunk *guarded)
{
    const struct snapshots *snapshots = user;
    guard_free_copies(snapshots->guard, guarded);
}

static void free_words(void *user, const struct mapped_words *words)
{
    const struct snapshots *snapshots = user;
    words_give_back(snapshots->words, words);
}

static struct recording *create_recording(struct snapshots *snapshots,
                                          const struct command_buffer *command_buffer)
{
    const struct recording_memory memory = {free_chunk, free_guarded, free_words, snapshots};
    struct recording *recording = recording_create(&memory);
    if (!recording)
        return NULL;
    if (command_buffer->has_early_bindings)
        recording->compute = *(const struct compute_state *)command_buffer->early_bindings;
    recording->executes_once = command_buffer->executes_once;
    recording->executes_at_once = command_buffer->executes_at_once;
    return recording;
}

static void release_work(void *recording)
{
    recording_release(recording);
}

struct recording *recording_of(const struct layer_device *device, VkCommandBuffer handle)
{
    const struct command_buffer *command_buffer =
        command_buffers_find(device->command_buffers, handle);
    return command_buffer && command_buffer->journal ? command_buffer->journal->work : NULL;
}

bool recorder_begin(struct recorder *recorder, VkCommandBuffer handle)
{
    struct layer_device *device = layer_find_recording_device(handle);
    *recorder = (struct recorder){.device = device, .handle = handle};
    if (!device)
        return false;
    recorder->command_buffer = command_buffers_find(device->command_buffers, handle);
    if (!recorder->command_buffer)
        return false;
    struct journal *journal = recorder->command_buffer->journal;
    if (journal && !journal->work) {
        journal->work = create_recording(device->snapshots, recorder->command_buffer);
        journal->release_work = release_work;
    }
    recorder->recording = journal ? journal->work : NULL;
    if (!recorder->recording) {
        recorder_fail(recorder);
        return false;
    }
    recording_continue(recorder->recording);
    if (recorder->recording->copy_block_count)
        recorder->first_order =
            recorder->recording->copy_blocks[recorder->recording->copy_block_count - 1].used;
    return true;
}

static bool is_place_for_copies(const struct command_buffer *command_buffer)
{
    const struct command_buffer_facts *facts = &command_buffer->facts;
    return facts->state == COMMAND_BUFFER_RECORDING && facts->in_render_pass != YES &&
           facts->in_video_coding != YES && facts->suspended != YES && facts->is_protected != YES;
}

bool recorder_begin_builds(struct recorder *recorder, VkCommandBuffer handle)
{
    if (!recorder_begin(recorder, handle))
        return false;
    recorder->cannot_inject = !recorder->device->snapshots->are_for_backend &&
                              !is_place_for_copies(recorder->command_buffer);
    return true;
}

void recorder_fail(struct recorder *recorder)
{
    recorder->command_buffer->work_failed = true;
    recorder->left_out = LEFT_OUT_MEMORY;
}

void recorder_add(struct recorder *recorder, const struct recorded_item *item)
{
    if (!recording_add(recorder->recording, item))
        recorder_fail(recorder);
}

/* ---- barriers */

/* The application has synchronized earlier writes with its build. This barrier extends that to all
 * commands, then to the copies. It also orders the copies after those of an earlier execution,
 * which wrote to the same memory. */
void recorder_start_copies(struct recorder *recorder)
{
    if (recorder->has_copied)
        return;
    bool computes = recorder->command_buffer->pool->queue_flags & VK_QUEUE_COMPUTE_BIT;
    const VkMemoryBarrier barrier = {
        .sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER,
        .srcAccessMask = VK_ACCESS_MEMORY_WRITE_BIT,
        .dstAccessMask = VK_ACCESS_TRANSFER_READ_BIT | VK_ACCESS_TRANSFER_WRITE_BIT |
                         (computes ? VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_SHADER_WRITE_BIT : 0),
    };
    recorder->device->snapshots->next.CmdPipelineBarrier(
        recorder->handle, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT,
        VK_PIPELINE_STAGE_TRANSFER_BIT | (computes ? VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT : 0), 0,
        1, &barrier, 0, NULL, 0, NULL);
    recorder->has_copied = true;
}

/* The application synchronizes its next writes with the build only, so later commands must also
 * wait for the copies. */
void recorder_end(struct recorder *recorder)
{
    copy_orders_flush(recorder);
    copy_orders_mark(recorder);
    dispatches_end(recorder);
    const VkMemoryBarrier barrier = {
        .sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER,
        .srcAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT |
                         (recorder->has_dispatched ? VK_ACCESS_SHADER_WRITE_BIT : 0),
        .dstAccessMask = VK_ACCESS_HOST_READ_BIT,
    };
    if (!recorder->has_copied)
        return;
    recorder->device->snapshots->next.CmdPipelineBarrier(
        recorder->handle,
        VK_PIPELINE_STAGE_TRANSFER_BIT |
            (recorder->has_dispatched ? VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT : 0),
        VK_PIPELINE_STAGE_ALL_COMMANDS_BIT | VK_PIPELINE_STAGE_HOST_BIT, 0, 1, &barrier, 0, NULL, 0,
        NULL);
    recorder_mark_reached(recorder);
}

/* ---- copies */

bool recorder_find(const struct recorder *recorder, uint64_t address, struct buffer_target *target)
{
    if (recorder->addresses)
        return recorder->addresses->find(recorder->addresses->context, address, target);
    return buffer_target_find(recorder->device->resources, address, target);
}

/* If the budget is full, waits for complete executions to give memory back, if content_when_full is
 * `wait`. Waits only for work that depends on no further call of the application, and only for a
 * limited time. */
static VkResult take_chunk(const struct layer_device *device, uint64_t size,
                           struct staging_chunk **chunk)
{
    const struct settings *settings = reporter_settings(device->instance->reporter);
    bool waits = settings->content_when_full == CONTENT_WAIT;
    VkResult result;
    do {
        result = staging_take(device->snapshots->staging, size, chunk);
    } while (result == VK_NOT_READY && waits && snapshots_wait(device->snapshots));
    return result;
}

/* The recording's last chunk if it has room for `size` bytes, or a new one. Returns NULL if there
 * is no memory or the budget is full. */
static struct staging_chunk *chunk_with_room(struct recorder *recorder, uint64_t size)
{
    struct recording *recording = recorder->recording;
    if (recording->chunk_count) {
        struct snapshot_chunk *last = recording->chunks[recording->chunk_count - 1];
        if (last && size <= last->size - last->used)
            return (struct staging_chunk *)last;
    }
    struct staging_chunk *chunk;
    VkResult result = take_chunk(recorder->device, size, &chunk);
    if (result == VK_SUCCESS && recording_add_chunk(recording, &chunk->chunk))
        return chunk;
    if (result == VK_NOT_READY)
        recorder->left_out = LEFT_OUT_BUDGET;
    else
        recorder_fail(recorder);
    return NULL;
}

bool recorder_reserve(struct recorder *recorder, uint64_t size, struct snapshot *snapshot)
{
    uint64_t room = (size + SNAPSHOT_ALIGNMENT - 1) / SNAPSHOT_ALIGNMENT * SNAPSHOT_ALIGNMENT;
    struct staging_chunk *chunk = chunk_with_room(recorder, room);
    if (!chunk)
        return false;
    *snapshot = (struct snapshot){
        .size = size, .chunk = recorder->recording->chunk_count - 1, .offset = chunk->chunk.used};
    chunk->chunk.used += room;
    return true;
}
