/* SPDX-License-Identifier: Apache-2.0 */
/* Blocks of marks, a list of unused ones, and the commands that write them.
 *
 * A mark belongs to its recording until the recording is released, so a command buffer that is
 * submitted again by mistake writes nothing that belongs to others. */
#include "layer/snapshots/marks.h"

#include <stdlib.h>

#include "src/base/array.h"

enum { BLOCK_MARKS = 1024, MARK_SIZE = MARK_WORDS * sizeof(uint32_t) };

struct mark_block {
    struct mark_block *next;
    struct own_buffer buffer;
};

struct marks {
    const struct layer_device *device;
    pthread_mutex_t lock; /* guards the members below; held while a block is created */
    struct mark_block *blocks;
    struct build_mark *free; /* has room for all marks */
    uint32_t free_count, count;
};

/* ---- words */

VkResult marks_create(const struct layer_device *device, struct marks **marks)
{
    *marks = calloc(1, sizeof(**marks));
    if (!*marks)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    (*marks)->device = device;
    pthread_mutex_init(&(*marks)->lock, NULL);
    return VK_SUCCESS;
}

static void free_block(const struct layer_device *device, struct mark_block *block)
{
    const struct own_device own = snapshots_own_device(device->snapshots);
    own_buffer_free(&own, &block->buffer);
    free(block);
}

void marks_destroy(struct marks *marks)
{
    if (!marks)
        return;
    while (marks->blocks) {
        struct mark_block *block = marks->blocks;
        marks->blocks = block->next;
        free_block(marks->device, block);
    }
    pthread_mutex_destroy(&marks->lock);
    free(marks->free);
    free(marks);
}

static struct mark_block *create_block(const struct layer_device *device)
{
    const struct own_device own = snapshots_own_device(device->snapshots);
    struct mark_block *block = calloc(1, sizeof(*block));
    if (!block)
        return NULL;
    if (own_buffer_create(&own, VK_BUFFER_USAGE_TRANSFER_DST_BIT, BLOCK_MARKS * MARK_SIZE, true,
                          &block->buffer) == VK_SUCCESS)
        return block;
    free_block(device, block);
    return NULL;
}

/* Called with the lock held. */
static bool add_block(struct marks *marks)
{
    struct build_mark *grown = realloc(marks->free, (marks->count + BLOCK_MARKS) * sizeof(*grown));
    if (!grown)
        return false;
    marks->free = grown;
    struct mark_block *block = create_block(marks->device);
    if (!block)
        return false;
    block->next = marks->blocks;
    marks->blocks = block;
    _Atomic uint32_t *words = (_Atomic uint32_t *)(void *)block->buffer.bytes;
    for (uint32_t i = 0; i < BLOCK_MARKS; i++)
        marks->free[marks->free_count++] = (struct build_mark){.words = words + i * MARK_WORDS,
                                                               .buffer = block->buffer.handle,
                                                               .offset = i * (uint64_t)MARK_SIZE};
    marks->count += BLOCK_MARKS;
    return true;
}

static bool take(struct marks *marks, struct build_mark *mark)
{
    pthread_mutex_lock(&marks->lock);
    bool has_one = marks->free_count || add_block(marks);
    if (has_one)
        *mark = marks->free[--marks->free_count];
    pthread_mutex_unlock(&marks->lock);
    for (int word = 0; has_one && word < MARK_WORDS; word++)
        atomic_store(&mark->words[word], 0);
    return has_one;
}

void marks_give_back(struct marks *marks, const struct build_mark *mark)
{
    pthread_mutex_lock(&marks->lock);
    marks->free[marks->free_count++] = *mark;
    pthread_mutex_unlock(&marks->lock);
}

/* ---- commands */

static bool add_mark(struct recording *recording, const struct build_mark *mark)
{
    struct build_marks *marks = &recording->marks;
    struct build_mark *items =
        array_make_room(marks->items, marks->count, &marks->capacity, sizeof(*items));
    if (!items)
        return false;
    marks->items = items;
    marks->items[marks->count++] = *mark;
    return true;
}

static void fill(const struct recorder *recorder, const struct build_mark *mark, int word)
{
    recorder->device->snapshots->next.CmdFillBuffer(
        recorder->handle, mark->buffer, mark->offset + (uint64_t)word * sizeof(uint32_t),
        sizeof(uint32_t), 1);
}

void recorder_mark_reached(const struct recorder *recorder)
{
    struct build_marks *marks = &recorder->recording->marks;
    struct build_mark mark;
    marks->is_open = false;
    if (recorder->device->snapshots->are_for_backend || !recorder->build_count ||
        !take(recorder->device->snapshots->marks, &mark))
        return;
    mark.first = recorder->first_build;
    mark.last = recorder->first_build + recorder->build_count - 1;
    if (!add_mark(recorder->recording, &mark)) {
        marks_give_back(recorder->device->snapshots->marks, &mark);
        return;
    }
    fill(recorder, &mark, MARK_REACHED);
    marks->is_open = true;
}

/* The barrier delays no build: only transfers wait for it. */
void recorder_mark_finished(VkCommandBuffer handle)
{
    struct layer_device *device = layer_find_recording_device(handle);
    struct recording *recording = device ? recording_of(device, handle) : NULL;
    if (!recording || !recording->marks.is_open)
        return;
    const struct recorder recorder = {.device = device, .handle = handle};
    const VkMemoryBarrier barrier = {
        .sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER,
        .srcAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT,
        .dstAccessMask = VK_ACCESS_HOST_READ_BIT,
    };
    device->snapshots->next.CmdPipelineBarrier(
        handle,
        VK_PIPELINE_STAGE_TRANSFER_BIT | VK_PIPELINE_STAGE_ACCELERATION_STRUCTURE_BUILD_BIT_KHR,
        VK_PIPELINE_STAGE_TRANSFER_BIT | VK_PIPELINE_STAGE_HOST_BIT, 0, 1, &barrier, 0, NULL, 0,
        NULL);
    fill(&recorder, &recording->marks.items[recording->marks.count - 1], MARK_FINISHED);
    recording->marks.is_open = false;
}

/* ---- what the marks of a recording say */

void recording_clear_marks(struct recording *recording, const struct ticket *ticket,
                           bool is_pending)
{
    struct build_marks *marks = &recording->marks;
    uint64_t number = ticket ? ticket->number : 0;
    bool is_only = !is_pending && atomic_load(&marks->ticket) != number;
    for (uint32_t i = 0; is_only && i < marks->count; i++)
        for (int word = 0; word < MARK_WORDS; word++)
            atomic_store(&marks->items[i].words[word], 0);
    atomic_store(&marks->ticket, is_only ? number : 0);
}

/* Returns NULL if the build has none. */
static const struct build_mark *find_mark(const struct build_marks *marks, uint32_t position)
{
    uint32_t low = 0, high = marks->count;
    while (low < high) {
        uint32_t middle = (low + high) / 2;
        if (marks->items[middle].first <= position)
            low = middle + 1;
        else
            high = middle;
    }
    return low && position <= marks->items[low - 1].last ? &marks->items[low - 1] : NULL;
}

enum mark_state recording_mark_state(const struct recording *recording, uint32_t position,
                                     uint64_t ticket)
{
    uint64_t own = atomic_load(&recording->marks.ticket);
    const struct build_mark *mark = find_mark(&recording->marks, position);
    if (!mark || !own || (ticket && own != ticket))
        return MARK_IS_UNKNOWN;
    if (atomic_load(&mark->words[MARK_FINISHED]))
        return MARK_HAS_BUILDS;
    return atomic_load(&mark->words[MARK_REACHED]) ? MARK_HAS_COPIES : MARK_IS_CLEAR;
}
