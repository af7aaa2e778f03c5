/* SPDX-License-Identifier: Apache-2.0 */
/* The commands that write marks, and what the marks say. */
#include "layer/snapshots/marks.h"

#include "layer/snapshots/words.h"
#include "src/base/array.h"

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

static void fill(const struct recorder *recorder, const struct mapped_words *mark, int word)
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
        !words_take(recorder->device->snapshots->words, &mark.words))
        return;
    mark.first = recorder->first_build;
    mark.last = recorder->first_build + recorder->build_count - 1;
    if (!add_mark(recorder->recording, &mark)) {
        words_give_back(recorder->device->snapshots->words, &mark.words);
        return;
    }
    fill(recorder, &mark.words, MARK_REACHED);
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
    fill(&recorder, &recording->marks.items[recording->marks.count - 1].words, MARK_FINISHED);
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
        words_clear(&marks->items[i].words);
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
    if (atomic_load(&mark->words.words[MARK_FINISHED]))
        return MARK_HAS_BUILDS;
    return atomic_load(&mark->words.words[MARK_REACHED]) ? MARK_HAS_COPIES : MARK_IS_CLEAR;
}
