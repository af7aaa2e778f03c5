/* SPDX-License-Identifier: Apache-2.0 */
/* The commands that write marks, and what the marks say. */
#include "layer/snapshots/marks.h"

#include "layer/snapshots/words.h"
#include "src/base/array.h"

/* ---- commands */

static bool add_mark(struct recording *recording, const struct build_mark *mark)
{
    struct build_marks *marks = &recording->marks;
    if (!ARRAY_HAS_ROOM(marks->items, marks->count, marks->capacity))
        return false;
    marks->items[marks->count++] = *mark;
    return true;
}

/* Writes a word when all earlier commands have completed a stage. A timestamp waits for the stage,
 * and the copy of its result waits for the timestamp, so that no command of the application waits:
 * a barrier before a fill would order the application's own transfers, too. */
static void write_after(const struct recorder *recorder, const struct mapped_words *words, int word,
                        VkPipelineStageFlagBits stage)
{
    const VkuDeviceDispatchTable *next = &recorder->device->snapshots->next;
    const uint32_t query = words->first_query + (word == MARK_FINISHED);
    next->CmdResetQueryPool(recorder->handle, words->queries, query, 1);
    next->CmdWriteTimestamp(recorder->handle, stage, words->queries, query);
    next->CmdCopyQueryPoolResults(recorder->handle, words->queries, query, 1, words->buffer,
                                  words->offset + (word - 1) * sizeof(uint32_t), sizeof(uint64_t),
                                  VK_QUERY_RESULT_WAIT_BIT | VK_QUERY_RESULT_WITH_AVAILABILITY_BIT);
}

static bool has_timestamps(const struct recorder *recorder)
{
    const struct layer_device *device = recorder->device;
    const uint32_t family = recorder->command_buffer->pool->queue_family;
    return family < device->queue_family_count && device->queue_families[family].timestampValidBits;
}

void recorder_mark_reached(const struct recorder *recorder, VkPipelineStageFlags copies)
{
    struct build_marks *marks = &recorder->recording->marks;
    struct build_mark mark;
    marks->is_open = false;
    if (!recorder->build_count || recorder->recording->executes_at_once ||
        !has_timestamps(recorder) || !words_take(recorder->device->snapshots->words, &mark.words))
        return;
    if (!add_mark(recorder->recording, &mark)) {
        words_give_back(recorder->device->snapshots->words, &mark.words);
        return;
    }
    struct journal_cursor cursor =
        journal_start_call(recorder->recording->journal, JOURNAL_COPIED_BUILDS);
    for (const struct journal_entry *entry; (entry = journal_next(&cursor));)
        if (journal_copies(entry))
            journal_copies(entry)->mark = marks->count;
    /* If there are both, the last dispatch waits for the transfers. */
    write_after(recorder, &mark.words, MARK_REACHED,
                copies & VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT ? VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT
                                                              : VK_PIPELINE_STAGE_TRANSFER_BIT);
    marks->is_open = true;
}

void recorder_mark_finished(const struct recorder *recorder)
{
    struct build_marks *marks = &recorder->recording->marks;
    if (!marks->is_open)
        return;
    write_after(recorder, &marks->items[marks->count - 1].words, MARK_FINISHED,
                VK_PIPELINE_STAGE_ACCELERATION_STRUCTURE_BUILD_BIT_KHR);
    marks->is_open = false;
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

enum mark_state recording_mark_state(const struct recording *recording, uint32_t mark,
                                     uint64_t ticket)
{
    uint64_t own = atomic_load(&recording->marks.ticket);
    if (!mark || !own || (ticket && own != ticket))
        return MARK_IS_UNKNOWN;
    _Atomic uint32_t *words = recording->marks.items[mark - 1].words.words;
    if (atomic_load(&words[MARK_FINISHED]))
        return MARK_HAS_BUILDS;
    return atomic_load(&words[MARK_REACHED]) ? MARK_HAS_COPIES : MARK_IS_CLEAR;
}
