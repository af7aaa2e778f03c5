/* SPDX-License-Identifier: Apache-2.0 */
/* Words in mapped memory, which the layer shares with the device: gates and marks of recordings
 * (src/snapshots/recording.h).
 *
 * They belong to their recording until it is released. So a command buffer that is resubmitted by
 * mistake reads and writes no words of another recording. */
#ifndef ASSAY_LAYER_SNAPSHOTS_MARKS_H
#define ASSAY_LAYER_SNAPSHOTS_MARKS_H

#include "layer/snapshots/recorder.h"
#include "layer/snapshots/snapshots.h"

/* The words of a device; usable from any thread. */
struct word_pool;

VkResult word_pool_create(const struct layer_device *device, struct word_pool **pool);
void word_pool_destroy(struct word_pool *pool); /* accepts NULL */

/* Takes words that are 0. Returns false without memory. */
bool words_take(struct word_pool *pool, struct mapped_words *words);

void words_give_back(struct word_pool *pool, const struct mapped_words *words);

/* ---- Marks around builds: words that the device writes before and behind the builds of a call, so
 * that the host sees how far it got if it is lost or hangs. Only on backend driver. */

/* Called behind the copies of a call, which are at the stages `copies`: records the first word.
 * Without memory, if the queue has no timestamps, or if executions at once would use the same
 * queries, the call has no mark. */
void recorder_mark_reached(const struct recorder *recorder, VkPipelineStageFlags copies);
/* Called behind the call itself: records the second word, if the first one was recorded. */
void recorder_mark_finished(const struct recorder *recorder);

/* ---- what the marks of a recording say */

enum mark_state {
    MARK_IS_UNKNOWN, /* the call has no mark, or several executions at once write it */
    MARK_IS_CLEAR,   /* the device has not executed the copies of the call's inputs */
    MARK_HAS_COPIES, /* the copies are complete, and the host can read them */
    MARK_HAS_BUILDS, /* the builds are complete, too */
};

/* Called before a submission: the marks are about that of `ticket` from now on. If the device may
 * still write them for another one (`is_pending`), they are about none. */
void recording_clear_marks(struct recording *recording, const struct ticket *ticket,
                           bool is_pending);
/* How far the device has got with the call of a build that has a mark (struct recorded_build: the
 * number of the mark, from 1; 0: none), in the submission with this ticket; 0: in the latest one. A
 * signal handler may call this. */
enum mark_state recording_mark_state(const struct recording *recording, uint32_t mark,
                                     uint64_t ticket);

#endif
