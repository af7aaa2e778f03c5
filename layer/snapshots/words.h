/* SPDX-License-Identifier: Apache-2.0 */
/* Words in mapped memory, which the layer shares with the device: gates and marks of recordings
 * (src/snapshots/recording.h).
 *
 * They belong to their recording until it is released. So a command buffer that is resubmitted by
 * mistake reads and writes no words of another recording. */
#ifndef ASSAY_LAYER_SNAPSHOTS_WORDS_H
#define ASSAY_LAYER_SNAPSHOTS_WORDS_H

#include "layer/snapshots/snapshots.h"

/* The words of a device; usable from any thread. */
struct word_pool;

VkResult word_pool_create(const struct layer_device *device, struct word_pool **pool);
void word_pool_destroy(struct word_pool *pool); /* accepts NULL */

/* Takes words that are 0. Returns false without memory. */
bool words_take(struct word_pool *pool, struct mapped_words *words);
/* Sets all to 0. */
void words_clear(const struct mapped_words *words);
void words_give_back(struct word_pool *pool, const struct mapped_words *words);

#endif
