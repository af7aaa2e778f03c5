/* SPDX-License-Identifier: Apache-2.0 */
/* Labels: the stack of a command buffer or queue, and labels and submissions by queue. */
#ifndef ASSAY_STATE_COMMANDS_LABEL_STACK_H
#define ASSAY_STATE_COMMANDS_LABEL_STACK_H

#include <stdatomic.h>
#include <stdbool.h>
#include <stdint.h>
#include <vulkan/vulkan_core.h>

struct label_stack {
    VkDebugUtilsLabelEXT *labels; /* innermost last; pLabelName owned, never NULL */
    uint32_t count, capacity;
    uint32_t left_out; /* open labels above the others for which memory ran out */
    uint32_t changes;  /* generation counter: bumped by every change, so copies can be compared */
    bool inserted;     /* the innermost label was inserted, and ends at the next label command */
};

/* `label` may be NULL, and may have no name. */
void label_stack_push(struct label_stack *stack, const VkDebugUtilsLabelEXT *label);
void label_stack_insert(struct label_stack *stack, const VkDebugUtilsLabelEXT *label);
void label_stack_pop(struct label_stack *stack);

/* Returns a copy that the caller owns. If memory runs out, inner labels are missing. */
struct label_stack label_stack_copy(const struct label_stack *stack);

/* Empties the stack and frees its memory. */
void label_stack_drop_all(struct label_stack *stack);
static inline bool label_stack_is_clear(const struct label_stack *stack)
{
    return !stack->labels && !stack->left_out;
}
static inline void label_stack_clear(struct label_stack *stack)
{
    if (!label_stack_is_clear(stack))
        label_stack_drop_all(stack);
}

/* ---- The debug labels that are open in the queues of a device, and the numbers of submissions.
 * Has its own lock. If memory runs out, a queue has neither labels nor numbers. */

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

/* What messages and records say of a submission. */
struct submission_origin {
    VkQueue queue;                /* VK_NULL_HANDLE: the host, or no submission */
    uint64_t number;              /* of the call among those of the queue, from 1; 0: unknown */
    uint64_t frame;               /* presentations on the device before it; 0: none, or unknown */
    struct shared_labels *labels; /* that were open in the queue; NULL: none, or forgotten */
};

/* Counts a submitting call, and describes it. The caller releases the reference to the labels. */
struct submission_origin queue_labels_submit(struct queue_labels *labels, VkQueue queue);

/* All accept NULL. */
struct shared_labels *shared_labels_share(struct shared_labels *labels);
void shared_labels_release(struct shared_labels *labels);
static inline const struct label_stack *shared_labels_stack(const struct shared_labels *labels)
{
    return labels ? &labels->stack : NULL;
}

#endif
