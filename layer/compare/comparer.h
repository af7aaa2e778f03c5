/* SPDX-License-Identifier: Apache-2.0 */
/* Compares executed builds (setting compare_rays): the driver builds the same input again in memory
 * of the layer, and rays are traced through that structure and through the reference.
 *
 * Only the thread that delivers executions uses a comparer. The inputs that it retains for
 * structures may be released on any thread. */
#ifndef ASSAY_LAYER_COMPARE_COMPARER_H
#define ASSAY_LAYER_COMPARE_COMPARER_H

#include "layer/layer.h"
#include "src/snapshots/recording.h"

struct compare_enabling;

/* Creates layer_device.comparer, which stays NULL if nothing is to be compared. */
VkResult comparer_create(struct layer_device *device, const struct compare_enabling *enabling);
/* Frees the comparer and warns if builds were not compared. The device must be idle. */
void comparer_destroy(struct comparer *comparer); /* `comparer` may be NULL */

/* How the records of structures refer to the inputs that comparers retain. */
extern const struct structure_inputs comparer_inputs;

/* A build that has executed. */
struct executed_input {
    const struct journal *journal;
    const struct journal_entry *entry; /* the build's entry; NULL if it has none */
    const struct recorded_build *build;
    const struct input_memory *memory;
    uint64_t destroy_count; /* the value at the time of execution */
};
/* Copies the bytes of the input if they are known, because the snapshots are locked only during
 * this call. Does nothing if `comparer` is NULL. */
void comparer_keep(struct comparer *comparer, const struct executed_input *executed);

/* Compares the retained builds while their journals are alive. The caller must hold no lock: this
 * function reports messages and submits to the queue. */
void comparer_run(struct comparer *comparer, VkQueue queue);

#endif
