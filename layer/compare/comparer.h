/* SPDX-License-Identifier: Apache-2.0 */
/* Comparing builds that have executed (setting compare_rays): the driver builds the same input
 * again in memory of the layer's own, and rays are traced through both that and the reference.
 *
 * Used by one thread at a time, who delivers executions, but for comparer_note_copy(). */
#ifndef ASSAY_LAYER_COMPARE_COMPARER_H
#define ASSAY_LAYER_COMPARE_COMPARER_H

#include "layer/layer.h"
#include "src/snapshots/recording.h"

struct compare_enabling;

/* layer_device.comparer; NULL where nothing is compared. */
VkResult comparer_create(struct layer_device *device, const struct compare_enabling *enabling);
void comparer_destroy(struct comparer *comparer); /* NULL: nothing */

/* A build that has executed. */
struct executed_input {
    const struct journal *journal;
    const struct journal_entry *entry; /* its own; NULL: it has none */
    const struct recorded_item *item;
    const struct input_memory *memory;
    uint64_t destroy_count; /* the execution's */
};
/* Of an input that is known, the bytes are copied, for snapshots are locked only that long. With a
 * null comparer nothing. */
void comparer_keep(struct comparer *comparer, const struct executed_input *executed);

/* Compares what was kept since, while the journals still live. With no lock held: messages go out,
 * and the queue is used. */
void comparer_run(struct comparer *comparer, VkQueue queue);

/* A copy of structures was recorded: from any thread. What it is of is looked up when an instance
 * refers to it. */
void comparer_note_recorded_copy(struct comparer *comparer, const struct journal_entry *entry);
static inline void comparer_note_copy(struct comparer *comparer, const struct journal_entry *copy)
{
    if (comparer)
        comparer_note_recorded_copy(comparer, copy);
}

#endif
