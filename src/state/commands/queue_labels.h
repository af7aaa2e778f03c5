/* SPDX-License-Identifier: Apache-2.0 */
/* The debug labels that are open in the queues of a device, and the numbers of submissions. Has its
 * own lock. If memory runs out, a queue has neither labels nor numbers. */
#ifndef ASSAY_STATE_COMMANDS_QUEUE_LABELS_H
#define ASSAY_STATE_COMMANDS_QUEUE_LABELS_H

#include <stdatomic.h>
#include <stdint.h>

#include "src/state/commands/label_stack.h"

struct queue_labels;

/* The labels at one submission. Constant, and shared by the submissions with the same labels. */
struct shared_labels {
    atomic_uint references;
    struct label_stack stack;
};

VkResult queue_labels_create(struct queue_labels **labels);
void queue_labels_destroy(struct queue_labels *labels);

void queue_labels_push(struct queue_labels *labels, VkQueue queue,
                       const VkDebugUtilsLabelEXT *label);
void queue_labels_insert(struct queue_labels *labels, VkQueue queue,
                         const VkDebugUtilsLabelEXT *label);
void queue_labels_pop(struct queue_labels *labels, VkQueue queue);

/* Counts a submitting call. Returns its number, from 1; 0 without memory. Sets `open` to a
 * reference to the open labels, which the caller releases; NULL if there are none. */
uint64_t queue_labels_submit(struct queue_labels *labels, VkQueue queue,
                             struct shared_labels **open);

/* Both accept NULL. */
void shared_labels_release(struct shared_labels *labels);
static inline const struct label_stack *shared_labels_stack(const struct shared_labels *labels)
{
    return labels ? &labels->stack : NULL;
}

#endif
