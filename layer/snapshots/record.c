/* SPDX-License-Identifier: Apache-2.0 */
/* Recordings of command buffers, and the memory and barriers of their snapshots. */
#include "layer/snapshots/recorder.h"

#include "layer/snapshots/copies/copies.h"
#include "layer/snapshots/guard/copies.h"
#include "layer/snapshots/marks.h"

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

static void free_queries(void *user, VkQueryPool pool)
{
    const struct layer_device *device = ((const struct snapshots *)user)->device;
    device->vk.DestroyQueryPool(device->handle, pool, NULL);
}

static void create_recording(struct snapshots *snapshots,
                             const struct command_buffer *command_buffer)
{
    const struct recording_memory memory = {free_chunk, free_guarded, free_words, free_queries,
                                            snapshots};
    struct recording *recording = recording_create(command_buffer->journal, &memory);
    if (!recording)
        return;
    if (command_buffer->has_early_bindings)
        recording->compute = *(const struct compute_state *)command_buffer->early_bindings;
    recording->executes_once = command_buffer->executes_once;
    recording->executes_at_once = command_buffer->executes_at_once;
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
    if (journal && !journal->work)
        create_recording(device->snapshots, recorder->command_buffer);
    recorder->recording = journal ? journal->work : NULL;
    if (!recorder->recording) {
        recorder_fail(recorder);
        return false;
    }
    recording_continue(recorder->recording);
    if (reporter_has_sent())
        atomic_store(&recorder->recording->has_findings, true);
    const struct recording *recording = recorder->recording;
    if (recording->chunk_count)
        recorder->first_chunk = recording->chunk_count - 1;
    if (recording->copy_block_count) {
        const struct copy_block *last = &recording->copy_blocks[recording->copy_block_count - 1];
        recorder->first_order = last->used;
        recorder->first_chunk = last->orders.chunk;
    }
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
    recorder->builds = journal_start_builds_of_call(recorder->recording->journal);
    recorder->cannot_inject = !recorder->device->snapshots->are_for_backend &&
                              !is_place_for_copies(recorder->command_buffer);
    return true;
}

/* The journal has no entries of these commands that could have copies: recorder_keep_build() makes
 * them. */
bool recorder_begin_other(struct recorder *recorder, VkCommandBuffer handle)
{
    if (!recorder_begin_builds(recorder, handle))
        return false;
    recorder->builds = (struct journal_walk){0};
    recorder->is_other = true;
    return true;
}

void recorder_fail(struct recorder *recorder)
{
    recorder->command_buffer->work_failed = true;
    recorder->left_out = LEFT_OUT_MEMORY;
}

/* ---- entries */

void recorder_add(struct recorder *recorder, const struct recorded_command *command)
{
    struct recorded_command *entry = journal_append(recorder->recording->journal, sizeof(*entry));
    if (!entry) {
        recorder_fail(recorder);
        return;
    }
    const unsigned char size = entry->size;
    *entry = *command;
    entry->size = size;
    recorder->recording->has_commands = true;
}

void recorder_add_copy(struct recorder *recorder, const struct recorded_command *copy)
{
    if (journal_find_copy_of_call(recorder->recording->journal))
        recorder->recording->has_commands = true;
    else
        recorder_add(recorder, copy);
}

/* Finds the entry of a build among those of the call, which are in the order of the builds. Other
 * commands have none: a journal only has what they write. */
static struct journal_entry *find_entry(struct recorder *recorder, uint32_t info)
{
    if (!recorder->builds.journal)
        return NULL;
    if (!recorder->next_build)
        recorder->next_build = journal_next(&recorder->builds);
    while (recorder->next_build && recorder->next_build->info < info)
        recorder->next_build = journal_next(&recorder->builds);
    return recorder->next_build && recorder->next_build->info == info ? recorder->next_build : NULL;
}

void recorder_keep_build(struct recorder *recorder, struct recorded_build *build)
{
    struct journal_entry *entry = find_entry(recorder, build->place.info);
    if (!entry)
        entry = journal_add_inputs(recorder->recording->journal, build->place.command,
                                   build->place.info, build->place.position);
    if (!entry) {
        recorder_fail(recorder);
        recorded_build_free(build);
        return;
    }
    build->begins_call = !recorder->build_count++;
    journal_set_copies(entry, build);
    recording_add_build(recorder->recording, build);
}

/* ---- barriers */

/* The application orders its own accesses against the stage of builds, so the layer's barriers
 * connect its copies with that stage alone. docs/levels.md lists them. On backend cpu no build
 * reaches the driver, so there the barriers are about all stages. */

static void barrier(const struct recorder *recorder, VkPipelineStageFlags src,
                    VkPipelineStageFlags dst, VkAccessFlags src_access, VkAccessFlags dst_access)
{
    const VkMemoryBarrier memory = {
        .sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER,
        .srcAccessMask = src_access,
        .dstAccessMask = dst_access,
    };
    recorder->device->snapshots->next.CmdPipelineBarrier(
        recorder->handle, src, dst, 0, src_access || dst_access, &memory, 0, NULL, 0, NULL);
}

void recorder_order_buffer(const struct recorder *recorder, VkBuffer buffer,
                           const struct own_dependency *dependency)
{
    const VkBufferMemoryBarrier own = {
        .sType = VK_STRUCTURE_TYPE_BUFFER_MEMORY_BARRIER,
        .srcAccessMask = dependency->src_access,
        .dstAccessMask = dependency->dst_access,
        .srcQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
        .dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
        .buffer = buffer,
        .size = VK_WHOLE_SIZE,
    };
    recorder->device->snapshots->next.CmdPipelineBarrier(
        recorder->handle, dependency->src, dependency->dst, 0, 0, NULL, 1, &own, 0, NULL);
}

/* The stages of builds of micromaps and of copies are of extensions, which may be off. */
VkPipelineStageFlags recorder_build_stages(const struct recorder *recorder)
{
    return recorder->is_other ? VK_PIPELINE_STAGE_ALL_COMMANDS_BIT
                              : VK_PIPELINE_STAGE_ACCELERATION_STRUCTURE_BUILD_BIT_KHR;
}

static void start_on_backend(const struct recorder *recorder)
{
    bool computes = recorder->command_buffer->pool->queue_flags & VK_QUEUE_COMPUTE_BIT;
    barrier(recorder, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT,
            VK_PIPELINE_STAGE_TRANSFER_BIT | (computes ? VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT : 0),
            VK_ACCESS_MEMORY_WRITE_BIT,
            VK_ACCESS_TRANSFER_READ_BIT | VK_ACCESS_TRANSFER_WRITE_BIT |
                (computes ? VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_SHADER_WRITE_BIT : 0));
}

/* The application has made its writes available, and ordered them before the stage of builds. This
 * barrier continues that dependency with the copies, and makes nothing else available. If the
 * command buffer may execute several times at once, each execution writes to the same memory. */
void recorder_start_copies(struct recorder *recorder)
{
    if (recorder->has_copied)
        return;
    recorder->has_copied = true;
    if (recorder->device->snapshots->are_for_backend) {
        start_on_backend(recorder);
        return;
    }
    const bool transfers = recorder->addresses;
    VkPipelineStageFlags own =
        transfers ? VK_PIPELINE_STAGE_TRANSFER_BIT : VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT;
    VkAccessFlags reads = transfers ? VK_ACCESS_TRANSFER_READ_BIT : VK_ACCESS_SHADER_READ_BIT;
    VkAccessFlags writes = 0;
    VkPipelineStageFlags earlier = 0;
    if (recorder->recording->executes_at_once) {
        own |= VK_PIPELINE_STAGE_TRANSFER_BIT; /* copies of NV instances */
        writes = VK_ACCESS_TRANSFER_WRITE_BIT;
        if (recorder->command_buffer->pool->queue_flags & VK_QUEUE_COMPUTE_BIT) {
            own |= VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT;
            writes |= VK_ACCESS_SHADER_WRITE_BIT;
        }
        earlier = own;
    }
    barrier(recorder, recorder_build_stages(recorder) | earlier, own, writes, reads | writes);
}

static VkPipelineStageFlags stages_of_copies(const struct recorder *recorder)
{
    return (recorder->addresses ? VK_PIPELINE_STAGE_TRANSFER_BIT : 0) |
           (recorder->has_dispatched ? VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT : 0);
}

/* Makes the copies visible to the host. No command of the application waits. */
static void show_copies(const struct recorder *recorder)
{
    const struct recording *recording = recorder->recording;
    const struct own_dependency to_host = {
        .src = recorder->copy_stages,
        .dst = VK_PIPELINE_STAGE_HOST_BIT,
        .src_access = (recorder->addresses ? VK_ACCESS_TRANSFER_WRITE_BIT : 0) |
                      (recorder->has_dispatched ? VK_ACCESS_SHADER_WRITE_BIT : 0),
        .dst_access = VK_ACCESS_HOST_READ_BIT,
    };
    for (uint32_t i = recorder->first_chunk; i < recording->chunk_count; i++) {
        const struct staging_chunk *chunk = (const struct staging_chunk *)recording->chunks[i];
        if (chunk)
            recorder_order_buffer(recorder, chunk->buffer.handle, &to_host);
    }
}

void recorder_end(struct recorder *recorder)
{
    copy_orders_flush(recorder);
    copy_orders_mark(recorder);
    dispatches_end(recorder);
    if (!recorder->has_copied)
        return;
    recorder->copy_stages = stages_of_copies(recorder);
    if (recorder->device->snapshots->are_for_backend) {
        barrier(recorder,
                VK_PIPELINE_STAGE_TRANSFER_BIT |
                    (recorder->has_dispatched ? VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT : 0),
                VK_PIPELINE_STAGE_ALL_COMMANDS_BIT | VK_PIPELINE_STAGE_HOST_BIT,
                VK_ACCESS_TRANSFER_WRITE_BIT |
                    (recorder->has_dispatched ? VK_ACCESS_SHADER_WRITE_BIT : 0),
                VK_ACCESS_HOST_READ_BIT);
        return;
    }
    show_copies(recorder);
    recorder_mark_reached(recorder, recorder->copy_stages);
}

/* The application orders its next writes to the inputs after the stage of builds, so commands in
 * that stage must also wait for the copies. The build itself does not: the barrier comes behind it,
 * so that it does not wait for what precedes the copies. */
void recorder_end_call(const struct recorder *recorder)
{
    if (!recorder->device || !recorder->has_copied || recorder->device->snapshots->are_for_backend)
        return;
    recorder_mark_finished(recorder);
    barrier(recorder, recorder->copy_stages, recorder_build_stages(recorder), 0, 0);
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
        result = staging_take_part(device->snapshots->staging, size, chunk);
    } while (result == VK_NOT_READY && waits && execution_order_wait(device->order));
    return result;
}

/* The next chunk of a recording has twice the size of the last one, up to ROOM_MAX: a small
 * recording takes little of the budget, and a large one has few chunks. */
#define ROOM_MAX ((uint64_t)256 << 10)

static struct snapshot_chunk *last_chunk(const struct recording *recording)
{
    return recording->chunk_count ? recording->chunks[recording->chunk_count - 1] : NULL;
}

static uint64_t size_of_next(const struct recording *recording, uint64_t size)
{
    const struct snapshot_chunk *last = last_chunk(recording);
    uint64_t doubled = last ? 2 * last->size : 0;
    if (doubled > ROOM_MAX)
        doubled = ROOM_MAX;
    return size > doubled ? size : doubled;
}

/* The recording's last chunk if it has room for `size` bytes, or a new one. Returns NULL if there
 * is no memory or the budget is full. */
static struct staging_chunk *chunk_with_room(struct recorder *recorder, uint64_t size)
{
    struct recording *recording = recorder->recording;
    struct snapshot_chunk *last = last_chunk(recording);
    struct staging_chunk *chunk;
    if (last && size <= last->size - last->used)
        return (struct staging_chunk *)last;
    VkResult result = take_chunk(recorder->device, size_of_next(recording, size), &chunk);
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
