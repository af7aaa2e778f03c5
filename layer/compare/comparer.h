/* SPDX-License-Identifier: Apache-2.0 */
/* Comparing builds that have executed (setting compare_rays): the driver builds the same input
 * again in memory of the layer's own, and rays are traced through both that and the reference.
 *
 * Used by one thread at a time: who delivers executions. */
#ifndef ASSAY_LAYER_COMPARE_COMPARER_H
#define ASSAY_LAYER_COMPARE_COMPARER_H

#include "layer.h"
#include "snapshots/recording.h"

struct compare_enabling;

/* layer_device.comparer; NULL where nothing is compared. */
VkResult comparer_create(struct layer_device *device, const struct compare_enabling *enabling);
void comparer_destroy(struct comparer *comparer); /* NULL: nothing */

/* A build that has executed: of an input that is known, the bytes are copied, for snapshots are
 * locked only that long. `deaths` is the execution's. With a null comparer nothing. */
void comparer_keep(struct comparer *comparer, const struct journal *journal,
                   const struct recorded_item *item, const struct input_memory *memory,
                   uint64_t deaths);
/* Compares what was kept since, while the journals still live. With no lock held: messages go out,
 * and the queue is used. */
void comparer_run(struct comparer *comparer, VkQueue queue);

#endif
